//! MP4 and WebM by the program ffmpeg (<https://ffmpeg.org/ffmpeg.html>), which takes frames by a pipe as
//! they are made. Its sides are even, as 4:2:0 has one colour for 2 × 2 pixels: of an odd one the last row or
//! column is there twice.

use super::{Encoder, Frames};
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError, FilmFormat};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::{self, JoinHandle};

pub(super) struct Ffmpeg {
    child: Child,
    /// `None` once all frames were sent.
    stdin: Option<ChildStdin>,
    /// What it says, up to its end.
    said: Option<JoinHandle<Vec<u8>>>,
}

/// That there is an ffmpeg, for what needs one.
pub(crate) fn check(format: FilmFormat) -> Result<(), FilmError> {
    if !format.needs_ffmpeg() {
        return Ok(());
    }
    let silent = || Stdio::null();
    let mut command = Command::new("ffmpeg");
    command.arg("-version").stdin(silent()).stdout(silent()).stderr(silent());
    command.status().map(|_| ()).map_err(|error| of_start(format, &error))
}

fn of_start(format: FilmFormat, error: &io::Error) -> FilmError {
    match error.kind() {
        ErrorKind::NotFound => FilmError::NoFfmpeg { name: format.name() },
        _ => FilmError::Ffmpeg { what: error.to_string() },
    }
}

impl Ffmpeg {
    pub(super) fn new(format: FilmFormat, desc: &FilmDesc, path: &Path) -> Result<Self, FilmError> {
        let mut command = Command::new("ffmpeg");
        command
            .args(arguments(format, desc))
            .arg(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        // An interrupt from the terminal is the program's to handle; ffmpeg ends when no more frames come.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|error| of_start(format, &error))?;
        let stdin = child.stdin.take();
        let said = child.stderr.take().map(|stderr| thread::spawn(|| beginning(stderr)));
        Ok(Self { child, stdin, said })
    }

    /// What it says of its failure, or the error that was seen of it.
    fn failed(&mut self, error: &str) -> FilmError {
        self.stdin = None;
        // It ends, as there are no more frames.
        let _ = self.child.wait();
        let said = self.said.take().and_then(|said| said.join().ok()).unwrap_or_default();
        let said = first_lines(&String::from_utf8_lossy(&said));
        FilmError::Ffmpeg { what: if said.is_empty() { error.to_owned() } else { said } }
    }
}

/// How much of what ffmpeg says is kept.
const MAX_SAID: u64 = 1 << 16;

/// The beginning of what comes; the rest is read, so that nobody waits for it to be.
fn beginning(mut messages: impl Read) -> Vec<u8> {
    let mut kept = Vec::new();
    // What cannot be read was not said.
    let _ = messages.by_ref().take(MAX_SAID).read_to_end(&mut kept);
    let _ = io::copy(&mut messages, &mut io::sink());
    kept
}

/// The first two lines that are not empty; the others only follow from them.
fn first_lines(said: &str) -> String {
    let lines = said.lines().map(str::trim).filter(|line| !line.is_empty()).take(2);
    lines.collect::<Vec<_>>().join("; ")
}

/// All but the name of the file.
fn arguments(format: FilmFormat, desc: &FilmDesc) -> Vec<String> {
    let [frames, seconds] = desc.rate.fraction();
    let [width, height] = format.size(desc);
    let size = format!("{width}x{height}");
    let rate = format!("{frames}/{seconds}");
    let threads = desc.n_threads.min(MAX_THREADS).to_string();
    let input = [
        "-hide_banner",
        "-nostdin",
        "-loglevel",
        "error",
        "-y",
        "-f",
        "rawvideo",
        "-pixel_format",
        "rgb24",
        "-video_size",
        &size,
        "-framerate",
        &rate,
        "-i",
        "pipe:0",
        "-an",
        "-threads",
        &threads,
    ];
    // What sRGB's red, green and blue become in players: BT.709 in the limited range, said aloud.
    let color = [
        "-vf",
        "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int,format=yuv420p",
        "-colorspace",
        "bt709",
        "-color_primaries",
        "bt709",
        "-color_trc",
        "bt709",
        "-color_range",
        "tv",
        // Neither the time nor a random number is in the file.
        "-fflags",
        "+bitexact",
        "-flags:v",
        "+bitexact",
        "-map_metadata",
        "-1",
    ];
    // Smooth shades of a volume on a dark ground show bands where films of cameras show none.
    let codec: &[&str] = match format {
        FilmFormat::WebM => &[
            "-c:v",
            "libvpx-vp9",
            "-crf",
            "18",
            "-b:v",
            "0",
            "-deadline",
            "good",
            "-cpu-used",
            "3",
            "-row-mt",
            "1",
            "-f",
            "webm",
        ],
        _ => &[
            "-c:v",
            "libx264",
            "-preset",
            "medium",
            "-crf",
            "15",
            "-aq-mode",
            "3",
            "-movflags",
            "+faststart",
            "-f",
            "mp4",
        ],
    };
    input.iter().chain(&color).chain(codec).map(|&argument| argument.to_owned()).collect()
}

/// libvpx and x264 take no more.
const MAX_THREADS: usize = 16;

/// A picture with the last column and row twice, where they are odd.
fn padded(rgb: Vec<u8>, width: usize, height: usize) -> Vec<u8> {
    if width.is_multiple_of(2) && height.is_multiple_of(2) {
        return rgb;
    }
    let row_len = 3 * width;
    let mut even = Vec::with_capacity(rgb.len() + 3 * (width + height + 1));
    for y in 0..height.next_multiple_of(2) {
        let row = &rgb[y.min(height - 1) * row_len..][..row_len];
        even.extend_from_slice(row);
        if width % 2 == 1 {
            even.extend_from_slice(&row[row_len - 3..]);
        }
    }
    even
}

impl Encoder for Ffmpeg {
    fn add(&mut self, frame: &Pixels) -> Result<(), FilmError> {
        let rgb = padded(frame.before_black(), frame.width as usize, frame.height as usize);
        let written = match &mut self.stdin {
            Some(stdin) => stdin.write_all(&rgb),
            None => Err(ErrorKind::BrokenPipe.into()),
        };
        written.map_err(|error| self.failed(&error.to_string()))
    }

    fn finish(mut self: Box<Self>, _: &dyn Frames) -> Result<(), FilmError> {
        self.stdin = None;
        match self.child.wait() {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(self.failed(&status.to_string())),
            Err(error) => Err(self.failed(&error.to_string())),
        }
    }
}

impl Drop for Ffmpeg {
    /// Of a film that was not finished nothing is left running.
    fn drop(&mut self) {
        if self.stdin.take().is_some() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ffmpeg_frames_are_even() {
        let rgb: Vec<u8> = (0..9).collect();
        assert_eq!(padded(rgb.clone(), 3, 1), [0, 1, 2, 3, 4, 5, 6, 7, 8, 6, 7, 8].repeat(2));
        assert_eq!(padded(rgb[..6].to_vec(), 2, 1), [0, 1, 2, 3, 4, 5].repeat(2));
        assert_eq!(padded(rgb[..3].to_vec(), 1, 1), [0, 1, 2].repeat(4));
        assert_eq!(padded(vec![7; 12], 2, 2), [7; 12]);
    }

    #[test]
    fn ffmpeg_messages_are_bounded() {
        let said = [b"no space\n".repeat(20_000), b"end".to_vec()].concat();
        let kept = beginning(said.as_slice());
        assert_eq!(kept.len() as u64, MAX_SAID);
        assert_eq!(first_lines("\n  a \n\nb\nc"), "a; b");
    }
}
