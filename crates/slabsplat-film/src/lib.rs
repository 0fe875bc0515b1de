//! Films of slabsplat: what is between key frames, and frames as files that move.
//!
//! A [`Film`] is key frames of a scene: it tells the scene at any moment. [`Turn`] is the film that needs
//! none, a camera that goes around. [`FilmWriter`] takes frames one after the other, in a folder beside the
//! film from which an interrupted run continues, and makes the film of them. Whoever renders the frames is
//! the caller.
//!
//! ```
//! use slabsplat_core::Image;
//! use slabsplat_film::{FilmDesc, FilmError, FilmFormat, FilmWriter, FrameRate};
//!
//! # let dir = tempfile::tempdir()?;
//! # let path = dir.path().join("fade.gif");
//! let desc = FilmDesc::new(16, 16, 10, FrameRate::new(20.0)?)?;
//! let film = FilmWriter::begin(&path, FilmFormat::Gif, desc, "a fade")?;
//! let gray = |frame_idx: u32| {
//!     let value = frame_idx as f32 / 10.0;
//!     Ok::<_, FilmError>(Image::filled(16, 16, [value, value, value, 1.0]))
//! };
//! let report = film.make(gray, |_| ())?;
//! assert_eq!(report.n_frames, 10);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Reading order: `desc` and `format` (how long, how fast, as what), `motion` (scenes at moments), `folder`
//! (frames on disk), `metadata` (what they say of themselves), `encode` (a file of
//! them), `writer` (all of it in order), `memory` (the same without a disk), `error`.

#![deny(clippy::exhaustive_enums, clippy::exhaustive_structs)]

mod desc;
mod format;

mod motion;

mod encode;
mod folder;
mod memory;
mod metadata;
mod pixels;
mod writer;

mod error;

pub use desc::{FilmDesc, FrameRate};
pub use error::FilmError;
pub use format::FilmFormat;
pub use memory::FilmInMemory;
pub use metadata::{FilmFrame, Metadata};
pub use motion::{Film, Key, LayerKey, MotionError, Turn};
pub use writer::{FilmReport, FilmWriter, Step};
