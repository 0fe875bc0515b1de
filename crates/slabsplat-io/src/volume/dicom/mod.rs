//! DICOM: a folder of slices, or a file of one or many.
//!
//! Standard: <https://www.dicomstandard.org/current> (PS3.3 what elements mean, PS3.5 how they are written).
//! Read: little and big endian, explicit and implicit, deflated; pixels plain, by run lengths, by JPEG of 8
//! and 12 bits, lossless JPEG, JPEG-LS and JPEG 2000; single images and enhanced ones with functional groups.
//! Slices are sorted and spaced by their positions; the world is RAS+, DICOM's LPS. Values keep their type
//! with the rescale as a scaling, unless slices have different ones; padding is a value as others are. Not
//! read: HTJ2K, single bits, palettes and other colours than RGB and YBR.
//!
//! Reading order: `tags`, `dataset`, `elements`, `syntax` and `header` (what is before pixels), `frame` (what
//! a file says of each slice), `scan` (which files belong together), `line` and `stack` (where slices are),
//! `pixels` and `ybr` (their values); `unpack` with `rle`, `jpeg`, `jpeg_ls` and `jpeg_2000` (bytes of
//! frames), which share `segments` and `coded`.

mod coded;
mod dataset;
mod elements;
mod frame;
mod header;
mod jpeg;
mod jpeg_2000;
mod jpeg_ls;
mod line;
mod pixels;
mod rle;
mod scan;
mod segments;
mod stack;
mod syntax;
mod tags;
mod unpack;
mod ybr;

use std::path::{Path, PathBuf};

use slabsplat_core::{Grid, Modality, SampleType, Scaling};

use super::choices::{Choice, Part, VolumeChoices};
use super::colors::{Meaning, Values, Voxels};
use super::formats::{Input, Reader, VolumeListing};
use super::{LoadedVolume, VolumeFormat};
use crate::IoError;
use crate::store::Store;
use frame::{About, Frame};
use scan::{Scan, Series};
use stack::Stack;

/// The format.
pub(super) struct Dicom;

impl Reader for Dicom {
    fn listed(&self) -> &'static str {
        "DICOM (.dcm, or a folder)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["dcm", "dicom"]
    }

    fn is_begun_by(&self, start: &[u8]) -> bool {
        syntax::is_begun_by(start)
    }

    fn is_folder(&self, store: Store<'_>, folder: &Path, _files: &[PathBuf]) -> bool {
        scan::is_folder(store, folder)
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        let found = Found::of(input)?;
        found.read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let found = Found::of(input)?;
        let sample_type = sample_type(&found.series, &found.stack);
        Ok(VolumeListing {
            format: VolumeFormat::Dicom,
            dims: found.dims(),
            sample_type,
            choices: found.choices,
        })
    }
}

/// A series, and how its slices make a volume.
struct Found {
    series: Series,
    stack: Stack,
    choices: VolumeChoices,
    warnings: Vec<String>,
}

impl Found {
    fn of(input: &Input<'_>) -> Result<Self, IoError> {
        let mut scan = Scan::of(input.store, input.path)?;
        let mut warnings = Vec::new();
        if 0 < scan.n_others {
            warnings.push(format!("files that hold no slices were passed over: {}", scan.n_others));
        }
        if let Some((n, error)) = &scan.refused {
            warnings.push(format!("files that cannot be read were passed over: {n}; {error}"));
        }
        let largest = (0..scan.series.len()).rev().max_by_key(|&idx| scan.series[idx].n_pixels());
        let choice = Choice {
            n: scan.series.len(),
            names: scan.series.iter().map(Series::name).collect(),
            chosen: largest.unwrap_or(0),
        };
        let chosen = input.choose_of(Part::Series, choice)?;
        let series = scan.series.swap_remove(chosen.chosen);
        let mut stack = Stack::of(input, &series, &mut warnings)?;
        if series.layout.is_inverse {
            let what = "low values are meant to be bright (MONOCHROME1): they are read as they are";
            warnings.push(what.to_owned());
        }
        let mut choices = std::mem::take(&mut stack.choices);
        choices.series = chosen;
        if 1 < series.layout.n_channels {
            let VolumeChoices { channel, is_color, .. } =
                input.choose_values(&values(&series, &stack))?;
            (choices.channel, choices.is_color) = (channel, is_color);
        }
        Ok(Self { series, stack, choices, warnings })
    }

    fn dims(&self) -> [usize; 3] {
        let layout = self.series.layout;
        [layout.columns, layout.rows, self.stack.slices.len()]
    }

    fn read(self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        let path = input.path;
        let grid = Grid::new(self.dims(), self.stack.world_from_index)
            .map_err(|source| IoError::Grid { path: path.to_owned(), source })?;
        let Self { series, stack, choices, mut warnings } = self;
        let to_float = has_many_scalings(&stack.frames);
        let Frame { slope, intercept, .. } = stack.frames[0];
        let scaling = if to_float {
            let what = "slices have scalings of their own: values became 32-bit floats";
            warnings.push(what.to_owned());
            Scaling::IDENTITY
        } else {
            Scaling { slope, intercept }
        };
        let channel = (!choices.is_color).then_some(choices.channel.chosen);
        let samples = pixels::read(input, &series, &stack, to_float, channel)?;
        let voxels = Voxels { grid, samples, scaling, choices };
        let mut loaded = voxels.load(input, VolumeFormat::Dicom, warnings)?;
        loaded.acquisition.modality = modality(&series.about);
        Ok(loaded)
    }
}

/// By the defined terms of PS3.3 C.7.3.1.1.1.
fn modality(about: &About) -> Option<Modality> {
    match about.modality.trim() {
        "CT" => Some(Modality::Ct),
        "MR" => Some(Modality::Mr),
        "SM" | "GM" => Some(Modality::Microscopy),
        _ => None,
    }
}

fn sample_type(series: &Series, stack: &Stack) -> SampleType {
    match has_many_scalings(&stack.frames) {
        true => SampleType::F32,
        false => pixels::sample_type(&series.layout),
    }
}

/// The values of a pixel; they are no colour that could be shown if their largest is not that of their type.
fn values(series: &Series, stack: &Stack) -> Values {
    let layout = &series.layout;
    let is_whole = layout.bits_stored == layout.bits_allocated;
    Values {
        n: layout.n_channels,
        stored: sample_type(series, stack).into(),
        meaning: if is_whole { Meaning::Color } else { Meaning::Other },
    }
}

fn has_many_scalings(frames: &[Frame]) -> bool {
    let scaling = |frame: &Frame| (frame.slope, frame.intercept);
    frames.iter().any(|frame| scaling(frame) != scaling(&frames[0]))
}

#[cfg(test)]
mod tests;
