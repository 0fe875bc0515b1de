//! MRC, as electron microscopy writes it, and CCP4's maps: a header of 1024 bytes, maybe another one, and
//! samples.
//!
//! Format: MRC2014, <https://www.ccpem.ac.uk/mrc_format/mrc2014.php>; what IMOD adds,
//! <https://bio3d.colorado.edu/imod/doc/mrc_format.txt>. Read: either byte order, integers of 8 and 16 bits,
//! floats of 16 and 32, columns, rows and sections along any axes, cells with any angles, stacks of volumes.
//! Files older than the word `MAP ` are known by their names, if the header makes sense. Not read: complex
//! numbers, 4 bits, colours.
//!
//! Reading order: `header` (bytes to fields), `space` (where the voxels lie).

mod header;
mod space;

use std::path::{Path, PathBuf};

use slabsplat_core::{Grid, Scaling};

use super::buffer::ReadFailure;
use super::choices::Part;
use super::colors::Voxels;
use super::formats::{Input, Reader, VolumeListing};
use super::placed::Axis;
use super::stored::StoredType;
use super::stream::{DataStream, first_bytes, plain_extension};
use super::window::not_in_boxes;
use super::{LoadedVolume, VolumeChoices, VolumeFormat};
use crate::IoError;
use crate::store::Store;
use header::{HEADER_BYTES, Header};

/// The format.
pub(super) struct Mrc;

impl Reader for Mrc {
    fn listed(&self) -> &'static str {
        "MRC (.mrc, .map, .rec, .ali, .st)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["mrc", "map", "rec", "ali", "st", "mrcs", "ccp4", "preali"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        Header::parse(start).is_some_and(|header| header.has_magic)
    }

    /// Other programs use these extensions, too: a description beside a file says more.
    fn is_named(&self, store: Store<'_>, path: &Path) -> bool {
        self.extensions().contains(&plain_extension(path).as_str())
            && (is_plausible(store, path) || !store.has(&path.with_extension("json")))
    }

    fn header_of(&self, store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
        if is_plausible(store, path) {
            return Ok(path.to_owned());
        }
        let what = "not an MRC file, or cut off: it does not begin with sizes, a mode and axes that can be";
        Err(IoError::malformed(path, what))
    }

    fn reads_boxes(&self) -> bool {
        true
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let header = parse(input)?;
        Ok(VolumeListing {
            format: VolumeFormat::Mrc,
            dims: header.dims(),
            sample_type: stored_type(&header, input.path, &mut Vec::new())?.widest(),
            choices: choices(&header, input)?,
        })
    }
}

fn is_plausible(store: Store<'_>, path: &Path) -> bool {
    first_bytes(store, path).is_ok_and(|start| Header::parse(&start).is_some())
}

fn parse(input: &Input<'_>) -> Result<Header, IoError> {
    let start = first_bytes(input.store, input.path)?;
    Header::parse(&start).ok_or_else(|| IoError::malformed(input.path, "not an MRC header"))
}

fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let path = input.path;
    let header = parse(input)?;
    let mut warnings = Vec::new();
    if header.is_stamp_wrong {
        let what = "the machine stamp does not say the byte order that the header is in: it was passed over";
        warnings.push(what.to_owned());
    }
    let choices = choices(&header, input)?;
    let stored = stored_type(&header, path, &mut warnings)?;
    let place = space::world_from_index(&header, &mut warnings)
        .map_err(|what| IoError::malformed(path, what))?;
    let grid = Grid::new_large(header.dims(), place)
        .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;

    let mut stream = DataStream::open_unpacked(input.store, path)?;
    stream.skip(HEADER_BYTES + u64::from(header.n_extended_bytes))?;
    let needed = header.n_items().saturating_mul(stored.size_bytes() as u64);
    stream.check_left(needed)?;
    let mut axes = axes(&header, choices.time.chosen);
    let (window, grid) = input.window(&grid)?;
    if let Some(window) = &window {
        let kept = window.keep(&mut axes, &choices, stored);
        let kept = if stream.is_plain() { kept } else { Err("a packed file") };
        kept.map_err(|what| not_in_boxes(path, what))?;
    }
    let failed = |failure| match failure {
        ReadFailure::TooShort(found) => input.too_short(needed, found),
        ReadFailure::Io(source) => IoError::Read { path: path.to_owned(), source },
    };
    let samples = input.room(stored, header.endian, grid.n_voxels());
    let mut samples = samples.map_err(failed)?;
    let meter = input.meter(needed);
    stream.metered(&meter);
    samples.place(&mut stream, &axes, 0).map_err(failed)?;
    if choices.is_single() && stream.has_more()? {
        warnings.push(format!("{} holds more data than were needed", path.display()));
    }
    let samples = samples.finish(&mut warnings);
    let voxels = Voxels { grid, samples, scaling: Scaling::IDENTITY, choices };
    voxels.load(input, VolumeFormat::Mrc, warnings)
}

/// How columns, rows, sections and volumes of the file lie in a volume.
fn axes(header: &Header, volume: usize) -> [Axis; 4] {
    let [nx, ny, _] = header.dims();
    let strides = [1, nx, nx * ny];
    let [columns, rows, sections] = [0, 1, 2]
        .map(|stored| Axis::whole(header.volume_sizes()[stored], strides[header.axis_of[stored]]));
    [columns, rows, sections, Axis::one(header.n_volumes(), volume)]
}

/// Volumes of a stack are times.
fn choices(header: &Header, input: &Input<'_>) -> Result<VolumeChoices, IoError> {
    let [.., n_sections] = header.sizes;
    if !n_sections.is_multiple_of(header.volume_sizes()[2]) {
        let what = format!(
            "the file is a stack of volumes of {} sections each, and has {n_sections}, which are no whole \
             number of volumes",
            header.volume_sizes()[2]
        );
        return Err(IoError::malformed(input.path, what));
    }
    let time = input.choose(Part::Time, header.n_volumes())?;
    Ok(VolumeChoices { time, ..VolumeChoices::default() })
}

/// What samples are, by the mode.
fn stored_type(
    header: &Header,
    path: &Path,
    warnings: &mut Vec<String>,
) -> Result<StoredType, IoError> {
    use slabsplat_core::SampleType::{F32, I8, I16, U16};
    let other = match header.mode {
        0 if header.are_bytes_signed(warnings) => return Ok(I8.into()),
        0 => return Ok(StoredType::U8_SAMPLE),
        1 => return Ok(I16.into()),
        2 => return Ok(F32.into()),
        6 => return Ok(U16.into()),
        12 => return Ok(StoredType::F16),
        3 | 4 => {
            "complex numbers, as a Fourier transform has: no one value of them can be drawn; transform them back"
        }
        16 => "colours: save one of them alone",
        101 => "numbers of 4 bits: `newstack -mode 0` of IMOD unpacks them",
        mode => {
            let what = format!("there is no mode {mode}: the header is broken");
            return Err(IoError::malformed(path, what));
        }
    };
    Err(IoError::unsupported(path, format!("samples are {other}")))
}

#[cfg(test)]
mod tests;
