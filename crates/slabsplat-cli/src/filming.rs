//! The making of a film: frames in order, how far it is, and what is said of it.

use crate::flags::{FilmFlags, SceneFlags};
use crate::painter::Painter;
use crate::plain::counted;
use crate::progress::Progress;
use crate::ranks::{Ranks, Team};
use crate::{columns, output, terminal};
use anyhow::{Error, Result, anyhow};
use serde_json::{Value, json};
use slabsplat::Scene;
use slabsplat::film::{
    FilmDesc, FilmError, FilmFormat, FilmFrame, FilmReport, FrameRate, Step, Turn,
};
use slabsplat::io::{self, Provenance, SceneFile};
use std::path::Path;
use std::time::{Duration, Instant};

/// A film that is to be made.
pub(crate) struct Filming<'a> {
    pub(crate) flags: &'a FilmFlags,
    pub(crate) scene_flags: &'a SceneFlags,
    pub(crate) path: &'a Path,
    pub(crate) format: FilmFormat,
    pub(crate) started: Instant,
    pub(crate) painter: Painter,
    pub(crate) length: (u32, FrameRate),
    /// Who else draws frames.
    pub(crate) ranks: Option<&'a Ranks>,
}

impl Filming<'_> {
    /// Makes the film, of which `scene_at` tells the scene of each frame. Of several ranks the first makes
    /// it, and the others draw frames for it.
    pub(crate) fn run(mut self, scene_at: impl Fn(u32) -> Result<Scene> + Sync) -> Result<()> {
        let Some(ranks) = self.ranks else { return self.make(scene_at, None) };
        let done = if ranks.is_first() {
            let mut team = ranks.team(self.length.0);
            let made = self.make(scene_at, Some(&mut team));
            team.end().and(made)
        } else {
            ranks.draw_frames(|frame_idx| {
                let scene = scene_at(frame_idx)?;
                self.painter.draw(&scene)
            })
        };
        ranks.all_can(done)
    }

    fn make(
        mut self,
        scene_at: impl Fn(u32) -> Result<Scene> + Sync,
        mut team: Option<&mut Team<'_>>,
    ) -> Result<()> {
        let desc = self.flags.desc(self.format, &self.painter.opened().scene, self.length)?;
        let file = self.painter.file()?;
        let identity = self.identity(&file)?;
        let film = self.flags.begin(self.path, self.format, desc, &identity)?;
        let film = match self.format {
            FilmFormat::WebP | FilmFormat::Apng => {
                film.metadata(self.flags.metadata(&file, self.path))
            }
            _ => film,
        };
        let mut counter = Counter::start(film.n_done(), desc.n_frames);
        output::say_when_interrupted(Some(format!(
            "interrupted: the same command continues {} with the frames that are there",
            self.path.display()
        )));
        let mut notes: Vec<String> = Vec::new();
        let (mut why_blank, mut is_seen) = (None, false);
        let render = |frame_idx| {
            let scene = scene_at(frame_idx)?;
            let mut draw = |_| self.painter.draw(&scene);
            let drawn = match &mut team {
                Some(team) => team.frame(frame_idx, &mut draw)?,
                None => draw(frame_idx)?,
            };
            // What is said of a frame is said once.
            for note in drawn.notes {
                if !notes.contains(&note) {
                    terminal::warn(&note);
                    notes.push(note);
                }
            }
            match drawn.why_blank {
                Some(why) => why_blank = Some(why),
                None => is_seen = true,
            }
            let frame = FilmFrame::from(drawn.image);
            if self.format != FilmFormat::PngSequence {
                return Ok::<_, Error>(frame);
            }
            // Each is a picture of its own.
            let path = self.path.join("frame.png");
            Ok(frame.metadata(self.flags.metadata(&file.at_moment(&scene)?, &path)))
        };
        let made = film.make(render, |step| counter.step(step));
        output::say_when_interrupted(None);
        drop(counter);
        let report = self.scene_flags.in_scene(|| made.map_err(with_way_on))?;
        if let Some(why) = why_blank.filter(|_| !is_seen && report.n_continued == 0) {
            terminal::warn(&format!("nothing is visible in any frame: {why}"));
        }
        if let Some(path) = self.flags.scene_path() {
            output::write_scene(path, &file)?;
        }
        self.tell(&desc, &report)
    }

    /// All that decides about its pixels.
    fn identity(&self, file: &SceneFile) -> Result<String> {
        let scene = io::scene_text(file, self.path)?;
        let (device, program) = (self.painter.device(), Provenance::PROGRAM);
        let says_scene = self.flags.says_scene();
        // It comes first, as it decides where the camera is found.
        let turn = file.film.as_ref().and_then(|film| film.turn);
        Ok(format!(
            "Frames of a film that is being made; the command that began it continues it.\n\
             program = {program}\ndevice = {device}\nmetadata = {says_scene}\nturn = {turn:?}\n{scene}"
        ))
    }

    /// Films a thing that turns.
    pub(crate) fn run_turn(self, turn: Turn) -> Result<()> {
        let base = self.painter.opened().scene.clone();
        self.run(|frame_idx| Ok::<Scene, _>(turn.scene_at(&base, frame_idx)?))
    }

    fn tell(&self, desc: &FilmDesc, report: &FilmReport) -> Result<()> {
        for found in &self.painter.opened().found {
            terminal::detail(format_args!("shown as {found}"));
        }
        let [width, height] = self.format.size(desc);
        let continued = match report.n_continued {
            0 => String::new(),
            n => format!(", {n} of them from before"),
        };
        terminal::say(format_args!(
            "{}: {width} x {height} pixels, {}{continued}, {:.2} s at {} a second, {}, in {} s",
            self.path.display(),
            counted(report.n_frames as usize, "frame"),
            report.seconds,
            desc.rate.per_second(),
            columns::bytes(report.n_bytes),
            self.started.elapsed().as_secs(),
        ));
        if let Some(path) = self.flags.scene_path() {
            terminal::say(format_args!("{}: its scene", path.display()));
        }
        let answer = json_of(self, desc, report);
        if self.flags.json { terminal::answer(&format!("{answer:#}\n")) } else { Ok(()) }
    }
}

/// What to do where the disk is full, or ffmpeg fails: nothing that was rendered is lost.
fn with_way_on(error: Error) -> Error {
    match error.downcast_ref() {
        Some(FilmError::Write { .. } | FilmError::Ffmpeg { .. }) => {
            anyhow!(
                "{error}; once that is mended, the same command continues with the frames that are there"
            )
        }
        _ => error,
    }
}

fn json_of(film: &Filming<'_>, desc: &FilmDesc, report: &FilmReport) -> Value {
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
        "backend": film.painter.backend(),
        "device": film.painter.device(),
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
            let all = counted(n_frames as usize, "frame");
            terminal::say(format_args!("continued: {n_before} of {all} done before"));
        }
        let bar = Progress::start("rendering", n_frames as usize);
        bar.begin_at(n_before.into());
        let now = Instant::now();
        Self { bar, n_before, n_frames, started: now, told: now }
    }

    fn step(&mut self, step: Step) {
        match step {
            Step::Damaged { what, .. } => {
                terminal::warn(&format!("{what}; it is drawn again"));
                self.n_before = self.n_before.saturating_sub(1);
                self.bar.step_back();
            }
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
    let all = counted(n_frames as usize, "frame");
    format!("{n_done} of {all}, {percent} %, {left} left")
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
