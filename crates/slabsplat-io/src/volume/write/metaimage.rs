//! MetaImage: directions and spacings by themselves, in LPS, and samples as they are.

use std::path::Path;

use slabsplat_core::SampleType;

use super::{Packing, ToWrite, WrittenSamples, numbers, steps_and_origin, write_file};
use crate::IoError;

pub(super) fn write(path: &Path, to_write: &ToWrite<'_>) -> Result<Vec<String>, IoError> {
    let mut warnings = Vec::new();
    let samples = WrittenSamples::as_values(to_write, &mut warnings);
    write_file(path, header(to_write, &samples).as_bytes(), &samples, Packing::None)?;
    Ok(warnings)
}

fn header(to_write: &ToWrite<'_>, samples: &WrittenSamples<'_>) -> String {
    let element_type = match samples.sample_type() {
        SampleType::U8 => "MET_UCHAR",
        SampleType::I8 => "MET_CHAR",
        SampleType::U16 => "MET_USHORT",
        SampleType::I16 => "MET_SHORT",
        SampleType::U32 => "MET_UINT",
        SampleType::I32 => "MET_INT",
        SampleType::F32 => "MET_FLOAT",
        SampleType::F64 => "MET_DOUBLE",
    };
    let volume = to_write.volume;
    let channels = match to_write.n_values() {
        1 => String::new(),
        n => format!("ElementNumberOfChannels = {n}\n"),
    };
    let [nx, ny, nz] = volume.grid().dims();
    let (steps, origin) = steps_and_origin(volume.grid(), true);
    let spacing = volume.grid().spacing();
    let directions =
        steps.iter().zip(spacing).flat_map(|(step, length)| (*step / length).to_array());
    format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
         CompressedData = False\nTransformMatrix = {}\nOffset = {}\nElementSpacing = {}\n\
         DimSize = {nx} {ny} {nz}\n{channels}ElementType = {element_type}\nElementDataFile = LOCAL\n",
        numbers(directions),
        numbers(origin.to_array()),
        numbers(spacing),
    )
}
