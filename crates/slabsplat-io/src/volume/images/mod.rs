//! A folder of images, each of them a slice, in the order that a person would count them in: TIFF, PNG, JPEG.
//!
//! Names decide which files are slices and in which order; content decides what a file is. All must have one
//! size and one type. Such folders do not say how large voxels are. Not read: files of several pages, and
//! OME-TIFFs, which say themselves which files belong together: name one of them.
//!
//! Reading order: `names` (which files, in which order), `picture` (one file).

mod names;
mod picture;

use std::path::{Path, PathBuf};

use slabsplat_core::{Grid, Scaling};

use super::buffer::{Endian, ReadFailure};
use super::colors::{Values, Voxels};
use super::formats::{Input, Reader, VolumeListing};
use super::{LoadedVolume, VolumeFormat, parallel};
use crate::IoError;
use crate::store::Store;
use names::Slices;
use picture::Picture;

pub(super) use picture::MAX_JPEG_ROWS;

/// The format.
pub(super) struct Images;

impl Reader for Images {
    fn listed(&self) -> &'static str {
        "a folder of images (.tif, .png, .jpg)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &[]
    }

    fn is_begun_by(&self, _start: &[u8]) -> bool {
        false
    }

    fn is_folder(&self, _store: Store<'_>, _folder: &Path, files: &[PathBuf]) -> bool {
        Slices::of(files).is_some()
    }

    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError> {
        read(input)
    }

    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError> {
        let slices = slices(input)?;
        let first = Picture::open(input.store, &slices.paths[0])?;
        Ok(VolumeListing {
            format: VolumeFormat::Images,
            dims: [first.size[0], first.size[1], slices.paths.len()],
            sample_type: first.values.stored.widest(),
            choices: input.choose_values(&first.values)?,
        })
    }
}

fn slices(input: &Input<'_>) -> Result<Slices, IoError> {
    let files = input.store.files_in(input.path)?;
    Slices::of(&files).ok_or_else(|| IoError::malformed(input.path, "the folder holds no images"))
}

fn read(input: &Input<'_>) -> Result<LoadedVolume, IoError> {
    let Slices { paths, n_others } = slices(input)?;
    let first = Picture::open(input.store, &paths[0])?;
    let (size, values) = (first.size, first.values);
    let choices = input.choose_values(&values)?;
    let stored = values.stored;
    let grid = Grid::with_spacing([size[0], size[1], paths.len()], [1.0; 3])
        .map_err(|source| IoError::Grid { path: input.path.to_owned(), source })?;
    drop(first);
    let mut buffer = input.buffer(stored, Endian::NATIVE);
    let n_samples = grid.n_voxels().saturating_mul(choices.n_read());
    let meter = input.meter(n_samples as u64 * stored.size_bytes() as u64);
    let unpack = |(): &mut (), path: &PathBuf| {
        let picture = Picture::open(input.store, path)?;
        check_like_first(path, &picture, &paths[0], size, values)?;
        let mut samples = Vec::new();
        picture.read_into(path, &mut samples)?;
        choices.keep_read(&mut samples, stored.size_bytes());
        Ok(samples)
    };
    let take = |path: &PathBuf, samples: Vec<u8>| {
        let n_samples = samples.len() / stored.size_bytes();
        buffer.append(&mut samples.as_slice(), n_samples, true).map_err(
            |failure| match failure {
                ReadFailure::TooShort(_) => IoError::malformed(path, "the image is cut off"),
                ReadFailure::Io(source) => IoError::Read { path: path.clone(), source },
            },
        )?;
        meter.advance(samples.len() as u64).map_err(IoError::from)
    };
    let mut workers = vec![(); parallel::n_workers(paths.len())];
    parallel::in_order(&mut workers, &paths, unpack, take)?;
    let mut warnings =
        vec!["images do not say how large voxels are: 1 x 1 x 1 was assumed".to_owned()];
    if 0 < n_others {
        warnings.push(format!("files that are none of the images were passed over: {n_others}"));
    }
    let samples = buffer.finish(&mut warnings);
    let voxels = Voxels { grid, samples, scaling: Scaling::IDENTITY, choices };
    voxels.load(input, VolumeFormat::Images, warnings)
}

fn check_like_first(
    path: &Path,
    picture: &Picture<'_>,
    first: &Path,
    size: [usize; 2],
    values: Values,
) -> Result<(), IoError> {
    if (picture.size, picture.values) == (size, values) {
        return Ok(());
    }
    let ([w, h], [w0, h0]) = (picture.size, size);
    let other = picture.values;
    let what = format!(
        "the image has {w} x {h} pixels of {other}, and the first, {}, {w0} x {h0} of {values}: a volume \
         needs slices of one size and type",
        first.display()
    );
    Err(IoError::unsupported(path, what))
}

#[cfg(test)]
mod tests;
