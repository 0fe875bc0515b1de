//! NIfTI in one file: version 1, which every program reads, with the place of the voxels in 32-bit floats; or
//! version 2 where an axis is too long for that.

use std::path::Path;

use slabsplat_core::{SampleType, Volume};

use super::{Packing, ToWrite, WrittenSamples, write_file};
use crate::IoError;

/// The longest axis of version 1.
const MAX_LEN_ONE: usize = i16::MAX as usize;

/// Codes of colours of 8 bits.
const RGB24: i16 = 128;
const RGBA32: i16 = 2304;

/// Millimetres.
const UNITS: u8 = 2;

/// Places in the scanner's coordinates.
const SCANNER: u8 = 1;

pub(super) fn write(
    path: &Path,
    to_write: &ToWrite<'_>,
    packs: bool,
) -> Result<Vec<String>, IoError> {
    let (volume, pixel) = (to_write.volume, Pixel::of(to_write));
    let samples = WrittenSamples::as_stored(to_write);
    let is_long = volume.grid().dims().iter().any(|len| MAX_LEN_ONE < *len);
    let mut warnings = Vec::new();
    let header = if is_long {
        warnings.push("an axis is too long for NIfTI-1: NIfTI-2 is written".to_owned());
        header_two(volume, pixel)
    } else {
        if is_rounded(volume) {
            let what = "NIfTI-1 has the place of the voxels, slope and intercept in 32-bit floats: they are \
                        rounded to 7 digits";
            warnings.push(what.to_owned());
        }
        header_one(volume, pixel)
    };
    write_file(path, &header, &samples, if packs { Packing::All } else { Packing::None })?;
    Ok(warnings)
}

fn is_rounded(volume: &Volume) -> bool {
    let scaling = [volume.scaling().slope, volume.scaling().intercept];
    let mut exact = rows(volume).into_iter().flatten().chain(scaling);
    exact.any(|number| f64::from(number as f32) != number)
}

/// The affine's rows.
fn rows(volume: &Volume) -> [[f64; 4]; 3] {
    let to_world = volume.grid().world_from_index();
    let (m, o) = (to_world.matrix3, to_world.translation);
    [0, 1, 2].map(|r| [m.x_axis[r], m.y_axis[r], m.z_axis[r], o[r]])
}

/// What a voxel is: the code in nifti1.h, and how many bits.
#[derive(Clone, Copy)]
struct Pixel {
    code: i16,
    n_bits: i16,
}

impl Pixel {
    fn of(to_write: &ToWrite<'_>) -> Self {
        let sample_type = to_write.volume.sample_type();
        match to_write.n_values() {
            1 => Self { code: code(sample_type), n_bits: 8 * sample_type.size_bytes() as i16 },
            3 => Self { code: RGB24, n_bits: 24 },
            _ => Self { code: RGBA32, n_bits: 32 },
        }
    }
}

/// The type's code in nifti1.h.
fn code(sample_type: SampleType) -> i16 {
    match sample_type {
        SampleType::U8 => 2,
        SampleType::I8 => 256,
        SampleType::U16 => 512,
        SampleType::I16 => 4,
        SampleType::U32 => 768,
        SampleType::I32 => 8,
        SampleType::F32 => 16,
        SampleType::F64 => 64,
    }
}

/// Whether the third axis is mirrored, and the sides of a voxel.
fn pixdim(volume: &Volume) -> [f64; 4] {
    let [x, y, z] = volume.grid().spacing();
    let is_mirrored = volume.grid().world_from_index().matrix3.determinant() < 0.0;
    [if is_mirrored { -1.0 } else { 1.0 }, x, y, z]
}

fn header_one(volume: &Volume, pixel: Pixel) -> Vec<u8> {
    let mut bytes = vec![0; 352];
    let mut put = |at: usize, field: &[u8]| bytes[at..at + field.len()].copy_from_slice(field);
    let float = |number: f64| (number as f32).to_le_bytes();
    put(0, &348_i32.to_le_bytes());
    let [nx, ny, nz] = volume.grid().dims().map(|len| len as i16);
    for (idx, len) in [3, nx, ny, nz, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * idx, &len.to_le_bytes());
    }
    put(70, &pixel.code.to_le_bytes());
    put(72, &pixel.n_bits.to_le_bytes());
    for (idx, number) in pixdim(volume).into_iter().enumerate() {
        put(76 + 4 * idx, &float(number));
    }
    put(108, &352_f32.to_le_bytes());
    put(112, &float(volume.scaling().slope));
    put(116, &float(volume.scaling().intercept));
    put(123, &[UNITS]);
    put(254, &[SCANNER, 0]);
    for (idx, number) in rows(volume).into_iter().flatten().enumerate() {
        put(280 + 4 * idx, &float(number));
    }
    put(344, b"n+1\0");
    bytes
}

fn header_two(volume: &Volume, pixel: Pixel) -> Vec<u8> {
    let mut bytes = vec![0; 544];
    let mut put = |at: usize, field: &[u8]| bytes[at..at + field.len()].copy_from_slice(field);
    put(0, &540_i32.to_le_bytes());
    put(4, b"n+2\0\r\n\x1a\n");
    put(12, &pixel.code.to_le_bytes());
    put(14, &pixel.n_bits.to_le_bytes());
    let [nx, ny, nz] = volume.grid().dims().map(|len| len as i64);
    for (idx, len) in [3, nx, ny, nz, 1, 1, 1, 1].into_iter().enumerate() {
        put(16 + 8 * idx, &len.to_le_bytes());
    }
    for (idx, number) in pixdim(volume).into_iter().enumerate() {
        put(104 + 8 * idx, &number.to_le_bytes());
    }
    put(168, &544_i64.to_le_bytes());
    put(176, &volume.scaling().slope.to_le_bytes());
    put(184, &volume.scaling().intercept.to_le_bytes());
    put(348, &[SCANNER, 0, 0, 0]);
    for (idx, number) in rows(volume).into_iter().flatten().enumerate() {
        put(400 + 8 * idx, &number.to_le_bytes());
    }
    put(500, &[UNITS, 0, 0, 0]);
    bytes
}
