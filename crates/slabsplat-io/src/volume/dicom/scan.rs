//! Which files of a folder are slices, and of which series.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use super::super::stream::MAX_GZIP_RATIO;
use super::frame::{About, Frame, Layout, frames};
use super::header::{Header, PixelElement};
use super::syntax::{Syntax, is_begun_by};
use crate::IoError;
use crate::printable::printable;
use crate::store::Store;

/// Folders in folders, as archives write them: patient, study, series.
const MAX_DEPTH: usize = 8;

/// Files that are looked at; a day of a large hospital.
const MAX_FILES: usize = 1 << 18;

/// Frames that are looked at to find out whether two belong together.
const MAX_STACKS: usize = 256;

/// A file with slices.
#[derive(Debug)]
pub(super) struct SliceFile {
    pub(super) path: PathBuf,
    pub(super) syntax: Syntax,
    pub(super) pixels: PixelElement,
}

/// Slices of one series that lie in one direction and are stored alike.
#[derive(Debug)]
pub(super) struct Series {
    pub(super) about: About,
    pub(super) layout: Layout,
    pub(super) files: Vec<SliceFile>,
    pub(super) frames: Vec<Frame>,
}

/// What a folder holds.
#[derive(Debug, Default)]
pub(super) struct Scan {
    pub(super) series: Vec<Series>,
    /// Files that hold no slices.
    pub(super) n_others: usize,
    /// Files that hold slices that cannot be read, and why the first cannot.
    pub(super) refused: Option<(usize, IoError)>,
}

/// Whether any of the first files is one of DICOM.
pub(super) fn is_folder(store: Store<'_>, folder: &Path) -> bool {
    let mut files = Vec::new();
    walk(store, folder, 0, &mut files);
    files.iter().take(64).any(|file| starts_as_dicom(store, file))
}

fn starts_as_dicom(store: Store<'_>, file: &Path) -> bool {
    super::super::stream::first_bytes(store, file).is_ok_and(|start| is_begun_by(&start))
}

/// Whether the file lists those of its folder, which all such files are named for (PS3.10 §8.6).
fn is_directory(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name == "DICOMDIR")
}

/// All files below a folder, as far as they can be listed.
fn walk(store: Store<'_>, folder: &Path, depth: usize, all: &mut Vec<PathBuf>) {
    let Ok((files, folders)) = store.entries_in(folder) else { return };
    all.extend(files.into_iter().take(MAX_FILES - all.len().min(MAX_FILES)));
    if depth < MAX_DEPTH {
        folders.iter().for_each(|folder| walk(store, folder, depth + 1, all));
    }
}

impl Scan {
    /// Of all files below a folder, also by the file that lists them, or of one file.
    pub(super) fn of(store: Store<'_>, path: &Path) -> Result<Self, IoError> {
        let mut scan = Self::default();
        let path = if is_directory(path) { path.parent().unwrap_or(Path::new("")) } else { path };
        if !store.is_folder(path) {
            scan.take_file(store, path)?;
            scan.finish(path)?;
            return Ok(scan);
        }
        let mut files = Vec::new();
        walk(store, path, 0, &mut files);
        for file in files.iter().filter(|file| !is_directory(file)) {
            if !starts_as_dicom(store, file) {
                scan.n_others += 1;
            } else if let Err(error) = scan.take_file(store, file) {
                let n_before = scan.refused.as_ref().map_or(0, |(n, _)| *n);
                let first = scan.refused.take().map_or(error, |(_, first)| first);
                scan.refused = Some((n_before + 1, first));
            }
        }
        scan.finish(path)?;
        Ok(scan)
    }

    fn take_file(&mut self, store: Store<'_>, path: &Path) -> Result<(), IoError> {
        let file = store.open(path)?;
        let n_bytes = file.n_bytes().map_err(IoError::read(path))?;
        let header = Header::read(path, BufReader::new(file))?;
        let layout = Layout::of(path, &header)?;
        let (Some(layout), Some(pixels)) = (layout, header.pixels) else {
            self.n_others += 1;
            return Ok(());
        };
        let about = About::of(&header.dataset);
        // Frames of one file may lie in several directions.
        let mut file_idx_of = BTreeMap::new();
        let n_backed = pixels.n_frames_at_most(n_bytes, header.syntax.is_deflated, &layout);
        for frame in frames(path, &header.dataset, 0, n_backed)? {
            let series_idx = self.series_of(path, &about, layout, &frame)?;
            let series = &mut self.series[series_idx];
            let file_idx = *file_idx_of.entry(series_idx).or_insert_with(|| {
                let syntax = header.syntax;
                series.files.push(SliceFile { path: path.to_owned(), syntax, pixels });
                series.files.len() - 1
            });
            series.frames.push(Frame { file_idx, ..frame });
        }
        Ok(())
    }

    /// The series that a frame belongs to, which may be a new one.
    fn series_of(
        &mut self,
        path: &Path,
        about: &About,
        layout: Layout,
        frame: &Frame,
    ) -> Result<usize, IoError> {
        let is_it = |series: &Series| {
            series.about.series_uid == about.series_uid
                && series.layout == layout
                && are_alike(frame, &series.frames[0])
        };
        // The last is the likeliest.
        if let Some(series_idx) = self.series.iter().rposition(is_it) {
            return Ok(series_idx);
        }
        if self.series.len() == MAX_STACKS {
            let what = format!("there are more than {MAX_STACKS} series: name a folder with fewer");
            return Err(IoError::unsupported(path, what));
        }
        let (files, frames) = (Vec::new(), Vec::new());
        self.series.push(Series { about: about.clone(), layout, files, frames });
        Ok(self.series.len() - 1)
    }

    /// Orders series by their numbers. There must be one.
    fn finish(&mut self, path: &Path) -> Result<(), IoError> {
        self.series.retain(|series| !series.frames.is_empty());
        self.series.sort_by(|a, b| {
            let key = |series: &Series| (series.about.number, series.about.series_uid.clone());
            key(a).cmp(&key(b))
        });
        if !self.series.is_empty() {
            return Ok(());
        }
        if let Some((_, error)) = self.refused.take() {
            return Err(error);
        }
        Err(IoError::malformed(path, "there are no images in it"))
    }
}

/// Whether two frames lie in one direction, and have pixels of one size.
fn are_alike(one: &Frame, other: &Frame) -> bool {
    let is_near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * a.abs();
    let axes = match (one.axes, other.axes) {
        (Some([x, y]), Some([x0, y0])) => 0.9999 < x.dot(x0) && 0.9999 < y.dot(y0),
        (axes, axes0) => axes.is_none() && axes0.is_none(),
    };
    axes && match (one.spacing, other.spacing) {
        (Some([x, y]), Some([x0, y0])) => is_near(x, x0) && is_near(y, y0),
        (spacing, spacing0) => spacing.is_none() && spacing0.is_none(),
    }
}

/// A fragment is behind its tag and its length.
const FRAGMENT_BYTES: u64 = 8;

impl PixelElement {
    /// Frames that a file of so many bytes has room for.
    fn n_frames_at_most(&self, n_bytes: u64, is_deflated: bool, layout: &Layout) -> u64 {
        let n_left = match is_deflated {
            true => n_bytes.saturating_mul(MAX_GZIP_RATIO),
            false => n_bytes.saturating_sub(self.offset),
        };
        match self.n_bytes {
            Some(n_bytes) => n_left.min(u64::from(n_bytes)) / layout.frame_bytes().max(1),
            None => n_left / FRAGMENT_BYTES,
        }
    }
}

impl Series {
    /// For lists: `CT 3 "Head 5.0", 28 slices of 512 x 512`.
    pub(super) fn name(&self) -> String {
        let About { modality, number, description, .. } = &self.about;
        let number = number.map(|number| format!(" {number}")).unwrap_or_default();
        let description: String = printable(description).chars().take(64).collect();
        let modality: String = printable(modality).chars().take(16).collect();
        let Layout { rows, columns, .. } = self.layout;
        let n_frames = self.frames.len();
        format!("{modality}{number} {description:?}, {n_frames} slices of {columns} x {rows}")
    }

    pub(super) fn n_pixels(&self) -> u64 {
        (self.layout.n_pixels() as u64).saturating_mul(self.frames.len() as u64)
    }
}
