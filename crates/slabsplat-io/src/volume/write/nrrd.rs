//! NRRD: the place of the voxels as it is, in RAS, and samples packed by gzip.

use std::path::Path;

use slabsplat_core::SampleType;

use super::{Packing, ToWrite, WrittenSamples, numbers, steps_and_origin, write_file};
use crate::IoError;

pub(super) fn write(path: &Path, to_write: &ToWrite<'_>) -> Result<Vec<String>, IoError> {
    let mut warnings = Vec::new();
    let samples = WrittenSamples::as_values(to_write, &mut warnings);
    write_file(path, header(to_write, &samples).as_bytes(), &samples, Packing::Samples)?;
    Ok(warnings)
}

fn header(to_write: &ToWrite<'_>, samples: &WrittenSamples<'_>) -> String {
    let type_name = match samples.sample_type() {
        SampleType::F32 => "float",
        SampleType::F64 => "double",
        other => other.name(),
    };
    let volume = to_write.volume;
    let [nx, ny, nz] = volume.grid().dims();
    let (steps, origin) = steps_and_origin(volume.grid(), false);
    let vector =
        |v: slabsplat_core::glam::DVec3| format!("({})", numbers(v.to_array()).replace(' ', ","));
    let [x, y, z] = steps.map(vector);
    // What the axis of a voxel's values has in each of the fields.
    let (n_axes, size, none, kind) = match to_write.n_values() {
        1 => (3, "", "", ""),
        3 => (4, "3 ", "none ", "RGB-color "),
        _ => (4, "4 ", "none ", "RGBA-color "),
    };
    format!(
        "NRRD0005\ntype: {type_name}\ndimension: {n_axes}\nspace: right-anterior-superior\n\
         sizes: {size}{nx} {ny} {nz}\nspace directions: {none}{x} {y} {z}\n\
         kinds: {kind}domain domain domain\n\
         endian: little\nencoding: gzip\nspace origin: {}\n\n",
        vector(origin)
    )
}
