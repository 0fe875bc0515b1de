//! HDF5 files that h5py and netCDF4 wrote, whole and spoilt: `hdf5/make.py` made them.
#![cfg(feature = "hdf5")]

mod peak;

use std::io::Read;
use std::path::Path;

use peak::check_peak;
use slabsplat_io::{FilesInMemory, LoadedVolume, VolumeFormat, VolumeOptions};
use slabsplat_seeds::for_each_seed;

/// Changes tried on each file.
const N_MUTATIONS: usize = 300;

fn unpacked(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/hdf5/{name}.gz"));
    let mut bytes = Vec::new();
    let packed = std::fs::File::open(path).expect("it is in the repository");
    flate2::read::GzDecoder::new(packed).read_to_end(&mut bytes).expect("it is packed");
    bytes
}

fn read(name: &str, path: &str, options: &VolumeOptions) -> Result<LoadedVolume, String> {
    let bytes = unpacked(name);
    let path = if path.is_empty() { name.to_owned() } else { format!("{name}:{path}") };
    let files = FilesInMemory::from_iter([(name, bytes.as_slice())]);
    files.read_volume_with(path, options).map_err(|error| error.to_string())
}

fn values(loaded: &LoadedVolume) -> Vec<f64> {
    let volume = &loaded.volume;
    (0..volume.grid().n_voxels()).map(|voxel_idx| volume.value(voxel_idx)).collect()
}

/// 0, 1, … 59, as all arrays hold but those that say otherwise.
fn counted() -> Vec<f64> {
    (0..60).map(f64::from).collect()
}

#[test]
fn hdf5_of_every_type() {
    for endian in ["little", "big"] {
        for (kind, expected) in [
            ("u1", "uint8"),
            ("i1", "int8"),
            ("u2", "uint16"),
            ("i2", "int16"),
            ("u4", "uint32"),
            ("i4", "int32"),
            ("u8", "int32"),
            ("i8", "int32"),
            ("f2", "float32"),
            ("f4", "float32"),
            ("f8", "float64"),
        ] {
            let path = format!("/{endian}/{kind}");
            let loaded = read("classic.h5", &path, &VolumeOptions::default()).unwrap();
            assert_eq!(loaded.format, VolumeFormat::Hdf5);
            assert_eq!(loaded.volume.grid().dims(), [5, 4, 3], "{path}");
            assert_eq!(loaded.volume.samples().sample_type().name(), expected, "{path}");
            assert_eq!(values(&loaded), counted(), "{path}");
        }
    }
    let truth = read("classic.h5", "bool", &VolumeOptions::default()).unwrap();
    assert_eq!(values(&truth)[..3], [1.0, 0.0, 1.0]);
}

#[test]
fn hdf5_in_every_layout() {
    for (name, path) in [
        ("classic.h5", "packed/a"),
        ("classic.h5", "packed/grows"),
        ("newer.h5", "fixed"),
        ("newer.h5", "one_grows"),
        ("newer.h5", "sums"),
        ("kinds.h5", "scaled"),
        ("kinds.h5", "scaled_floats"),
        ("kinds.h5", "lzf"),
        ("kinds.h5", "unpacked"),
        ("kinds.h5", "shrunk"),
        ("kinds.h5", "sized"),
        ("newest.h5", "plain"),
        ("a.nc", "density"),
        ("a.mat", "a"),
    ] {
        let loaded = read(name, path, &VolumeOptions::default()).unwrap();
        assert_eq!(values(&loaded), counted(), "{name}:{path}");
    }
    let sparse = read("newer.h5", "sparse", &VolumeOptions::default()).unwrap();
    let written = |idx: usize| (20..30).contains(&idx);
    let expected = (0..60).map(|idx| if written(idx) { idx as f64 } else { -7.0 });
    assert_eq!(values(&sparse), expected.collect::<Vec<_>>());
    let options = VolumeOptions::default().channel(2).time(1);
    let five = read("newer.h5", "five", &options).unwrap();
    let expected: Vec<f64> = counted().into_iter().map(|value| value + 500.0).collect();
    assert_eq!(values(&five), expected);
}

#[test]
fn hdf5_voxels_have_sizes() {
    let packed = read("classic.h5", "packed/a", &VolumeOptions::default()).unwrap();
    assert_eq!(packed.warnings, [""; 0]);
    let check = |loaded: &LoadedVolume, expected: [f64; 3]| {
        let spacing = loaded.volume.grid().spacing();
        assert!(spacing.iter().zip(expected).all(|(s, e)| (s - e).abs() < 1e-12), "{spacing:?}");
    };
    check(&packed, [0.5e-3, 1e-3, 2e-3]);
    let whole = read("kinds.h5", "sized", &VolumeOptions::default()).unwrap();
    check(&whole, [1e-3, 2e-3, 3e-3]);
    let plain = read("classic.h5", "little/u1", &VolumeOptions::default()).unwrap();
    assert!(plain.warnings[0].contains("1 x 1 x 1 was assumed"), "{:?}", plain.warnings);
}

#[test]
fn hdf5_data_sets_are_chosen() {
    let default = read("a.nc", "", &VolumeOptions::default()).unwrap();
    assert_eq!(default.choices.series.names, ["density"]);
    let second = read("newer.h5", "", &VolumeOptions::default().series(1)).unwrap();
    let expected = ["five", "fixed", "one_grows", "sparse", "sums", "two_grow"];
    assert_eq!(second.choices.series.names, expected);
    assert_eq!(values(&second), counted());
    let error = read("newer.h5", "fixd", &VolumeOptions::default()).unwrap_err();
    let expected =
        "newer.h5: there is no data set \"fixd\": there is five 2 x 3 x 3 x 4 x 5, fixed 3 x";
    assert!(error.starts_with(expected), "{error}");
    for (path, expected) in [("text", "holds no numbers"), ("time", "1 axes is no volume")] {
        let error = read("classic.h5", path, &VolumeOptions::default()).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn hdf5_that_is_not_read_says_what_helps() {
    for (name, path, expected) in [
        ("newer.h5", "two_grow", "its chunks are listed in the form of HDF5 1.10"),
        ("newest.h5", "packed", "it is in the form of HDF5 2.0"),
        ("kinds.h5", "szip", "its chunks are packed by szip"),
        ("kinds.h5", "n_bit", "its chunks are packed by n-bit"),
        ("kinds.h5", "virtual", "it is put together from others"),
        ("kinds.h5", "external", "its samples are in another file"),
    ] {
        let error = read(name, path, &VolumeOptions::default()).unwrap_err();
        assert!(error.starts_with(&format!("{name}: {expected}")), "{error}");
        assert!(error.contains("which is not read: save it by Python: numpy.save("), "{error}");
    }
    let link = read("kinds.h5", "link", &VolumeOptions::default()).unwrap_err();
    assert!(link.starts_with("kinds.h5: there is no data set \"link\""), "{link}");
}

#[test]
fn hdf5_that_is_spoilt_never_panics() {
    for_each_seed(1, |mut rng| {
        for name in ["classic.h5", "newer.h5", "kinds.h5", "a.nc"] {
            let whole = unpacked(name);
            let mut n_refused = 0;
            for _ in 0..N_MUTATIONS {
                let mut bytes = whole.clone();
                for _ in 0..rng.usize(1..=4) {
                    let at = rng.usize(0..bytes.len());
                    match rng.u8(0..4) {
                        0 => bytes.truncate(at + 1),
                        1 => bytes[at] = rng.u8(..),
                        2 => bytes[at] ^= 1 << rng.u8(0..8),
                        _ => bytes[at] = 0xff,
                    }
                }
                let files = FilesInMemory::from_iter([(name, bytes.as_slice())]);
                let paths =
                    ["packed/a", "one_grows", "scaled", "lzf"].map(|path| format!("{name}:{path}"));
                for path in paths.iter().map(String::as_str).chain([name]) {
                    if let Err(error) = files.read_volume(path) {
                        assert!(!error.to_string().contains('\n'), "more than a line: {error}");
                        n_refused += 1;
                    }
                }
            }
            assert!(0 < n_refused, "{name}");
            check_peak(name);
        }
    });
}
