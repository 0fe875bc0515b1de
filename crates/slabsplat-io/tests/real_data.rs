//! Real volumes, as the README beside them describes them, and the scenes that show them.

use std::path::Path;

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Modality, Orientation, SampleType, Volume};
use slabsplat_io::{LoadedVolume, VolumeFormat, VolumeSource, read_scene, read_volume};

/// A line of the README. The mean is given to as many digits as the README has.
struct Expected {
    path: &'static str,
    dims: [usize; 3],
    sample_type: SampleType,
    spacing: [f64; 3],
    range: [f64; 2],
    mean: f64,
    mean_digit: f64,
    format: VolumeFormat,
}

const VOLUMES: &[Expected] = &[
    Expected {
        path: "nifti/mni152_t1_1mm_uint8.nii.gz",
        dims: [197, 233, 189],
        sample_type: SampleType::U8,
        spacing: [1.0; 3],
        range: [0.0, 255.0],
        mean: 38.44,
        mean_digit: 0.01,
        format: VolumeFormat::Nifti1,
    },
    Expected {
        path: "nifti/mni152_2009c_t1_1mm_int16.nii.gz",
        dims: [193, 229, 193],
        sample_type: SampleType::I16,
        spacing: [1.0; 3],
        range: [0.0, 1570.0],
        mean: 167.1,
        mean_digit: 0.1,
        format: VolumeFormat::Nifti1,
    },
    Expected {
        path: "nifti/head_t1_mr_uint8_slope.nii.gz",
        dims: [160, 232, 160],
        sample_type: SampleType::U8,
        spacing: [1.0, 0.898437, 0.898437],
        range: [0.0, 512.0],
        mean: 111.8,
        mean_digit: 0.1,
        format: VolumeFormat::Nifti1,
    },
    Expected {
        path: "nifti/engine_256x256x128_uint8.nii.gz",
        dims: [256, 256, 128],
        sample_type: SampleType::U8,
        spacing: [1.0; 3],
        range: [0.0, 255.0],
        mean: 20.69,
        mean_digit: 0.01,
        format: VolumeFormat::Nifti1,
    },
    Expected {
        path: "nrrd/embryo_256_uint8.nrrd",
        dims: [256; 3],
        sample_type: SampleType::U8,
        spacing: [1.0; 3],
        range: [0.0, 197.0],
        mean: 3.80,
        mean_digit: 0.01,
        format: VolumeFormat::Nrrd,
    },
    Expected {
        path: "nrrd/stroke_flair_1mm_uint8.nrrd",
        dims: [124, 160, 140],
        sample_type: SampleType::U8,
        spacing: [1.0; 3],
        range: [0.0, 255.0],
        mean: 41.49,
        mean_digit: 0.01,
        format: VolumeFormat::Nrrd,
    },
    Expected {
        path: "nrrd/headsq/quarter.nhdr",
        dims: [64, 64, 93],
        sample_type: SampleType::I16,
        spacing: [3.2, 3.2, 1.5],
        range: [0.0, 3926.0],
        mean: 507.7,
        mean_digit: 0.1,
        format: VolumeFormat::Nrrd,
    },
    Expected {
        path: "nrrd/headsq_64x64x93_int16.nrrd",
        dims: [64, 64, 93],
        sample_type: SampleType::I16,
        spacing: [3.2, 3.2, 1.5],
        range: [0.0, 3926.0],
        mean: 507.7,
        mean_digit: 0.1,
        format: VolumeFormat::Nrrd,
    },
    Expected {
        path: "nrrd/tooth/tooth.nhdr",
        dims: [103, 94, 161],
        sample_type: SampleType::U16,
        spacing: [1.0; 3],
        range: [0.0, 1300.0],
        mean: 526.9,
        mean_digit: 0.1,
        format: VolumeFormat::Nrrd,
    },
    Expected {
        path: "mha/ct_lung_115x157x129_int16.mha",
        dims: [115, 157, 129],
        sample_type: SampleType::I16,
        spacing: [1.366, 1.366, 2.5],
        range: [-1255.0, 1474.0],
        mean: -351.7,
        mean_digit: 0.1,
        format: VolumeFormat::MetaImage,
    },
    Expected {
        path: "mha/fuel.mha",
        dims: [68; 3],
        sample_type: SampleType::U8,
        spacing: [1.0; 3],
        range: [0.0, 255.0],
        mean: 1.62,
        mean_digit: 0.01,
        format: VolumeFormat::MetaImage,
    },
    Expected {
        path: "mha/nucleon.mha",
        dims: [41; 3],
        sample_type: SampleType::U8,
        spacing: [1.0; 3],
        range: [0.0, 249.0],
        mean: 39.4,
        mean_digit: 0.1,
        format: VolumeFormat::MetaImage,
    },
    Expected {
        path: "mha/marschnerlobb.mha",
        dims: [43; 3],
        sample_type: SampleType::U8,
        spacing: [1.0; 3],
        range: [0.0, 255.0],
        mean: 110.2,
        mean_digit: 0.1,
        format: VolumeFormat::MetaImage,
    },
    Expected {
        path: "mha/HeadMRVolume.mhd",
        dims: [48, 62, 42],
        sample_type: SampleType::U8,
        spacing: [4.0; 3],
        range: [0.0, 255.0],
        mean: 24.5,
        mean_digit: 0.1,
        format: VolumeFormat::MetaImage,
    },
    Expected {
        path: "tiff/ct_phantom_aniso.ome.tif",
        dims: [175, 248, 58],
        sample_type: SampleType::U8,
        spacing: [0.8125, 0.8125, 2.39705],
        range: [0.0, 255.0],
        mean: 38.0,
        mean_digit: 0.1,
        format: VolumeFormat::Tiff,
    },
    Expected {
        path: "dicom/ct_phantom_head",
        dims: [512, 512, 28],
        sample_type: SampleType::U16,
        spacing: [0.451172, 0.451172, 5.0],
        range: [-1024.0, 782.0],
        mean: -830.6,
        mean_digit: 0.1,
        format: VolumeFormat::Dicom,
    },
    Expected {
        path: "raw/ct_thorax_256x256x133_uint8.json",
        dims: [256, 256, 133],
        sample_type: SampleType::U8,
        spacing: [1.40625, 1.40625, 2.5],
        range: [0.0, 255.0],
        mean: 7.05,
        mean_digit: 0.01,
        format: VolumeFormat::Raw,
    },
];

/// The volume, where it is; otherwise a sentence says that it is skipped.
fn load(path: &str) -> Option<LoadedVolume> {
    slabsplat_testdata::volume(path).map(|path| read_volume(&path).expect("the file is valid"))
}

fn mean(volume: &Volume) -> f64 {
    let n_voxels = volume.grid().n_voxels();
    (0..n_voxels).map(|voxel_idx| volume.value(voxel_idx)).sum::<f64>() / n_voxels as f64
}

#[test]
fn real_volumes_say_how_they_stand() {
    use Orientation::{Anatomical, Pictures, Unknown};
    for (path, modality, orientation, is_metric) in [
        ("nifti/mni152_t1_1mm_uint8.nii.gz", None, Anatomical, true),
        ("mha/ct_lung_115x157x129_int16.mha", None, Anatomical, true),
        ("mha/fuel.mha", None, Unknown, false),
        ("mha/HeadMRVolume.mhd", None, Unknown, false),
        ("nrrd/stroke_flair_1mm_uint8.nrrd", None, Anatomical, true),
        ("nrrd/headsq/quarter.nhdr", None, Unknown, false),
        ("tiff/ct_phantom_aniso.ome.tif", None, Pictures, true),
        ("dicom/ct_phantom_head", Some(Modality::Ct), Anatomical, true),
    ] {
        let Some(loaded) = load(path) else { continue };
        let found = loaded.acquisition;
        let found = (found.modality, found.orientation, found.is_metric);
        assert_eq!(found, (modality, orientation, is_metric), "{path}");
    }
}

#[test]
fn real_volumes_are_as_described() {
    for expected in VOLUMES {
        let Some(loaded) = load(expected.path) else { continue };
        let (path, volume) = (expected.path, &loaded.volume);
        assert_eq!(volume.grid().dims(), expected.dims, "{path}");
        assert_eq!(volume.sample_type(), expected.sample_type, "{path}");
        assert_eq!(loaded.format, expected.format, "{path}");
        assert_eq!(loaded.warnings, [""; 0], "{path}");
        for (actual, expected) in volume.grid().spacing().into_iter().zip(expected.spacing) {
            assert!((actual - expected).abs() < 1e-5, "{path}: spacing {actual}, not {expected}");
        }
        let summary = volume.summary();
        for (actual, expected) in summary.range.unwrap().into_iter().zip(expected.range) {
            assert!((actual - expected).abs() < 1e-3, "{path}: {actual}, not {expected}");
        }
        assert_eq!(summary.n_nan, 0, "{path}");
        let mean = mean(volume);
        let off = (mean - expected.mean).abs();
        assert!(off <= 0.51 * expected.mean_digit, "{path}: mean {mean}, not {}", expected.mean);
    }
}

/// What other programs read of them, as `reference/values.py` printed it.
const VALUES: &str = include_str!("reference/values.tsv");

/// Columns have six or eight digits, and places four after the point.
const MAX_ROUNDING: f64 = 1e-5;
const MAX_OFF_MILLIMETRES: f64 = 1e-3;

#[test]
fn real_volumes_are_as_other_programs_read_them() {
    for line in VALUES.lines().skip(1) {
        let [path, dims, range, mean_of_all, first, last, values] =
            line.split('\t').collect::<Vec<_>>()[..]
        else {
            panic!("seven columns: {line}")
        };
        let Some(loaded) = load(path) else { continue };
        let volume = &loaded.volume;
        let size = volume.grid().dims();
        assert_eq!(numbers(dims), size.map(|n| n as f64), "{path}");
        let check = |what: &str, actual: &[f64], expected: &str| {
            let is_near = |(a, e): (&f64, &f64)| (a - e).abs() <= MAX_ROUNDING * e.abs().max(1.0);
            let expected = numbers(expected);
            let all_are_near = actual.iter().zip(&expected).all(is_near);
            assert!(
                all_are_near && actual.len() == expected.len(),
                "{path}: {what} {actual:?}, not {expected:?}"
            );
        };
        check("range", &volume.summary().range.unwrap(), range);
        check("mean", &[mean(volume)], mean_of_all);
        let at = |k: usize| {
            let [x, y, z] = [size[0] * k / 6, size[1] * (6 - k) / 6, size[2] * k / 6];
            volume.value(x + size[0] * (y + size[1] * z))
        };
        check("values", &[1, 2, 3, 4, 5].map(at), values);
        for (index, expected) in [([0; 3], first), (size.map(|n| n - 1), last)] {
            if expected == "-" {
                continue;
            }
            let index = DVec3::from_array(index.map(|i| i as f64));
            let place = volume.grid().world_from_index().transform_point3(index);
            let off = place - DVec3::from_slice(&numbers(expected));
            assert!(off.length() <= MAX_OFF_MILLIMETRES, "{path}: {place}, not {expected}");
        }
    }
}

fn numbers(text: &str) -> Vec<f64> {
    text.split(' ').map(|number| number.parse().expect("a number")).collect()
}

#[test]
fn real_slices_equal_single_file() {
    let (Some(slices), Some(single)) =
        (load("nrrd/headsq/quarter.nhdr"), load("nrrd/headsq_64x64x93_int16.nrrd"))
    else {
        return;
    };
    assert!(slices.volume.samples() == single.volume.samples(), "the voxels differ");
    assert_eq!(slices.volume.grid(), single.volume.grid());
}

#[test]
fn real_raw_is_found_by_its_data_too() {
    let Some(loaded) = load("raw/ct_thorax_256x256x133_uint8.raw") else {
        return;
    };
    assert_eq!(loaded.volume.grid().dims(), [256, 256, 133]);
}

/// The file's first direction is (−0.99, 0.05, −0.10) in LPS, so x and y change sign.
#[test]
fn real_lps_becomes_ras() {
    let Some(loaded) = load("nrrd/stroke_flair_1mm_uint8.nrrd") else {
        return;
    };
    let affine = loaded.volume.grid().world_from_index();
    let x = affine.matrix3.x_axis;
    assert!((x.x - 0.993_592).abs() < 1e-6 && (x.y + 0.049_705).abs() < 1e-6, "{x}");
    assert!((x.z + 0.101_510).abs() < 1e-6, "{x}");
    let origin = affine.translation;
    assert!((origin.x + 64.898_239).abs() < 1e-6 && (origin.z + 27.925_539).abs() < 1e-6);
}

#[test]
fn real_scenes_parse() {
    for &name in slabsplat_testdata::SCENES {
        let Some(path) = slabsplat_testdata::scene(name) else { continue };
        let scene = read_scene(&path).unwrap();
        let VolumeSource::File(volume) = &scene.layers[0].volume else {
            panic!("{name} has a file")
        };
        assert!(volume.is_file(), "{}", volume.display());
        assert!(scene.layers[0].transfer.is_some(), "{name}");
        assert_eq!(scene.camera.is_perspective(), name == "embryo-perspective");
    }
}

/// Its voxel size was not recorded.
#[test]
fn real_tiff_warns_of_its_voxel_size() {
    let Some(loaded) = load("tiff/neuron_409x415x119_uint8.tif") else {
        return;
    };
    assert_eq!(loaded.volume.grid().dims(), [409, 415, 119]);
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    assert!((mean(&loaded.volume) - 0.105).abs() < 5e-4);
}

#[test]
fn real_files_of_other_formats_are_refused() {
    let text = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let err = read_volume(&text).unwrap_err().to_string();
    assert!(err.contains("is not a volume file that can be read"), "{err}");
}
