//! NumPy: an array `[z, y, x]` in C order, of colours `[z, y, x, value]`, which has no place in the world.

use std::path::Path;

use slabsplat_core::{Grid, SampleType};

use super::{Packing, ToWrite, WrittenSamples, write_file};
use crate::IoError;

pub(super) fn write(path: &Path, to_write: &ToWrite<'_>) -> Result<Vec<String>, IoError> {
    let mut warnings = Vec::new();
    let volume = to_write.volume;
    let samples = WrittenSamples::as_values(to_write, &mut warnings);
    write_file(path, &header(to_write, &samples), &samples, Packing::None)?;
    if Grid::with_spacing(volume.grid().dims(), [1.0; 3]).as_ref() != Ok(volume.grid()) {
        let [x, y, z] = volume.grid().spacing();
        warnings.push(format!(
            "NumPy has no room for the place of the voxels: read it with --spacing {x},{y},{z}"
        ));
    }
    Ok(warnings)
}

fn header(to_write: &ToWrite<'_>, samples: &WrittenSamples<'_>) -> Vec<u8> {
    let code = match samples.sample_type() {
        SampleType::U8 => "|u1",
        SampleType::I8 => "|i1",
        SampleType::U16 => "<u2",
        SampleType::I16 => "<i2",
        SampleType::U32 => "<u4",
        SampleType::I32 => "<i4",
        SampleType::F32 => "<f4",
        SampleType::F64 => "<f8",
    };
    let [nx, ny, nz] = to_write.volume.grid().dims();
    let values = match to_write.n_values() {
        1 => String::new(),
        n => format!(", {n}"),
    };
    let shape = format!("({nz}, {ny}, {nx}{values})");
    let text = format!("{{'descr': '{code}', 'fortran_order': False, 'shape': {shape}, }}");
    // With blanks, so that samples begin at a multiple of 64; four sizes are never longer.
    let text = format!("{text:<117}\n");
    let length = (text.len() as u16).to_le_bytes();
    [&b"\x93NUMPY\x01\x00"[..], &length, text.as_bytes()].concat()
}
