//! A film, from its first frame to its last.

use crate::encode::{Encoder, encoder};
use crate::folder::{FrameFolder, check_sequence};
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError, FilmFormat};
use slabsplat_core::Image;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

/// Frames that wait between whoever renders and the encoder. More would only take memory: on average the
/// slower of the two decides.
const N_WAITING: usize = 2;

/// A film that has begun.
pub struct FilmWriter {
    target: PathBuf,
    format: FilmFormat,
    desc: FilmDesc,
    folder: FrameFolder,
    n_done: u32,
}

impl std::fmt::Debug for FilmWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { target, format, desc, folder: _, n_done } = self;
        f.debug_struct("FilmWriter")
            .field("target", target)
            .field("format", format)
            .field("desc", desc)
            .field("n_done", n_done)
            .finish_non_exhaustive()
    }
}

/// What has been done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// One more frame is rendered; so many are.
    Rendered(u32),
    /// All frames are rendered, and the file is being made of those that were not yet taken.
    Ending,
}

/// A film that was made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FilmReport {
    /// All of its frames.
    pub n_frames: u32,
    /// Those that were there before.
    pub n_continued: u32,
    /// How long it is.
    pub seconds: f64,
    /// How large it is on disk; of a folder, all of its files.
    pub n_bytes: u64,
}

impl FilmWriter {
    /// Begins the film `target`, or continues it if frames of it are in the folder `target.frames`.
    ///
    /// `identity` is a text that tells films apart, with all that decides about its pixels; lines of `key =
    /// value` are named in the error if they differ. Frames are retained in that folder until the film is
    /// done, and a film that is continued has the same bytes as one that is made in one go, as far as ffmpeg
    /// makes the same of the same frames.
    ///
    /// # Errors
    /// If the format has no room for such frames, there is no ffmpeg and it is needed, the folder has frames
    /// of another film or is in use, or files cannot be written.
    pub fn begin(
        target: impl Into<PathBuf>,
        format: FilmFormat,
        desc: FilmDesc,
        identity: &str,
    ) -> Result<Self, FilmError> {
        Self::open(target.into(), format, desc, identity, false)
    }

    /// The same from the first frame on, whatever is there.
    ///
    /// # Errors
    /// As [`begin`](Self::begin), but for frames of another film, which are removed.
    pub fn begin_anew(
        target: impl Into<PathBuf>,
        format: FilmFormat,
        desc: FilmDesc,
        identity: &str,
    ) -> Result<Self, FilmError> {
        Self::open(target.into(), format, desc, identity, true)
    }

    fn open(
        target: PathBuf,
        format: FilmFormat,
        desc: FilmDesc,
        identity: &str,
        anew: bool,
    ) -> Result<Self, FilmError> {
        format.check(&desc)?;
        format.check_program()?;
        if format == FilmFormat::PngSequence {
            check_sequence(&target)?;
        } else if target.symlink_metadata().is_ok_and(|metadata| !metadata.is_file()) {
            return Err(FilmError::InTheWay { path: target });
        }
        let size = [desc.width, desc.height, desc.n_frames];
        let about = format!("{identity}\nframes = {size:?}\nopacity = {}\n", desc.has_opacity);
        let (folder, n_done) = FrameFolder::open(&target, &desc, &about, anew)?;
        Ok(Self { target, format, desc, folder, n_done })
    }

    /// How many frames are there already, from the first one on.
    pub fn n_done(&self) -> u32 {
        self.n_done
    }

    /// Has all other frames rendered, in order, while a thread stores those before; then the film is there.
    ///
    /// `render` is given the number of a frame, from 0 on. `tell` hears of each step.
    ///
    /// # Errors
    /// As `render`; or if a frame has another size, or the film cannot be stored. What is rendered then stays
    /// in the folder of frames.
    pub fn make<E: From<FilmError>>(
        self,
        mut render: impl FnMut(u32) -> Result<Image, E>,
        mut tell: impl FnMut(Step),
    ) -> Result<FilmReport, E> {
        let Self { target, format, desc, folder, n_done } = self;
        let made = folder.beside("film.part");
        // An ffmpeg of a run that was killed may still be writing what it had, and goes on with a file of no
        // name.
        if let Err(error) = fs::remove_file(&made)
            && error.kind() != ErrorKind::NotFound
        {
            return Err(FilmError::write(&made)(error).into());
        }
        let (sender, receiver) = sync_channel(N_WAITING);
        thread::scope(|scope| {
            let (folder, made) = (&folder, &made);
            let encoding = scope.spawn(move || {
                let encoder = encoder(format, &desc, made)?;
                store(folder, &desc, encoder, n_done, receiver)
            });
            for frame_idx in n_done..desc.n_frames {
                let image = render(frame_idx)?;
                // An encoder that does not listen any more says why when it is joined.
                if sender.send(image).is_err() {
                    break;
                }
                tell(Step::Rendered(frame_idx + 1));
            }
            drop(sender);
            tell(Step::Ending);
            Ok::<_, E>(encoding.join().unwrap_or(Err(FilmError::Panicked))?)
        })?;
        match format {
            FilmFormat::PngSequence => folder.end_as_folder(&target)?,
            _ => folder.end_with_file(&made, &target)?,
        }
        let FilmDesc { n_frames, .. } = desc;
        let n_bytes = n_bytes_of(&target).map_err(FilmError::write(&target))?;
        Ok(FilmReport { n_frames, n_continued: n_done, seconds: desc.seconds(), n_bytes })
    }
}

/// Stores frames as they come, and gives the encoder all of them, those from before first.
fn store(
    folder: &FrameFolder,
    desc: &FilmDesc,
    mut encoder: Option<Box<dyn Encoder>>,
    n_done: u32,
    images: Receiver<Image>,
) -> Result<(), FilmError> {
    if let Some(encoder) = &mut encoder {
        (0..n_done).try_for_each(|frame_idx| encoder.add(&folder.read(frame_idx)?))?;
    }
    let mut n_stored = n_done;
    for image in images {
        let found = [image.width(), image.height()];
        let expected = [desc.width, desc.height];
        if found != expected {
            return Err(FilmError::WrongSize { frame_idx: n_stored, found, expected });
        }
        let frame = Pixels::of(&image);
        folder.write(n_stored, &frame)?;
        if let Some(encoder) = &mut encoder {
            encoder.add(&frame)?;
        }
        n_stored += 1;
    }
    // Whoever renders has failed: there is no film.
    if n_stored < desc.n_frames {
        return Ok(());
    }
    encoder.map_or(Ok(()), |encoder| encoder.finish(folder))
}

fn n_bytes_of(path: &Path) -> std::io::Result<u64> {
    if path.is_file() {
        return Ok(path.metadata()?.len());
    }
    fs::read_dir(path)?.map(|entry| Ok(entry?.metadata()?.len())).sum()
}
