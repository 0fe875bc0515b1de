//! Files of all encodings, of which boxes are read by way of scratch, and disks that have no room for it.

use super::*;
use crate::volume::{read_volume_with, write_volume};
use crate::{LayerFile, VolumeSource};
use fastrand::Rng;
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{Grid, Samples, Scaling, Volume};
use slabsplat_seeds::for_each_seed;
use std::fs;
use std::io::Write;
use std::sync::Mutex;

fn layer(path: PathBuf, options: &VolumeOptions) -> LayerFile {
    LayerFile { options: options.clone(), ..LayerFile::of_volume(VolumeSource::File(path)) }
}

/// Boxes of a file are those of the whole, and the file is one that is unpacked for them, or is not.
fn check(path: &Path, options: &VolumeOptions, rng: &mut Rng, is_unpacked: bool) {
    let whole = read_volume_with(path, options).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let scratch = ScratchDesc::default().folder(folder.path());
    let boxes = layer(path.to_owned(), options).open_boxes(&scratch).unwrap();
    let grid = whole.volume.grid();
    assert_eq!((boxes.grid(), boxes.scratch().is_some()), (*grid, is_unpacked), "{path:?}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "the file has no name");
    let first = boxes.first();
    assert_eq!((first.format, first.acquisition), (whole.format, whole.acquisition));
    assert_eq!((&first.warnings, &first.choices), (&whole.warnings, &whole.choices));
    for _ in 0..4 {
        let voxels = grid.dims().map(|n| {
            let first = rng.usize(..n);
            first..rng.usize(first + 1..=n)
        });
        let LoadedVolume { volume: of, colors, .. } = boxes.read(voxels.clone()).unwrap();
        assert_eq!(*of.grid(), grid.cropped(&voxels));
        assert_eq!(of.scaling(), whole.volume.scaling());
        assert_eq!(of.sample_type(), whole.volume.sample_type(), "{path:?}");
        let own = [&whole.colors, &colors].map(|colors| colors.as_ref().map(|of| &of.voxels));
        let all = (0..of.grid().n_voxels()).all(|idx| {
            let at = of.grid().voxel_coords(idx);
            let [i, j, k] = [0, 1, 2].map(|axis| at[axis] + voxels[axis].start);
            let [nx, ny, _] = grid.dims();
            let of_whole = (k * ny + j) * nx + i;
            let has_color = match own {
                [Some(Some(whole)), Some(Some(own))] => whole.at(of_whole) == own.at(idx),
                [whole, own] => whole.is_none() && own.is_none(),
            };
            has_color && of.value(idx).to_bits() == whole.volume.value(of_whole).to_bits()
        });
        assert!(all, "{path:?} {voxels:?}");
    }
    let [nx, ..] = grid.dims();
    assert!(boxes.read([0..nx + 1, 0..1, 0..1]).is_err());
}

fn samples(rng: &mut Rng, n: usize) -> Samples {
    match rng.u8(..4) {
        0 => (0..n).map(|_| rng.u8(..)).collect::<Vec<_>>().into(),
        1 => (0..n).map(|_| rng.i16(..)).collect::<Vec<_>>().into(),
        2 => (0..n).map(|_| rng.f32()).collect::<Vec<_>>().into(),
        _ => (0..n).map(|_| rng.u16(..)).collect::<Vec<_>>().into(),
    }
}

fn volume(rng: &mut Rng) -> Volume {
    let dims = [0; 3].map(|_| 1 + rng.usize(..20));
    let turned = DMat3::from_diagonal(DVec3::new(0.5, 2.0, 1.25));
    let place = DAffine3::from_mat3_translation(turned, DVec3::new(3.0, -4.0, 5.0));
    let samples = samples(rng, dims.iter().product());
    Volume::new(Grid::new(dims, place).unwrap(), samples, Scaling::IDENTITY).unwrap()
}

fn packed(path: &Path) -> PathBuf {
    let to = PathBuf::from(format!("{}.gz", path.display()));
    let file = File::create(&to).unwrap();
    let mut encoder = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
    encoder.write_all(&fs::read(path).unwrap()).unwrap();
    encoder.finish().unwrap();
    to
}

#[test]
fn scratch_boxes_are_those_of_the_whole() {
    for_each_seed(12, |mut rng| {
        let dir = tempfile::tempdir().unwrap();
        let volume = volume(&mut rng);
        let options = VolumeOptions::default();
        let files = [("a.nii.gz", true), ("a.nii", false), ("a.nrrd", true), ("a.npy", false)];
        for (name, is_unpacked) in files {
            let path = dir.path().join(name);
            write_volume(&path, &volume).unwrap();
            check(&path, &options, &mut rng, is_unpacked);
        }
        check(&packed(&dir.path().join("a.npy")), &options, &mut rng, true);
        let path = dir.path().join("a.mha");
        write_volume(&path, &volume).unwrap();
        let is_packed = layer(path.clone(), &options).open_boxes(&ScratchDesc::default()).unwrap();
        check(&path, &options, &mut rng, is_packed.scratch().is_some());
    });
}

/// Other encodings, data in several files, and times and channels of which one is read.
#[test]
fn scratch_of_all_encodings() {
    let dir = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(4);
    let sizes = "dimension: 4\nsizes: 2 3 4 5\nkinds: vector space space space\nendian: big\n";
    let bytes: Vec<u8> = (0..240_u32).map(|at| (at * 7 % 251) as u8).collect();
    let numbers = |bytes: &[u8]| {
        let pairs = bytes.chunks_exact(2).map(|b| i16::from_be_bytes([b[0], b[1]]).to_string());
        pairs.collect::<Vec<_>>().join(" ").into_bytes()
    };
    let hex = |bytes: &[u8]| bytes.iter().map(|b| format!("{b:02x}")).collect::<String>();
    let bzip2 = |bytes: &[u8]| {
        let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    for (encoding, data) in [
        ("text", numbers(&bytes)),
        ("hex", hex(&bytes).into_bytes()),
        ("bzip2", bzip2(&bytes)),
        ("raw", bytes.clone()),
    ] {
        let path = dir.path().join("a.nrrd");
        let header = format!("NRRD0004\ntype: int16\n{sizes}encoding: {encoding}\n\n");
        fs::write(&path, [header.as_bytes(), &data].concat()).unwrap();
        for channel in [0, 1] {
            let options = VolumeOptions::default().channel(channel);
            check(&path, &options, &mut rng, true);
        }
    }
    for (idx, slice) in bytes.chunks(80).enumerate() {
        fs::write(dir.path().join(format!("s{idx}.raw")), slice).unwrap();
    }
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 10 3\nencoding: raw\n\
                  data file: s%d.raw 0 2 1\n";
    let path = dir.path().join("b.nhdr");
    fs::write(&path, header).unwrap();
    check(&path, &VolumeOptions::default(), &mut rng, true);
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 8 10 3\nElementType = MET_UCHAR\n\
                  ElementDataFile = all.raw\n";
    fs::write(dir.path().join("all.raw"), &bytes).unwrap();
    let path = dir.path().join("c.mhd");
    fs::write(&path, header).unwrap();
    check(&path, &VolumeOptions::default(), &mut rng, false);
}

/// Colours with alpha that is the same everywhere and that is not, and integers that become each of three
/// types: what they become is known when all have been looked at.
#[test]
fn scratch_of_what_is_known_at_the_end() {
    let dir = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(5);
    let mut checked = |path: &Path, is_unpacked| {
        check(path, &VolumeOptions::default(), &mut rng, is_unpacked);
    };
    for (n, is_even) in [(3, false), (4, false), (4, true)] {
        let path = dir.path().join("colors.nrrd");
        let values = |at: usize| if is_even && at % 4 == 3 { 7 } else { (at * 37 % 251) as u8 };
        let kind = ["RGB-color", "RGBA-color"][n - 3];
        let header = format!(
            "NRRD0004\ntype: uint8\ndimension: 4\nsizes: {n} 5 4 6\nkinds: {kind} space space space\n\
             encoding: raw\n\n"
        );
        let bytes: Vec<u8> = (0..n * 120).map(values).collect();
        fs::write(&path, [header.as_bytes(), &bytes].concat()).unwrap();
        checked(&path, false);
        let loaded = crate::read_volume(&path).unwrap();
        let path = dir.path().join("colors.npy");
        crate::write_colored_volume(&path, &loaded.volume, loaded.colors.as_ref().unwrap())
            .unwrap();
        checked(&path, false);
        checked(&packed(&path), true);
    }
    for least in [-3_i64, 0, i64::from(i32::MIN) - 1] {
        for most in [9, i64::from(u32::MAX), 1 << 54] {
            let numbers = (0..60).map(|at| if at == 41 { most } else { least.max(at - 50) });
            let numbers = numbers.map(|n| if n == least.max(-9) { least } else { n });
            let bytes: Vec<u8> = numbers.flat_map(i64::to_be_bytes).collect();
            let path = dir.path().join("wide.nrrd");
            let header =
                "NRRD0004\ntype: int64\ndimension: 3\nsizes: 3 4 5\nendian: big\nencoding: raw\n\n";
            fs::write(&path, [header.as_bytes(), &bytes].concat()).unwrap();
            checked(&path, true);
        }
    }
}

/// What real scanners and microscopes wrote, slice by slice.
#[test]
fn scratch_of_real_files() {
    let mut rng = Rng::with_seed(6);
    let mut n_checked = 0;
    for name in ["tiff", "dicom", "nrrd", "mha", "nifti"] {
        let Some(folder) = slabsplat_testdata::volume(name) else {
            println!("skipped: there is no folder of data {name}");
            continue;
        };
        for path in volumes_in(&folder) {
            let options = VolumeOptions::default();
            let listed = crate::list_volume(&path, &options);
            if listed.is_ok_and(|of| !of.choices.is_color && of.bytes() < 20 << 20) {
                let boxes = layer(path.clone(), &options).open_boxes(&ScratchDesc::default());
                let is_unpacked = boxes.unwrap().scratch().is_some();
                check(&path, &options, &mut rng, is_unpacked);
                n_checked += 1;
            }
        }
    }
    println!("{n_checked} volumes");
}

/// Files, and folders that are volumes of many.
fn volumes_in(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && read_volume_with(&path, &VolumeOptions::default()).is_err() {
            found.extend(volumes_in(&path));
        } else {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn error_of(path: &Path, scratch: &ScratchDesc) -> String {
    let opened = layer(path.to_owned(), &VolumeOptions::default()).open_boxes(scratch);
    opened.unwrap_err().to_string()
}

#[test]
fn scratch_says_what_it_cannot() {
    let dir = tempfile::tempdir().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let scratch = ScratchDesc::default().folder(folder.path());
    let path = dir.path().join("a.nii.gz");
    let mut rng = Rng::with_seed(2);
    let grid = Grid::with_spacing([9, 10, 11], [1.0; 3]).unwrap();
    let bytes: Vec<u8> = (0..990).map(|_| rng.u8(..)).collect();
    let volume = Volume::new(grid, bytes.into(), Scaling::IDENTITY).unwrap();
    write_volume(&path, &volume).unwrap();
    let expect = |scratch: &ScratchDesc, path: &Path, expected: &str| {
        let found = error_of(path, scratch);
        assert!(found.contains(expected), "{found}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    };
    let heard = Arc::new(Mutex::new(Vec::new()));
    let inside = heard.clone();
    let told = scratch.clone().on_use(move |of| inside.lock().unwrap().push(of.clone()));
    expect(&told.clone().most_bytes(989), &path, "takes 990 bytes of scratch, and 989 bytes are");
    expect(&told.clone().folder(dir.path().join("none")), &path, "No such file");
    expect(&told.clone().refused(), &path, "a packed file cannot be read box by box");
    assert_eq!(heard.lock().unwrap().len(), 0, "nothing was unpacked so far");
    let header = |rest: &str| format!("NRRD0004\nencoding: hex\nendian: little\n{rest}\n\n");
    let nrrd = |name: &str, rest: &str, digits: usize| {
        let path = dir.path().join(name);
        fs::write(&path, header(rest) + &"01".repeat(digits)).unwrap();
        path
    };
    let huge = nrrd("huge.nrrd", "type: uint8\ndimension: 3\nsizes: 1000 1000 1000", 24);
    expect(&scratch.clone().most_bytes(1 << 40), &huge, "huge.nrrd: ");
    // Cut off, it is known to be when it has been unpacked; nothing of it is left.
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    expect(&told, &path, "needs 990 bytes");
    let heard = heard.lock().unwrap().clone();
    assert_eq!((heard.len(), heard[0].n_bytes, &heard[0].path), (1, 990, &path));
}

/// A disk that fills while a volume is unpacked.
#[cfg(target_os = "linux")]
#[test]
fn scratch_of_a_full_disk() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["a.nrrd", "a.npy"] {
        let path = dir.path().join(name);
        let grid = Grid::with_spacing([90, 70, 50], [1.0; 3]).unwrap();
        let zeros = Samples::U16(vec![0; grid.n_voxels()]);
        write_volume(&path, &Volume::new(grid, zeros, Scaling::IDENTITY).unwrap()).unwrap();
        let path = if name == "a.npy" { packed(&path) } else { path };
        let options = VolumeOptions::default();
        let Found { reader, path, options } = formats::find(Store::Disk, &path, &options).unwrap();
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let spill = Some(Spill::new(full));
        let input = Input { store: Store::Disk, path: &path, options: &options, spill };
        let folder = PathBuf::from("elsewhere");
        let of = ScratchUse { path: path.clone(), folder, n_bytes: 1, is_in_memory: false };
        let error = Scratch::filled(reader, &input, of).unwrap_err().to_string();
        let expected = "it cannot be unpacked into elsewhere: No space left on device";
        assert!(error.contains(expected), "{error}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn scratch_in_memory_is_known() {
    if Path::new("/dev/shm").is_dir() {
        assert!(is_in_memory(Path::new("/dev/shm")));
    }
    assert!(!is_in_memory(Path::new("/proc")));
    assert!(0 < free_bytes(&std::env::temp_dir()).unwrap());
}
