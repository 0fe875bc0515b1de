//! Animated WebP (<https://developers.google.com/speed/webp/docs/riff_container>): lossless frames, each a
//! chunk `ANMF` around a still picture's `VP8L`.

use super::{Encoder, Frames};
use crate::metadata::Metadata;
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError, FrameRate};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

pub(super) struct WebPEncoder<W> {
    file: W,
    rate: FrameRate,
    has_opacity: bool,
    n_frames: u32,
    n_bytes: u64,
    xmp: Option<String>,
    path: PathBuf,
}

/// Flags of `VP8X`: there are frames; there is XMP; something may shine through them.
const IS_ANIMATED: u8 = 0x02;
const HAS_XMP: u8 = 0x04;
const HAS_OPACITY: u8 = 0x10;

/// Flag of `ANMF`: a frame replaces what was there, instead of lying over it.
const REPLACES: u8 = 0x02;

impl<W: Write + Seek> WebPEncoder<W> {
    /// Writes to `file`, which errors call `path`.
    pub(super) fn new(
        desc: &FilmDesc,
        file: W,
        path: &Path,
        metadata: &Metadata,
    ) -> Result<Self, FilmError> {
        let FilmDesc { width, height, rate, has_opacity, .. } = *desc;
        let mut encoder = Self {
            file,
            rate,
            has_opacity,
            n_frames: 0,
            n_bytes: 0,
            xmp: metadata.xmp.clone(),
            path: path.to_owned(),
        };
        encoder.begin(width, height).map_err(FilmError::write(path))?;
        Ok(encoder)
    }

    fn begin(&mut self, width: u32, height: u32) -> io::Result<()> {
        // How many bytes there are is known at the end.
        self.write(b"RIFF\0\0\0\0WEBP")?;
        let flags = [(self.has_opacity, HAS_OPACITY), (self.xmp.is_some(), HAS_XMP)];
        let flags = flags.into_iter().filter(|(is_set, _)| *is_set);
        let flags = flags.fold(IS_ANIMATED, |flags, (_, flag)| flags | flag);
        let mut about = vec![flags, 0, 0, 0];
        about.extend([width, height].iter().flat_map(|side| three_bytes(side - 1)));
        self.write(&header(b"VP8X", about.len())?)?;
        self.write(&about)?;
        // The background is black, and the film is shown again and again.
        self.write(&header(b"ANIM", 6)?)?;
        self.write(&[0; 6])
    }

    fn frame(&mut self, frame: &Pixels) -> io::Result<()> {
        let picture = frame.vp8l(self.has_opacity)?;
        let mut about = vec![0; 6];
        about.extend([frame.width, frame.height].iter().flat_map(|side| three_bytes(side - 1)));
        about.extend(three_bytes(self.rate.ticks(self.n_frames, 1000)));
        about.push(REPLACES);
        self.n_frames += 1;
        self.write(&header(b"ANMF", about.len() + picture.len())?)?;
        self.write(&about)?;
        self.write(&picture)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.n_bytes += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    fn write_end(&mut self) -> io::Result<()> {
        if let Some(xmp) = self.xmp.take() {
            self.write(&header(b"XMP ", xmp.len())?)?;
            self.write(xmp.as_bytes())?;
            // Chunks begin at even places.
            self.write(&[0][..xmp.len() % 2])?;
        }
        let n_bytes = u32::try_from(self.n_bytes - 8)
            .map_err(|_| io::Error::other("a WebP has up to 4 GiB: take apng or png-sequence"))?;
        self.file.seek(SeekFrom::Start(4))?;
        self.file.write_all(&n_bytes.to_le_bytes())?;
        self.file.flush()
    }
}

fn header(name: &[u8; 4], n_bytes: usize) -> io::Result<Vec<u8>> {
    let n_bytes = u32::try_from(n_bytes).map_err(|_| io::Error::other("a frame is too large"))?;
    Ok([*name, n_bytes.to_le_bytes()].concat())
}

fn three_bytes(number: u32) -> [u8; 3] {
    let [a, b, c, _] = number.to_le_bytes();
    [a, b, c]
}

impl<W: Write + Seek + Send> Encoder for WebPEncoder<W> {
    fn add(&mut self, frame: &Pixels) -> Result<(), FilmError> {
        self.frame(frame).map_err(FilmError::write(&self.path))
    }

    fn finish(mut self: Box<Self>, _: &dyn Frames) -> Result<(), FilmError> {
        self.write_end().map_err(FilmError::write(&self.path))
    }
}
