//! Volumes of which a box of voxels is read: what comes is what the whole volume has there, and where files
//! lack it they say so.

#![expect(clippy::unwrap_used, reason = "functions of tests are tests, too")]

use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{Grid, SampleType, Samples, Volume};
use slabsplat_io::{
    Endian, LayerFile, RawDesc, ScratchDesc, VolumeOptions, VolumeSource, read_volume,
    read_volume_with, write_volume,
};
use slabsplat_seeds::for_each_seed;
use std::fs;
use std::ops::Range;
use std::path::Path;

const DIMS: [usize; 3] = [13, 7, 9];

fn volume() -> Volume {
    let grid = Grid::with_spacing(DIMS, [1.0, 0.5, 2.0]).unwrap();
    Volume::from_fn(grid, |[i, j, k]| (1000 * i + 31 * j + k) as i16 - 500)
}

/// Its data behind its header, as they are.
fn write_nrrd(path: &Path) {
    let header = "NRRD0004\ntype: int16\ndimension: 3\nsizes: 13 7 9\nspacings: 1 0.5 2\n\
                  encoding: raw\nendian: little\n\n";
    let Samples::I16(samples) = volume().samples().clone() else { panic!("they are") };
    let bytes = samples.into_iter().flat_map(i16::to_le_bytes);
    fs::write(path, header.bytes().chain(bytes).collect::<Vec<u8>>()).unwrap();
}

fn random_box(rng: &mut fastrand::Rng, dims: [usize; 3]) -> [Range<usize>; 3] {
    dims.map(|n| {
        let first = rng.usize(..n);
        first..rng.usize(first + 1..=n)
    })
}

fn check(path: &Path, rng: &mut fastrand::Rng) {
    let whole = read_volume(path).unwrap().volume;
    for _ in 0..20 {
        let voxels = random_box(rng, whole.grid().dims());
        let options = VolumeOptions::default().voxels(voxels.clone());
        let loaded = read_volume_with(path, &options).unwrap();
        let expected = whole.cropped(&voxels);
        let name = path.display();
        assert_eq!(loaded.volume.samples(), expected.samples(), "{name} {voxels:?}");
        assert_eq!(loaded.volume.grid(), expected.grid(), "{name} {voxels:?}");
        assert_eq!(loaded.volume.scaling(), whole.scaling(), "{name}");
    }
}

#[test]
fn boxes_of_files_are_what_the_whole_has() {
    let dir = tempfile::tempdir().unwrap();
    write_volume(dir.path().join("a.nii"), &volume()).unwrap();
    write_nrrd(&dir.path().join("a.nrrd"));
    let bytes: Vec<u8> =
        (0..DIMS.iter().product::<usize>() as u16).flat_map(u16::to_be_bytes).collect();
    let by_name = format!("b_{}x{}x{}_u16be.raw", DIMS[0], DIMS[1], DIMS[2]);
    fs::write(dir.path().join(&by_name), &bytes).unwrap();
    let described = r#"{"file": "c.raw", "dims": [13, 7, 18], "type": "uint16", "endian": "big",
        "header_bytes": 5}"#;
    fs::write(dir.path().join("c.json"), described).unwrap();
    let two_times = "NRRD0004\ntype: uint16\ndimension: 4\nsizes: 13 7 9 2\nencoding: raw\nendian: big\n\
                     byte skip: 5\ndata file: c.raw\n";
    fs::write(dir.path().join("c.nhdr"), two_times).unwrap();
    fs::write(dir.path().join("c.raw"), [&[9; 5][..], &bytes, &bytes].concat()).unwrap();
    for_each_seed(1, |mut rng| {
        for name in ["a.nrrd", "a.nii", "c.json", by_name.as_str(), "c.nhdr"] {
            check(&dir.path().join(name), &mut rng);
        }
    });
}

/// Chunks of 5 × 4 × 3, of which some are not there.
fn write_zarr(folder: &Path) {
    fs::create_dir(folder).unwrap();
    let array = r#"{"zarr_format": 2, "shape": [9, 7, 13], "chunks": [3, 4, 5], "dtype": "<u2",
        "compressor": null, "fill_value": 77, "order": "C", "filters": null}"#;
    fs::write(folder.join(".zarray"), array).unwrap();
    for (z, y, x) in (0..3).flat_map(|z| (0..2).flat_map(move |y| (0..3).map(move |x| (z, y, x)))) {
        if (z + y + x) % 4 != 3 {
            let chunk: Vec<u8> =
                (0..60_u16).flat_map(|n| (n + 100 * z + 31 * y + 7 * x).to_le_bytes()).collect();
            fs::write(folder.join(format!("{z}.{y}.{x}")), chunk).unwrap();
        }
    }
}

#[test]
fn boxes_of_chunks_are_what_the_whole_has() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("a.zarr");
    write_zarr(&folder);
    for_each_seed(1, |mut rng| check(&folder, &mut rng));
    // Of a box that has no chunk the fill value, without a word.
    let nowhere = VolumeOptions::default().voxels([10..13, 4..7, 0..3]);
    let loaded = read_volume_with(&folder, &nowhere).unwrap();
    assert!((0..27).all(|voxel_idx| loaded.volume.value(voxel_idx) == 77.0));
    // A damaged chunk is named, by boxes that meet it and by no others.
    fs::write(folder.join("1.0.0"), [1, 2, 3]).unwrap();
    let met = VolumeOptions::default().voxels([4..6, 0..2, 2..4]);
    let error = read_volume_with(&folder, &met).unwrap_err().to_string();
    assert!(error.contains("1.0.0"), "{error}");
    let beside = VolumeOptions::default().voxels([5..13, 4..7, 2..4]);
    assert!(read_volume_with(&folder, &beside).is_ok());
}

/// An image of several levels.
fn write_levels(folder: &Path, levels: &[Volume]) {
    fs::create_dir(folder).unwrap();
    let mut datasets = Vec::new();
    for (idx, level) in levels.iter().enumerate() {
        let alone = folder.with_extension(format!("{idx}.zarr"));
        write_volume(&alone, level).unwrap();
        fs::rename(alone.join("0"), folder.join(idx.to_string())).unwrap();
        let ([x, y, z], first) =
            (level.grid().spacing(), level.grid().world_from_index().translation);
        datasets.push(format!(
            r#"{{"path": "{idx}", "coordinateTransformations": [{{"type": "scale", "scale": [{z}, {y}, {x}]}},
                {{"type": "translation", "translation": [{}, {}, {}]}}]}}"#,
            first.z, first.y, first.x
        ));
    }
    let axes =
        ["z", "y", "x"].map(|name| format!(r#"{{"name": "{name}", "type": "space"}}"#)).join(", ");
    let datasets = datasets.join(", ");
    let text = format!(r#"{{"multiscales": [{{"axes": [{axes}], "datasets": [{datasets}]}}]}}"#);
    fs::write(folder.join(".zattrs"), text).unwrap();
}

/// A level of a volume of 40 × 24 × 16 voxels, begun so far off the middle of the first ones that it stands
/// for.
fn level(factor: usize, off: f64) -> Volume {
    let middle = (factor as f64 - 1.0) / 2.0 + off;
    let place = DAffine3::from_translation(DVec3::splat(middle))
        * DAffine3::from_scale(DVec3::splat(factor as f64));
    let grid = Grid::new([40, 24, 16].map(|n| n / factor), place).unwrap();
    Volume::from_fn(grid, move |[i, j, k]| (factor * (i + 3 * j + 5 * k)) as u8)
}

#[test]
fn coarser_levels_stand_for_finer_ones_of_the_same_place() {
    let dir = tempfile::tempdir().unwrap();
    let open = |name: &str, levels: &[Volume]| {
        let path = dir.path().join(name);
        write_levels(&path, levels);
        LayerFile::of_volume(VolumeSource::File(path)).open_boxes(&ScratchDesc::default()).unwrap()
    };
    let of_all = open("all.zarr", &[1, 2, 4, 8].map(|factor| level(factor, 0.0)));
    for (least_voxels, factor) in [(1, 8), (30, 8), (31, 4), (240, 4), (241, 2), (1920, 2)] {
        let coarser = of_all.coarser(least_voxels).unwrap().expect("there is one");
        let expected = level(factor, 0.0);
        assert_eq!(coarser.grid(), *expected.grid(), "{least_voxels}");
        let [nx, ny, nz] = coarser.grid().dims();
        let read = coarser.read([0..nx, 0..ny, 0..nz]).unwrap().volume;
        assert_eq!(read.samples(), expected.samples());
    }
    assert!(of_all.coarser(1921).unwrap().is_none(), "the finest has more, and is no coarser one");
    // As by those who write no translation.
    let off = open("off.zarr", &[level(1, 0.0), level(2, -0.5), level(4, -1.5)]);
    assert_eq!(off.coarser(1).unwrap().unwrap().grid().dims(), [10, 6, 4]);
    let elsewhere = open("elsewhere.zarr", &[level(1, 0.0), level(2, 1.0), level(4, 9.0)]);
    assert_eq!(elsewhere.coarser(1).unwrap().unwrap().grid().dims(), [20, 12, 8]);
    let grid = *level(2, 0.0).grid();
    let other_type = open("type.zarr", &[level(1, 0.0), Volume::from_fn(grid, |_| 1.0_f32)]);
    assert!(other_type.coarser(1).unwrap().is_none());
}

#[test]
fn boxes_that_cannot_be_read_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let error = |name: &str, voxels| {
        let options = VolumeOptions::default().voxels(voxels);
        read_volume_with(dir.path().join(name), &options).unwrap_err().to_string()
    };
    for name in ["a.nii.gz", "a.nii"] {
        write_volume(dir.path().join(name), &volume()).unwrap();
    }
    write_nrrd(&dir.path().join("a.nrrd"));
    let packed = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n\n";
    fs::write(dir.path().join("b.nrrd"), packed).unwrap();
    let packed = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n\
                  CompressedData = True\nElementDataFile = LOCAL\n";
    fs::write(dir.path().join("b.mha"), packed).unwrap();
    for name in ["a.nii.gz", "b.mha", "b.nrrd"] {
        let text = error(name, [0..1, 0..1, 0..1]);
        assert!(text.contains("box by box") && text.contains(".zarr"), "{text}");
    }
    for voxels in [[0..14, 0..1, 0..1], [0..1, 3..3, 0..1], [0..1, 0..1, 9..10]] {
        let text = error("a.nrrd", voxels);
        assert!(text.contains("no voxels"), "{text}");
    }
    // A file that is cut off, before anything of it is read.
    let path = dir.path().join("a.nii");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    let text = error("a.nii", [0..1, 0..1, 0..1]);
    assert!(text.contains("cut off"), "{text}");
}

/// By a layer of a scene, whose spacing counts, and whose file may be raw.
#[test]
fn boxes_of_layers_have_their_spacing() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.raw");
    let bytes: Vec<u8> = (0..DIMS.iter().product::<usize>()).map(|n| n as u8).collect();
    fs::write(&path, &bytes).unwrap();
    let voxels = [2..5, 1..3, 4..9];
    let mut layer = LayerFile::of_volume(VolumeSource::File(path));
    layer.raw = Some(RawDesc::new(DIMS, SampleType::U8).endian(Endian::Little));
    layer.spacing = Some([2.0, 3.0, 4.0]);
    let whole = layer.load_volume().unwrap().volume;
    layer.options.voxels = Some(voxels.clone());
    let part = layer.load_volume().unwrap().volume;
    assert_eq!(
        (part.grid(), part.samples()),
        (&whole.grid().cropped(&voxels), whole.cropped(&voxels).samples())
    );
    let nrrd = dir.path().join("a.nrrd");
    write_nrrd(&nrrd);
    let mut layer = LayerFile::of_volume(VolumeSource::File(nrrd));
    layer.spacing = Some([2.0, 3.0, 4.0]);
    layer.options.voxels = Some(voxels);
    let part = layer.load_volume().unwrap().volume;
    assert_eq!(part.grid().spacing(), [2.0, 3.0, 4.0]);
    let first = part.grid().world_from_index().translation;
    assert_eq!(first, DVec3::new(4.0, 3.0, 16.0));
}
