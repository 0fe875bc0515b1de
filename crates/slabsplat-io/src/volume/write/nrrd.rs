//! NRRD: the place of the voxels as it is, in RAS, and samples packed by gzip.

use std::path::Path;

use slabsplat_core::{SampleType, Volume};

use super::{Packing, WrittenSamples, numbers, steps_and_origin, write_file};
use crate::IoError;

pub(super) fn write(path: &Path, volume: &Volume) -> Result<Vec<String>, IoError> {
    let mut warnings = Vec::new();
    let samples = WrittenSamples::as_values(volume, &mut warnings);
    write_file(path, header(volume, &samples).as_bytes(), &samples, Packing::Samples)?;
    Ok(warnings)
}

fn header(volume: &Volume, samples: &WrittenSamples<'_>) -> String {
    let type_name = match samples.sample_type() {
        SampleType::F32 => "float",
        SampleType::F64 => "double",
        other => other.name(),
    };
    let [nx, ny, nz] = volume.grid().dims();
    let (steps, origin) = steps_and_origin(volume.grid(), false);
    let vector =
        |v: slabsplat_core::glam::DVec3| format!("({})", numbers(v.to_array()).replace(' ', ","));
    let [x, y, z] = steps.map(vector);
    format!(
        "NRRD0005\ntype: {type_name}\ndimension: 3\nspace: right-anterior-superior\n\
         sizes: {nx} {ny} {nz}\nspace directions: {x} {y} {z}\nkinds: domain domain domain\n\
         endian: little\nencoding: gzip\nspace origin: {}\n\n",
        vector(origin)
    )
}
