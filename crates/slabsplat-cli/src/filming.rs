//! The making of a film: frames in order, how far it is, and what is said of it.

use crate::flags::{FilmFlags, SceneFlags};
use crate::progress::Progress;
use crate::{advice, columns, output, terminal};
use anyhow::{Error, Result};
use serde_json::{Value, json};
use slabsplat::film::{FilmDesc, FilmFormat, FilmReport, FrameRate, Step};
use slabsplat::io;
use slabsplat::{Caps, FrameHandle, OpenScene, Renderer, Scene};
use std::path::Path;
use std::time::{Duration, Instant};

/// A film that is to be made.
pub(crate) struct Filming<'a> {
    pub(crate) flags: &'a FilmFlags,
    pub(crate) scene_flags: &'a SceneFlags,
    pub(crate) path: &'a Path,
    pub(crate) format: FilmFormat,
    pub(crate) started: Instant,
    pub(crate) renderer: Renderer,
    pub(crate) opened: OpenScene,
    pub(crate) length: (u32, FrameRate),
    /// What tells it from other films of the same scene, in lines of `key = value`.
    pub(crate) motion: String,
}

impl Filming<'_> {
    /// Makes the film, of which `scene_at` tells the scene of each frame.
    pub(crate) fn run(mut self, scene_at: impl Fn(u32) -> Result<Scene>) -> Result<()> {
        let desc = self.flags.desc(self.format, &self.opened.scene, self.length)?;
        let identity = self.identity()?;
        let film = self.flags.begin(self.path, self.format, desc, &identity)?;
        let mut counter = Counter::start(film.n_done(), desc.n_frames);
        output::say_when_interrupted(Some(format!(
            "interrupted: the same command continues {} with the frames that are there",
            self.path.display()
        )));
        let acquisition = self.opened.acquisition;
        let mut notes: Vec<String> = Vec::new();
        let render = |frame_idx| {
            let (scene, watched) = (scene_at(frame_idx)?, FrameHandle::new());
            let picture = advice::picture(&mut self.renderer, &scene, acquisition, &watched)?;
            // What is said of a frame is said once.
            for note in picture.notes {
                if !notes.contains(&note) {
                    terminal::warn(&note);
                    notes.push(note);
                }
            }
            Ok::<_, Error>(picture.frame.image)
        };
        let made = film.make(render, |step| counter.step(step));
        output::say_when_interrupted(None);
        drop(counter);
        let report = self.scene_flags.in_scene(|| made)?;
        self.tell(&desc, &report)
    }

    /// All that decides about its pixels.
    fn identity(&mut self) -> Result<String> {
        let caps = self.renderer.caps();
        caps.name.clone_into(&mut self.opened.backend);
        let scene = io::scene_text(&self.opened.to_file()?, self.path)?;
        let (device, motion, program) = (&caps.device, &self.motion, io::Provenance::PROGRAM);
        Ok(format!(
            "Frames of a film that is being made; the command that began it continues it.\n\
             program = {program}\ndevice = {device}\n{motion}{scene}"
        ))
    }

    fn tell(&self, desc: &FilmDesc, report: &FilmReport) -> Result<()> {
        for found in &self.opened.found {
            terminal::detail(format_args!("shown as {found}"));
        }
        let [width, height] = self.format.size(desc);
        let continued = match report.n_continued {
            0 => String::new(),
            n => format!(", {n} of them from before"),
        };
        terminal::say(format_args!(
            "{}: {width} x {height} pixels, {} frames{continued}, {:.2} s at {} a second, {}, in {} s",
            self.path.display(),
            report.n_frames,
            report.seconds,
            desc.rate.per_second(),
            columns::bytes(report.n_bytes),
            self.started.elapsed().as_secs(),
        ));
        let answer = json_of(self, desc, report, self.renderer.caps());
        if self.flags.json { terminal::answer(&format!("{answer:#}\n")) } else { Ok(()) }
    }
}

fn json_of(film: &Filming<'_>, desc: &FilmDesc, report: &FilmReport, caps: &Caps) -> Value {
    let [width, height] = film.format.size(desc);
    json!({
        "film": film.path.display().to_string(),
        "format": film.format.name(),
        "codec": film.format.codec(),
        "width": width,
        "height": height,
        "frames": report.n_frames,
        "continued": report.n_continued,
        "fps": desc.rate.per_second(),
        "duration": report.seconds,
        "bytes": report.n_bytes,
        "seconds": film.started.elapsed().as_secs_f64(),
        "backend": caps.name,
        "device": caps.device,
        "warnings": terminal::take_warnings(),
    })
}

/// How far a film is: a bar on a terminal, elsewhere a line now and then.
struct Counter {
    bar: Progress,
    n_before: u32,
    n_frames: u32,
    started: Instant,
    told: Instant,
}

/// The least time between two lines.
const BETWEEN_LINES: Duration = Duration::from_secs(10);

impl Counter {
    fn start(n_before: u32, n_frames: u32) -> Self {
        if 0 < n_before {
            terminal::say(format_args!("continued: {n_before} of {n_frames} frames are there"));
        }
        let bar = Progress::start("rendering", n_frames as usize);
        bar.begin_at(n_before.into());
        let now = Instant::now();
        Self { bar, n_before, n_frames, started: now, told: now }
    }

    fn step(&mut self, step: Step) {
        match step {
            Step::Rendered(n_done) => {
                self.bar.step();
                if !Progress::is_seen()
                    && BETWEEN_LINES < self.told.elapsed()
                    && n_done < self.n_frames
                {
                    self.told = Instant::now();
                    terminal::say(format_args!("{}", self.line(n_done)));
                }
            }
            _ => self.bar.stage("encoding"),
        }
    }

    fn line(&self, n_done: u32) -> String {
        let n_here = n_done.saturating_sub(self.n_before).max(1);
        let of_one = self.started.elapsed().as_secs_f64() / f64::from(n_here);
        line(n_done, self.n_frames, of_one)
    }
}

/// How far a film is whose frames take so many seconds each.
fn line(n_done: u32, n_frames: u32, seconds_of_one: f64) -> String {
    let percent = u64::from(n_done) * 100 / u64::from(n_frames);
    let left = duration(seconds_of_one * f64::from(n_frames - n_done));
    format!("{n_done} of {n_frames} frames, {percent} %, {left} left")
}

/// Seconds as people say them.
fn duration(seconds: f64) -> String {
    let seconds = seconds.round().max(0.0) as u64;
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    match (hours, minutes) {
        (0, 0) => format!("{seconds} s"),
        (0, _) => format!("{minutes} min {} s", seconds % 60),
        _ => format!("{hours} h {minutes} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_says_what_is_left() {
        assert_eq!(line(12, 90, 0.5), "12 of 90 frames, 13 %, 39 s left");
        assert_eq!(line(1, 100_000, 2.0), "1 of 100000 frames, 0 %, 55 h 33 min left");
    }

    #[test]
    fn duration_as_people_say_it() {
        let cases = [(0.2, "0 s"), (59.4, "59 s"), (61.0, "1 min 1 s"), (7384.0, "2 h 3 min")];
        for (seconds, expected) in cases {
            assert_eq!(duration(seconds), expected);
        }
    }
}
