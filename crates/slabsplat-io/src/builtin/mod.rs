//! Volumes that are computed, not read: what the tests, the demo and the paper's figures need
//! without any file.
//!
//! All are centred: spacing 1, and the middle of the grid at the world's origin.

mod cube;
mod marschner_lobb;
mod neuron;
mod shepp_logan;
mod sphere;

use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{Grid, SampleType, Samples, Scaling, Volume};

use crate::IoError;

/// The built-in volumes, as [`builtin_volume`] and scene files name them.
pub const BUILTIN_NAMES: &[&str] = &["cube", "sphere", "marschner-lobb", "shepp-logan", "neuron"];

/// Fewer voxels a side than this hold none of the shapes.
const MIN_SIZE: usize = 4;

/// A gigavoxel: the largest that a machine of today makes in passable time.
const MAX_SIZE: usize = 1024;

/// How a built-in volume is made: its usual size, and its samples at any size.
struct Builtin {
    default_size: usize,
    sample_type: SampleType,
    samples: fn(usize) -> Samples,
}

/// The built-in volume `name` with `size` voxels a side, or as many as suit it.
///
/// | name | what | usual size | type and range |
/// | --- | --- | --- | --- |
/// | `cube` | the paper's binary cube, 16 of 28 voxels a side | 28 | `uint8`, 0 or 255 |
/// | `sphere` | a ball whose edge is four voxels soft | 64 | `uint8`, 0 … 255 |
/// | `marschner-lobb` | the reconstruction test signal | 41 | `float32`, 0 … 1 |
/// | `shepp-logan` | the head phantom in three dimensions | 96 | `uint8`, 0 … 255 |
/// | `neuron` | a nerve cell with branching dendrites | 128 | `uint8`, 0 … 255 |
///
/// # Errors
/// If there is no such volume, or `size` is not within 4 … 1024.
pub fn builtin_volume(name: &str, size: Option<usize>) -> Result<Volume, IoError> {
    let (builtin, size) = find(name, size)?;
    let samples = (builtin.samples)(size);
    Ok(Volume::new(centered_grid(size), samples, Scaling::IDENTITY)
        .expect("a built-in volume has a sample for each voxel"))
}

/// Bytes of the samples of such a volume, if it can be made.
pub(crate) fn builtin_bytes(name: &str, size: Option<usize>) -> Option<u64> {
    let (builtin, size) = find(name, size).ok()?;
    Some(builtin.sample_type.size_bytes() as u64 * (size as u64).pow(3))
}

/// How a volume is made, and of what size.
fn find(name: &str, size: Option<usize>) -> Result<(Builtin, usize), IoError> {
    let builtin = named(name).ok_or_else(|| IoError::UnknownBuiltin { name: name.to_owned() })?;
    let size = size.unwrap_or(builtin.default_size);
    if !(MIN_SIZE..=MAX_SIZE).contains(&size) {
        return Err(IoError::BadBuiltinSize { size, min: MIN_SIZE, max: MAX_SIZE });
    }
    Ok((builtin, size))
}

fn named(name: &str) -> Option<Builtin> {
    use SampleType::{F32, U8};
    let (default_size, sample_type, samples): (usize, _, fn(usize) -> Samples) = match name {
        "cube" => (28, U8, cube::samples),
        "sphere" => (64, U8, sphere::samples),
        "marschner-lobb" => (41, F32, marschner_lobb::samples),
        "shepp-logan" => (96, U8, shepp_logan::samples),
        "neuron" => (128, U8, neuron::samples),
        _ => return None,
    };
    Some(Builtin { default_size, sample_type, samples })
}

fn centered_grid(size: usize) -> Grid {
    let to_corner = DVec3::splat((size as f64 - 1.0) / -2.0);
    Grid::new([size; 3], DAffine3::from_translation(to_corner))
        .expect("sizes of 4 to 1024 voxels make a valid grid")
}

/// Samples of `value_at`, which is given each voxel's place in voxel steps from the centre.
fn sampled<T>(size: usize, value_at: impl Fn(DVec3) -> T) -> Vec<T> {
    let place = |idx: usize| idx as f64 - (size as f64 - 1.0) / 2.0;
    let mut samples = Vec::with_capacity(size.pow(3));
    for k in 0..size {
        for j in 0..size {
            samples.extend((0..size).map(|i| value_at(DVec3::new(place(i), place(j), place(k)))));
        }
    }
    samples
}

/// 0 … 1 as 0 … 255, rounded.
fn to_byte(value: f64) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// 0 below 0, 1 above 1, and smooth between.
fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builtin_names_are_all_made() {
        for &name in BUILTIN_NAMES {
            let volume = builtin_volume(name, None).unwrap();
            let again = builtin_volume(name, None).unwrap();
            assert_eq!(volume.samples(), again.samples(), "{name} differs between calls");
            assert!(volume.grid().center_in_world().length() < 1e-12, "{name} is off centre");
            assert_eq!(volume.grid().spacing(), [1.0; 3], "{name}");
            let [lo, hi] = volume.summary().range.unwrap();
            assert!(lo < hi, "{name} is empty");
        }
    }

    #[test]
    fn builtin_sizes_and_types() {
        for (name, side, sample_type) in [
            ("cube", 28, SampleType::U8),
            ("sphere", 64, SampleType::U8),
            ("marschner-lobb", 41, SampleType::F32),
            ("shepp-logan", 96, SampleType::U8),
            ("neuron", 128, SampleType::U8),
        ] {
            let volume = builtin_volume(name, None).unwrap();
            assert_eq!(volume.grid().dims(), [side; 3], "{name}");
            assert_eq!(volume.sample_type(), sample_type, "{name}");
            let n_bytes = (side.pow(3) * sample_type.size_bytes()) as u64;
            assert_eq!(builtin_bytes(name, None), Some(n_bytes), "{name}");
            assert_eq!(builtin_volume(name, Some(9)).unwrap().grid().dims(), [9; 3], "{name}");
        }
    }

    #[test]
    fn builtin_rejects_unknown_names_and_sizes() {
        let err = builtin_volume("teapot", None).unwrap_err().to_string();
        assert!(err.contains("\"teapot\"") && err.contains("marschner-lobb"), "{err}");
        for size in [0, 3, 1025, usize::MAX] {
            let err = builtin_volume("cube", Some(size)).unwrap_err().to_string();
            assert!(err.contains("4 to 1024"), "{err}");
        }
    }
}
