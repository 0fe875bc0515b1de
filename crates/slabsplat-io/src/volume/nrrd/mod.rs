//! NRRD, "nearly raw raster data": a text header, and data after it or in files of their own.
//!
//! Format: <https://teem.sourceforge.net/nrrd/format.html>. Read: raw, gzip, bzip2, hex and text
//! encodings; data attached or detached (one file, a `LIST`, a numbered pattern); `space directions` and
//! `spacings`, also both at once. A first axis of values that voxels have gives a channel, a last one of
//! moments a time.
//!
//! Reading order: `header` (lines to fields), `axes` (which three axes are the volume's), `space`
//! (where they lie), `files` (where the data are).

mod axes;
mod files;
mod header;
mod space;

use slabsplat_core::{Grid, Orientation, Scaling};

use super::colors::Voxels;
use super::data::{self, Encoding};
use super::formats::{Input, Reader, VolumeListing};
use super::stored::StoredType;
use super::{Endian, LoadedVolume, VolumeFormat, names};
use crate::IoError;
use header::Header;

/// The format.
pub(super) struct Nrrd;

impl Reader for Nrrd {
    fn listed(&self) -> &'static str {
        "NRRD (.nrrd, .nhdr)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["nrrd", "nhdr"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        start.starts_with(b"NRRD00")
    }

    fn reads_boxes(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let header = Header::read(input.store, input.path)?;
        let axes = axes::find(&header)?;
        Ok(VolumeListing {
            format: VolumeFormat::Nrrd,
            dims: axes.dims,
            sample_type: stored_type(&header)?.widest(),
            choices: axes.choices(input, stored_type(&header)?)?,
        })
    }
}

fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let &Input { store, path, .. } = input;
    let header = Header::read(store, path)?;
    let mut warnings = Vec::new();
    let axes = axes::find(&header)?;
    let grid = Grid::new_large(axes.dims, space::world_from_index(&header, &axes, &mut warnings)?)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
    let stored = stored_type(&header)?;
    let choices = axes.choices(input, stored)?;
    let (window, grid) = input.window(&grid)?;
    let layout = data::Layout {
        window,
        n_samples: axes.dims.iter().product::<usize>().saturating_mul(choices.n_read()),
        share: choices.share(),
        stored,
        encoding: encoding(&header)?,
        endian: endian(&header, stored, &mut warnings)?,
        line_skip: header.parsed("line skip")?.unwrap_or(0),
        byte_skip: header.parsed("byte skip")?.unwrap_or(0),
    };
    let files = files::find(input, &header, &axes.file_sizes)?;
    let samples = data::read(input, &layout, &files, &mut warnings)?;
    let voxels = Voxels { grid, samples, scaling: Scaling::IDENTITY, choices };
    let loaded = voxels.load(input, VolumeFormat::Nrrd, warnings)?;
    let orientation = space::orientation(&header);
    let has_unit = header.get("space units").or_else(|| header.get("units")).is_some();
    let is_metric = has_unit || orientation == Orientation::Anatomical;
    Ok(loaded.standing(orientation).measured(is_metric))
}

fn stored_type(header: &Header) -> Result<StoredType, IoError> {
    let name = header.needed("type")?;
    names::stored_type(name).ok_or_else(|| header.unsupported(names::unknown_type(name)))
}

fn encoding(header: &Header) -> Result<Encoding, IoError> {
    let name = header.needed("encoding")?;
    match name.to_lowercase().as_str() {
        "raw" => Ok(Encoding::Raw),
        "gz" | "gzip" => Ok(Encoding::Packed),
        "bz2" | "bzip2" => Ok(Encoding::PackedByBzip2),
        "txt" | "text" | "ascii" => Ok(Encoding::Text),
        "hex" => Ok(Encoding::Hex),
        _ => Err(header.unsupported(format!(
            "encoding {name:?} is not supported: save the file as raw, gzip, bzip2, hex or ascii"
        ))),
    }
}

/// The byte order; only numbers of several bytes, not written as text, have one.
fn endian(
    header: &Header,
    stored: StoredType,
    warnings: &mut Vec<String>,
) -> Result<Endian, IoError> {
    match header.get("endian").map(str::to_lowercase).as_deref() {
        Some("little") => Ok(Endian::Little),
        Some("big") => Ok(Endian::Big),
        Some(other) => Err(header.malformed(format!("endian is {other:?}, not little or big"))),
        None => {
            let matters = 1 < stored.size_bytes() && encoding(header)? != Encoding::Text;
            if matters {
                warnings.push("the header does not say endian: little was assumed".to_owned());
            }
            Ok(Endian::Little)
        }
    }
}

#[cfg(test)]
mod tests;
