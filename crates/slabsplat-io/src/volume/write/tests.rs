//! What is written is read again, and is what it was.

use std::path::Path;

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{Grid, Sample, SampleType, Samples, Scaling, Volume, with_samples};
use slabsplat_seeds::for_each_seed;

use super::*;
use crate::{LoadedVolume, read_volume};

const EXTENSIONS: &[&str] = &["nrrd", "nii", "nii.gz", "mha", "npy", "raw", "zarr"];

/// Any samples of a type, with its extremes.
fn samples(sample_type: SampleType, n: usize, rng: &mut fastrand::Rng) -> Samples {
    match sample_type {
        SampleType::U8 => (0..n).map(|_| rng.u8(..)).collect::<Vec<_>>().into(),
        SampleType::I8 => (0..n).map(|_| rng.i8(..)).collect::<Vec<_>>().into(),
        SampleType::U16 => (0..n).map(|_| rng.u16(..)).collect::<Vec<_>>().into(),
        SampleType::I16 => (0..n).map(|_| rng.i16(..)).collect::<Vec<_>>().into(),
        SampleType::U32 => (0..n).map(|_| rng.u32(..)).collect::<Vec<_>>().into(),
        SampleType::I32 => (0..n).map(|_| rng.i32(..)).collect::<Vec<_>>().into(),
        SampleType::F32 => (0..n).map(|_| rng.f32() * 1e30 - 7.0).collect::<Vec<_>>().into(),
        SampleType::F64 => (0..n).map(|_| rng.f64() * 1e300 - 7.0).collect::<Vec<_>>().into(),
    }
}

/// Axes that are stretched, turned, sheared and mirrored, by numbers that 32-bit floats have.
fn places() -> Vec<(DAffine3, bool)> {
    let origin = DVec3::new(-12.5, 30.25, 7.0);
    let place = |x: DVec3, y: DVec3, z: DVec3| {
        DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), origin)
    };
    vec![
        (place(DVec3::X * 0.5, DVec3::Y * 1.5, DVec3::Z * 2.25), true),
        (place(DVec3::X * -0.5, DVec3::Y * -1.5, DVec3::Z * 2.0), true),
        (place(DVec3::X, DVec3::Y, DVec3::Z * -2.0), true),
        (place(DVec3::Z * 2.0, DVec3::X * -0.5, DVec3::Y), false),
        (place(DVec3::X, DVec3::new(0.25, 1.0, 0.0), DVec3::new(0.0, 0.5, 2.0)), false),
    ]
}

fn again(path: &Path, volume: &Volume) -> (LoadedVolume, Vec<String>) {
    let warnings = write_volume(path, volume).unwrap_or_else(|error| panic!("{error}"));
    (read_volume(path).unwrap_or_else(|error| panic!("{error}")), warnings)
}

#[test]
fn write_and_read_every_type_and_place() {
    for_each_seed(1, |mut rng| {
        let dir = tempfile::tempdir().unwrap();
        for &sample_type in SampleType::ALL {
            for (place, is_upright) in places() {
                let dims = [rng.usize(1..80), rng.usize(1..7), rng.usize(1..7)];
                let grid = Grid::new(dims, place).unwrap();
                let samples = samples(sample_type, grid.n_voxels(), &mut rng);
                let volume = Volume::new(grid, samples, Scaling::IDENTITY).unwrap();
                for extension in EXTENSIONS {
                    let path = dir.path().join(format!("a.{extension}"));
                    let (loaded, warnings) = again(&path, &volume);
                    let what = format!("{extension} {sample_type:?} {place:?}");
                    assert_eq!(loaded.volume.samples(), volume.samples(), "{what}");
                    let is_kept = match *extension {
                        "npy" => false,
                        "zarr" => is_upright,
                        _ => true,
                    };
                    assert_eq!(warnings.is_empty(), is_kept, "{what}: {warnings:?}");
                    if is_kept {
                        check_place(loaded.volume.grid(), &grid, *extension == "mha", &what);
                    }
                }
            }
        }
    });
}

/// MetaImage has directions and spacings by themselves, whose product is rounded once.
fn check_place(got: &Grid, expected: &Grid, is_rounded: bool, what: &str) {
    assert_eq!(got.dims(), expected.dims(), "{what}");
    let (got, expected) = (got.world_from_index(), expected.world_from_index());
    let tolerance = if is_rounded { 1e-15 } else { 0.0 };
    assert!(got.abs_diff_eq(expected, tolerance), "{what}: {got:?}");
}

/// Numbers with all their digits come back as they were in the formats that have them as text.
#[test]
fn write_keeps_every_bit_of_places() {
    let dir = tempfile::tempdir().unwrap();
    for_each_seed(20, |mut rng| {
        let mut step = |least: f64| least + rng.f64();
        let diagonal = DVec3::new(step(0.1), step(2.0), step(50.0));
        let mut place = DAffine3::from_mat3(DMat3::from_diagonal(diagonal));
        place.translation = DVec3::new(step(-90.0), step(1e-3), step(1e3));
        let skew = DMat3::from_cols(DVec3::X, DVec3::new(step(-0.5), 1.0, 0.0), DVec3::Z);
        for (extension, place) in
            [("zarr", place), ("raw", DAffine3::from_mat3(skew) * place), ("nrrd", place)]
        {
            let grid = Grid::new([2, 3, 1], place).unwrap();
            let volume = Volume::new(grid, vec![0_u8; 6].into(), Scaling::IDENTITY).unwrap();
            let (loaded, _) = again(&dir.path().join(format!("a.{extension}")), &volume);
            assert_eq!(loaded.volume.grid(), &grid, "{extension}");
        }
    });
}

#[test]
fn write_keeps_values_where_there_is_no_slope() {
    let dir = tempfile::tempdir().unwrap();
    let grid = Grid::with_spacing([3, 1, 1], [1.0; 3]).unwrap();
    let check = |samples: Samples, slope: f64, intercept: f64, expected: SampleType| {
        let volume = Volume::new(grid, samples, Scaling { slope, intercept }).unwrap();
        for extension in EXTENSIONS {
            let (loaded, warnings) = again(&dir.path().join(format!("a.{extension}")), &volume);
            let has_slope = ["nii", "nii.gz", "raw"].contains(extension);
            let of = if has_slope { volume.sample_type() } else { expected };
            assert_eq!(loaded.volume.sample_type(), of, "{extension}");
            let is_rounded = warnings.iter().any(|warning| warning.contains("32-bit floats"));
            let tolerance = if is_rounded || of == SampleType::F32 { 1e-6 } else { 0.0 };
            for voxel_idx in 0..3 {
                let (got, kept) = (loaded.volume.value(voxel_idx), volume.value(voxel_idx));
                assert!((got - kept).abs() <= tolerance * kept.abs(), "{extension}: {got} {kept}");
            }
        }
    };
    check(vec![0_u16, 4095, 24].into(), 1.0, -1024.0, SampleType::I16);
    check(vec![0_u16, 65535, 24].into(), 1.0, -1024.0, SampleType::I32);
    check(vec![0_u8, 255, 7].into(), 2.00784, 0.0, SampleType::F32);
    check(vec![0_i32, 255, 7].into(), 0.25, 0.5, SampleType::F64);
}

/// By bytes, so that other programs can read them whatever this one does.
#[test]
fn write_has_the_bytes_of_the_format() {
    let dir = tempfile::tempdir().unwrap();
    let grid = Grid::with_spacing([2, 1, 1], [1.0, 2.0, 3.0]).unwrap();
    let volume = Volume::new(grid, vec![1_i16, -2].into(), Scaling::IDENTITY).unwrap();
    let bytes = |name: &str| {
        write_volume(dir.path().join(name), &volume).unwrap();
        std::fs::read(dir.path().join(name)).unwrap()
    };
    assert!(bytes("a.npy").ends_with(b"\n\x01\x00\xfe\xff"));
    assert_eq!(bytes("a.npy").len(), 132);
    assert!(bytes("a.mha").ends_with(b"ElementDataFile = LOCAL\n\x01\x00\xfe\xff"));
    assert_eq!(bytes("a.nii")[344..], *b"n+1\0\0\0\0\0\x01\x00\xfe\xff");
    assert!(bytes("a.nii.gz").starts_with(&[0x1f, 0x8b]));
    let nrrd = bytes("a.nrrd");
    assert!(nrrd.starts_with(b"NRRD0005\ntype: int16\n"), "{}", String::from_utf8_lossy(&nrrd));
    assert_eq!(bytes("a.raw"), [1, 0, 0xfe, 0xff]);
}

#[test]
fn write_uses_version_two_for_long_axes() {
    let dir = tempfile::tempdir().unwrap();
    let grid = Grid::with_spacing([40_000, 1, 1], [0.1; 3]).unwrap();
    let volume = Volume::new(grid, vec![7_u8; 40_000].into(), Scaling::IDENTITY).unwrap();
    let (loaded, warnings) = again(&dir.path().join("a.nii.gz"), &volume);
    assert!(warnings[0].contains("NIfTI-2"), "{warnings:?}");
    assert_eq!(loaded.volume.grid(), volume.grid());
}

#[test]
fn write_replaces_what_it_may_and_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let small = crate::builtin_volume("cube", Some(12)).unwrap();
    let large = crate::builtin_volume("cube", Some(70)).unwrap();
    for extension in EXTENSIONS {
        let path = dir.path().join(format!("a.{extension}"));
        write_volume(&path, &large).unwrap();
        let (loaded, _) = again(&path, &small);
        assert_eq!(loaded.volume.samples(), small.samples(), "{extension}");
    }
    let mine = dir.path().join("mine.zarr");
    std::fs::create_dir(&mine).unwrap();
    std::fs::write(mine.join("letter.txt"), "dear").unwrap();
    let error = write_volume(&mine, &small).unwrap_err().to_string();
    assert!(error.contains("is no Zarr"), "{error}");
    assert!(mine.join("letter.txt").exists());
    let error = write_volume(dir.path().join("a.png"), &small).unwrap_err().to_string();
    assert!(error.contains("name the volume .nrrd"), "{error}");
    let mut names: Vec<String> = std::fs::read_dir(dir.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected =
        ["a.json", "a.mha", "a.nii", "a.nii.gz", "a.npy", "a.nrrd", "a.raw", "a.zarr", "mine.zarr"];
    assert_eq!(names, expected);
    assert!(with_samples!(small.samples(), |s| s.iter().any(|v| v.to_f64() != 0.0)));
}
