//! What can go wrong with a film.

use crate::{FilmDesc, FrameRate};
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a film cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The rate is out of range.
    #[error("a film has {min} to {max} frames a second, and not {0}",
        min = FrameRate::RANGE[0], max = FrameRate::RANGE[1])]
    BadRate(f64),
    /// The length is no length.
    #[error("a film lasts a positive number of seconds, and not {0}")]
    BadSeconds(f64),
    /// There are too few frames or too many.
    #[error(
        "a film has 1 to {max} frames, which last {} seconds at {} a second, and not {n_frames}",
        (f64::from(FilmDesc::MAX_FRAMES) / rate.per_second()).round(), rate.per_second(),
        max = FilmDesc::MAX_FRAMES
    )]
    BadLength {
        /// How many.
        n_frames: f64,
        /// How fast.
        rate: FrameRate,
    },
    /// A format has no room for such frames.
    #[error("{name} has frames of up to {max_side} pixels a side, and not {width} x {height}")]
    TooLarge {
        /// The format.
        name: &'static str,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// The longest side.
        max_side: u32,
    },
    /// A format has no such short frames.
    #[error("{name} shows at most {max} frames a second")]
    TooFast {
        /// The format.
        name: &'static str,
        /// Frames a second.
        max: f64,
    },
    /// Of a film in memory other frames came than it has.
    #[error("the film has {expected} frames, and {found} came")]
    WrongCount {
        /// How many came.
        found: u32,
        /// How many it has.
        expected: u32,
    },
    /// A format of which no film is made in memory.
    #[error("a film in memory is a gif, webp or apng: {name} needs a disk")]
    NotInMemory {
        /// The format.
        name: &'static str,
    },
    /// The program ffmpeg is not there.
    #[error(
        "{name} is made by the program ffmpeg, which is not installed: gif, webp, apng and png-sequence need no \
         other program"
    )]
    NoFfmpeg {
        /// The format.
        name: &'static str,
    },
    /// The program ffmpeg fails.
    #[error("ffmpeg cannot make the film: {what}")]
    Ffmpeg {
        /// What it says.
        what: String,
    },
    /// The folder of frames has those of another film.
    #[error(
        "{} has frames of another film, which differs in {what}: remove that folder, or begin anew",
        folder.display()
    )]
    OtherFilm {
        /// The folder of frames.
        folder: PathBuf,
        /// The first thing that differs.
        what: String,
    },
    /// Something else stands where the film, or its frames, would be.
    #[error("{} is in the way: it is no film, and has no frames of slabsplat's", path.display())]
    InTheWay {
        /// Where.
        path: PathBuf,
    },
    /// Two runs make one film.
    #[error("another run is making that film: its frames in {} are taken", folder.display())]
    InUse {
        /// The folder of frames.
        folder: PathBuf,
    },
    /// A frame on disk is damaged.
    #[error("frame {frame_idx} in {} is damaged: {what}", folder.display())]
    BadFrame {
        /// Which, from 0 on.
        frame_idx: u32,
        /// The folder of frames.
        folder: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A frame is of another size than its film.
    #[error("frame {frame_idx} has {found:?} pixels, and the film {expected:?}")]
    WrongSize {
        /// Which, from 0 on.
        frame_idx: u32,
        /// Width and height of the frame.
        found: [u32; 2],
        /// Those of the film.
        expected: [u32; 2],
    },
    /// A file cannot be written, or a folder.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The thread that stores frames has panicked.
    #[error("the film's encoder panicked")]
    Panicked,
}

impl FilmError {
    pub(crate) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Write { path, source }
    }
}
