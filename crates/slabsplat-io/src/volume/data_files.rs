//! Where the data of a volume are: after the header, in one other file, or in many.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::IoError;
use crate::printable::shown_path;

/// The files that hold the data, in order. Each holds an equal share.
#[derive(Debug, PartialEq)]
pub(super) enum DataFiles {
    /// Behind the header, from this byte on.
    Attached(PathBuf, u64),
    /// Each of these.
    Given(Vec<PathBuf>),
    /// So many with numbers in their names. The names are made when they are needed: there are as
    /// many as the header says, which may be far too many.
    Numbered { folder: PathBuf, pattern: Pattern, first: i64, step: i64, n_files: usize },
}

/// A name with a number in it, such as `slice%03d.raw`.
#[derive(Debug, PartialEq)]
pub(super) struct Pattern {
    before: String,
    after: String,
    pads_with_zeros: bool,
    width: usize,
}

/// A volume up to so many bytes may be of one file that a list has again and again.
const MAX_REPEATED_BYTES: u64 = 256 << 20;

impl DataFiles {
    /// That a volume of so many bytes is not in few that are listed often.
    pub(super) fn check_backed(&self, header: &Path, n_bytes: u64) -> Result<(), IoError> {
        let Self::Given(paths) = self else { return Ok(()) };
        if n_bytes <= MAX_REPEATED_BYTES {
            return Ok(());
        }
        let mut seen = BTreeSet::new();
        match paths.iter().find(|path| !seen.insert(*path)) {
            None => Ok(()),
            Some(path) => {
                let path = shown_path(path);
                let what = format!("the volume is large, and lists {path} more than once");
                Err(IoError::malformed(header, what))
            }
        }
    }

    /// How many files there are, at least 1.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Attached(..) => 1,
            Self::Given(paths) => paths.len(),
            Self::Numbered { n_files, .. } => *n_files,
        }
    }

    /// A file, and the byte at which its data may begin.
    pub(super) fn get(&self, file_idx: usize) -> (PathBuf, u64) {
        match self {
            Self::Attached(path, offset) => (path.clone(), *offset),
            Self::Given(paths) => (paths[file_idx].clone(), 0),
            Self::Numbered { folder, pattern, first, step, .. } => {
                // The result lies between the header's bounds, the product maybe not.
                let number = first.wrapping_add(step.wrapping_mul(file_idx as i64));
                (folder.join(pattern.name(number)), 0)
            }
        }
    }
}

/// How many numbers there are from the first to the last, by steps; `None` if they do not lead there.
pub(super) fn count([min, max, step]: [i64; 3]) -> Option<u64> {
    let span = i128::from(max) - i128::from(min);
    let step = i128::from(step);
    if step == 0 || span.signum() * step.signum() < 0 {
        return None;
    }
    u64::try_from(span / step + 1).ok()
}

impl Pattern {
    /// `None` if there is not just one number in the name, or not as `%d`, `%03d` and the like.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (before, rest) = text.split_once('%')?;
        let end = rest.find(|c: char| !c.is_ascii_digit())?;
        let (digits, after) = rest.split_at(end);
        let after = after.strip_prefix(['d', 'i', 'u'])?;
        let width = if digits.is_empty() { 0 } else { digits.parse().ok()? };
        // A file name cannot be longer.
        let is_sane = width <= 255 && !after.contains('%');
        is_sane.then(|| Self {
            before: before.to_owned(),
            after: after.to_owned(),
            pads_with_zeros: digits.starts_with('0'),
            width,
        })
    }

    fn name(&self, number: i64) -> String {
        let Self { before, after, pads_with_zeros, width } = self;
        if *pads_with_zeros {
            format!("{before}{number:0width$}{after}")
        } else {
            format!("{before}{number:width$}{after}")
        }
    }
}
