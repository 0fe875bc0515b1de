//! MetaImage: text fields (`.mha`, `.mhd`), and data after them or in files of their own.
//!
//! Format: <https://itk.org/Wiki/ITK/MetaIO/Documentation>. Read: raw, zlib and text; data attached,
//! detached (one file, a `LIST`, a numbered pattern). Space is ITK's, LPS: x and y change sign.
//! `AnatomicalOrientation` and `CenterOfRotation` change nothing, as in ITK. `CompressedDataSize` is often
//! wrong, and not needed. Not read: 64-bit integers.
//!
//! Reading order: `header` (lines to fields), `space` (where the voxels lie), `files` (where the data are).

mod files;
mod header;
mod space;

use slabsplat_core::{Grid, SampleType, Scaling};

use super::choices::Part;
use super::data::{self, Encoding};
use super::formats::{Input, Reader, VolumeListing};
use super::{Endian, LoadedVolume, VolumeChoices, VolumeFormat, assemble};
use crate::IoError;
use header::Header;

/// The format.
pub(super) struct MetaImage;

impl Reader for MetaImage {
    fn listed(&self) -> &'static str {
        "MetaImage (.mha, .mhd)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["mha", "mhd"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        header::is_first_line(start)
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let header = Header::read(input.store, input.path)?;
        Ok(VolumeListing {
            format: VolumeFormat::MetaImage,
            dims: volume_dims(&header.sizes()?),
            sample_type: sample_type(&header)?,
            choices: choices(&header, input, &header.sizes()?)?,
        })
    }
}

fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let &Input { store, path, .. } = input;
    let header = Header::read(store, path)?;
    let mut warnings = Vec::new();
    let sizes = header.sizes()?;
    let grid = Grid::new(volume_dims(&sizes), space::world_from_index(&header, sizes.len())?)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let sample_type = sample_type(&header)?;
    let choices = choices(&header, input, &sizes)?;
    let layout = data::Layout {
        n_samples: grid.n_voxels(),
        share: choices.share(),
        sample_type,
        encoding: encoding(&header)?,
        endian: endian(&header, sample_type, &mut warnings)?,
        line_skip: 0,
        byte_skip: header.parsed("headersize")?.unwrap_or(0),
    };
    let files = files::find(input, &header, &sizes)?;
    let samples = data::read(store, path, &layout, &files, &mut warnings)?;
    let volume = assemble(path, grid, samples, Scaling::IDENTITY)?;
    Ok(LoadedVolume { choices, ..LoadedVolume::new(volume, VolumeFormat::MetaImage, warnings) })
}

/// Times along all axes after the third, and the values of each voxel.
fn choices(header: &Header, input: &Input<'_>, sizes: &[usize]) -> Result<VolumeChoices, IoError> {
    let n_channels: usize = header.parsed("elementnumberofchannels")?.unwrap_or(1);
    let n_times = sizes.iter().skip(3).fold(1, |n: usize, &size| n.saturating_mul(size));
    if n_channels == 0 || n_times == 0 {
        return Err(header.malformed("the volume is empty: it has no channels, or no times"));
    }
    Ok(VolumeChoices {
        channel: input.choose(Part::Channel, n_channels)?,
        time: input.choose(Part::Time, n_times)?,
        ..VolumeChoices::default()
    })
}

/// Those of the first volume; an image is a volume of one slice.
fn volume_dims(sizes: &[usize]) -> [usize; 3] {
    [0, 1, 2].map(|axis| sizes.get(axis).copied().unwrap_or(1))
}

fn sample_type(header: &Header) -> Result<SampleType, IoError> {
    let name = header.needed("elementtype")?;
    match name.trim_end_matches("_ARRAY") {
        "MET_UCHAR" => Ok(SampleType::U8),
        "MET_CHAR" => Ok(SampleType::I8),
        "MET_USHORT" => Ok(SampleType::U16),
        "MET_SHORT" => Ok(SampleType::I16),
        // Four bytes in files, whatever a compiler says.
        "MET_UINT" | "MET_ULONG" => Ok(SampleType::U32),
        "MET_INT" | "MET_LONG" => Ok(SampleType::I32),
        "MET_FLOAT" => Ok(SampleType::F32),
        "MET_DOUBLE" => Ok(SampleType::F64),
        _ => Err(header.unsupported(format!(
            "elements of type {name:?} cannot be read: convert them to MET_INT, MET_FLOAT or less"
        ))),
    }
}

fn encoding(header: &Header) -> Result<Encoding, IoError> {
    match (header.is_true("binarydata")?, header.is_true("compresseddata")?) {
        (Some(false), _) => Ok(Encoding::Text),
        (_, Some(true)) => Ok(Encoding::Packed),
        _ => Ok(Encoding::Raw),
    }
}

/// The byte order; only numbers of several bytes, not written as text, have one.
fn endian(
    header: &Header,
    sample_type: SampleType,
    warnings: &mut Vec<String>,
) -> Result<Endian, IoError> {
    let is_big = match header.is_true("binarydatabyteordermsb")? {
        None => header.is_true("elementbyteordermsb")?,
        said => said,
    };
    if is_big.is_none() && 1 < sample_type.size_bytes() && encoding(header)? != Encoding::Text {
        warnings
            .push("the header does not say the byte order: little-endian was assumed".to_owned());
    }
    Ok(if is_big == Some(true) { Endian::Big } else { Endian::Little })
}

#[cfg(test)]
mod tests;
