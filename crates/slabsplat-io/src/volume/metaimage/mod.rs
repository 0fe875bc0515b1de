//! MetaImage: text fields (`.mha`, `.mhd`), and data after them or in files of their own.
//!
//! Format: <https://itk.org/Wiki/ITK/MetaIO/Documentation>. Read: raw, zlib and text; data attached,
//! detached (one file, a `LIST`, a numbered pattern). Space is ITK's, LPS: x and y change sign.
//! `AnatomicalOrientation` and `CenterOfRotation` change nothing, as in ITK. `CompressedDataSize` is often
//! wrong, and not needed.
//!
//! Reading order: `header` (lines to fields), `space` (where the voxels lie), `files` (where the data are).

mod files;
mod header;
mod space;

use slabsplat_core::{Grid, Orientation, SampleType, Scaling};

use super::choices::Part;
use super::colors::{Meaning, Values, Voxels};
use super::data::{self, Encoding};
use super::formats::{Input, Reader, VolumeListing};
use super::stored::StoredType;
use super::{Endian, LoadedVolume, VolumeChoices, VolumeFormat};
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

    fn reads_boxes(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let header = Header::read(input.store, input.path)?;
        Ok(VolumeListing {
            format: VolumeFormat::MetaImage,
            dims: volume_dims(&header.sizes()?),
            sample_type: stored_type(&header)?.widest(),
            choices: choices(&header, input, &header.sizes()?)?,
        })
    }
}

fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let &Input { store, path, .. } = input;
    let header = Header::read(store, path)?;
    let mut warnings = Vec::new();
    let sizes = header.sizes()?;
    let grid = Grid::new_large(volume_dims(&sizes), space::world_from_index(&header, sizes.len())?)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let stored = stored_type(&header)?;
    let choices = choices(&header, input, &sizes)?;
    let n_samples = grid.n_voxels().saturating_mul(choices.n_read());
    let (window, grid) = input.window(&grid)?;
    let layout = data::Layout {
        window,
        n_samples,
        share: choices.share(),
        stored,
        encoding: encoding(&header)?,
        endian: endian(&header, stored, &mut warnings)?,
        line_skip: 0,
        byte_skip: header.parsed("headersize")?.unwrap_or(0),
    };
    let files = files::find(input, &header, &sizes)?;
    let samples = data::read(input, &layout, &files, &mut warnings)?;
    let voxels = Voxels { grid, samples, scaling: Scaling::IDENTITY, choices };
    let loaded = voxels.load(input, VolumeFormat::MetaImage, warnings)?;
    let orientation = space::orientation(&header);
    // Millimetres are those of bodies; simulations have no unit.
    Ok(loaded.standing(orientation).measured(orientation == Orientation::Anatomical))
}

/// Times along all axes after the third, and the values of each voxel.
fn choices(header: &Header, input: &Input<'_>, sizes: &[usize]) -> Result<VolumeChoices, IoError> {
    let n_channels: usize = header.parsed("elementnumberofchannels")?.unwrap_or(1);
    let n_times = sizes.iter().skip(3).fold(1, |n: usize, &size| n.saturating_mul(size));
    if n_channels == 0 || n_times == 0 {
        return Err(header.malformed("the volume is empty: it has no channels, or no times"));
    }
    let values = Values { n: n_channels, stored: stored_type(header)?, meaning: Meaning::Unsaid };
    let time = input.choose(Part::Time, n_times)?;
    Ok(VolumeChoices { time, ..input.choose_values(&values)? })
}

/// Those of the first volume; an image is a volume of one slice.
fn volume_dims(sizes: &[usize]) -> [usize; 3] {
    [0, 1, 2].map(|axis| sizes.get(axis).copied().unwrap_or(1))
}

fn stored_type(header: &Header) -> Result<StoredType, IoError> {
    let name = header.needed("elementtype")?;
    Ok(StoredType::Sample(match name.trim_end_matches("_ARRAY") {
        "MET_UCHAR" => SampleType::U8,
        "MET_CHAR" => SampleType::I8,
        "MET_USHORT" => SampleType::U16,
        "MET_SHORT" => SampleType::I16,
        // Four bytes in files, whatever a compiler says.
        "MET_UINT" | "MET_ULONG" => SampleType::U32,
        "MET_INT" | "MET_LONG" => SampleType::I32,
        "MET_ULONG_LONG" => return Ok(StoredType::U64),
        "MET_LONG_LONG" => return Ok(StoredType::I64),
        "MET_FLOAT" => SampleType::F32,
        "MET_DOUBLE" => SampleType::F64,
        _ => {
            let what = "cannot be read: convert them to MET_INT, MET_FLOAT or less";
            return Err(header.unsupported(format!("elements of type {name:?} {what}")));
        }
    }))
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
    stored: StoredType,
    warnings: &mut Vec<String>,
) -> Result<Endian, IoError> {
    let is_big = match header.is_true("binarydatabyteordermsb")? {
        None => header.is_true("elementbyteordermsb")?,
        said => said,
    };
    if is_big.is_none() && 1 < stored.size_bytes() && encoding(header)? != Encoding::Text {
        warnings
            .push("the header does not say the byte order: little-endian was assumed".to_owned());
    }
    Ok(if is_big == Some(true) { Endian::Big } else { Endian::Little })
}

#[cfg(test)]
mod tests;
