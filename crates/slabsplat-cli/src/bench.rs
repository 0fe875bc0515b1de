//! `slabsplat bench`: how long a frame takes on this machine, while the camera turns.
//!
//! It is a user's own measure, and what a comparison with other programs is made of: the time of a frame is
//! all that [`Renderer::render`] takes, the plan included. Benchmarks of parts of it are cargo's.

use crate::flags::SceneFlags;
use crate::progress::Progress;
use crate::{advice, columns, stats, terminal};
use anyhow::{Result, ensure};
use clap::Args;
use serde_json::{Value, json};
use slabsplat::{Caps, Frame, Renderer, Scene};
use std::time::Instant;

/// Time frames while the camera turns
///
/// The camera turns by one degree a frame about its target, around its up vector, so that every frame does
/// all that a new camera asks for. Two frames come first and do not count, one degree before the scene's
/// camera and at it: they read, sort and make tables, as the first frame of a program does. Counts and memory
/// are those of the last frame.
#[derive(Args)]
pub(crate) struct BenchArgs {
    /// Frames that are timed, the first of them one degree from the scene's camera
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u16).range(1..))]
    frames: u16,

    /// Answer in JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    scene: SceneFlags,
}

/// Frames before those that are timed.
const N_WARM_UPS: u16 = 2;

pub(crate) fn run(args: &BenchArgs) -> Result<()> {
    let progress = Progress::start("reading", 0);
    let (mut renderer, scene) = args.scene.renderer(&progress)?;
    drop(progress);
    let frames = args.scene.in_scene(|| time_frames(&mut renderer, &scene, args.frames))?;
    let name = args.scene.input().display().to_string();
    let report = Report::of(name, renderer.caps(), frames);
    let text = if args.json { format!("{:#}\n", report.json()) } else { report.text() };
    terminal::answer(&text)
}

/// Frames with the milliseconds that they took.
struct TimedFrames {
    ms: Vec<f64>,
    /// Of each stage, by name, in the order of the frame.
    stages_ms: Vec<(&'static str, Vec<f64>)>,
    last: Frame,
}

/// Times `n_frames` at one degree, two degrees and so on from the scene's camera.
fn time_frames(renderer: &mut Renderer, scene: &Scene, n_frames: u16) -> Result<TimedFrames> {
    let progress = Progress::start("measuring", usize::from(N_WARM_UPS) + usize::from(n_frames));
    let caps = renderer.caps().clone();
    let mut time_at = |degrees: f64| -> Result<(Frame, f64)> {
        let turned = scene.clone().camera(scene.camera.orbited(degrees.to_radians()));
        let started = Instant::now();
        let frame = advice::render(renderer, &turned)?;
        let ms = started.elapsed().as_secs_f64() * 1e3;
        progress.step();
        Ok((frame, ms))
    };
    for warm_up in 0..N_WARM_UPS {
        time_at(f64::from(warm_up) - f64::from(N_WARM_UPS - 1))?;
    }
    let (first, ms) = time_at(1.0)?;
    let mut frames = TimedFrames::new(first, ms);
    for degrees in 2..=n_frames {
        let (frame, ms) = time_at(f64::from(degrees))?;
        frames.push(frame, ms);
    }
    // Frames of two backends have no median.
    ensure!(*renderer.caps() == caps, "{} failed while it was measured", stats::executor(&caps));
    Ok(frames)
}

impl TimedFrames {
    fn new(first: Frame, ms: f64) -> Self {
        let stages_ms = first.cost.stages.iter().map(|stage| (stage.name, vec![stage.ms]));
        Self { ms: vec![ms], stages_ms: stages_ms.collect(), last: first }
    }

    fn push(&mut self, frame: Frame, ms: f64) {
        self.ms.push(ms);
        for stage in &frame.cost.stages {
            match self.stages_ms.iter_mut().find(|(name, _)| *name == stage.name) {
                Some((_, ms)) => ms.push(stage.ms),
                None => self.stages_ms.push((stage.name, vec![stage.ms])),
            }
        }
        self.last = frame;
    }
}

/// What the command answers.
struct Report {
    scene: String,
    caps: Caps,
    /// Threads that the CPU backend renders on.
    threads: Option<usize>,
    median_ms: f64,
    min_ms: f64,
    frames: TimedFrames,
}

impl Report {
    fn of(scene: String, caps: &Caps, frames: TimedFrames) -> Self {
        Self {
            scene,
            caps: caps.clone(),
            threads: (caps.name == "cpu").then(rayon::current_num_threads),
            median_ms: median(&frames.ms),
            min_ms: frames.ms.iter().copied().fold(f64::INFINITY, f64::min),
            frames,
        }
    }

    fn json(&self) -> Value {
        let Frame { image, stats, cost, .. } = &self.frames.last;
        json!({
            "backend": self.caps.name,
            "device": self.caps.device,
            "threads": self.threads,
            "scene": self.scene,
            "width": image.width(),
            "height": image.height(),
            "median_ms": self.median_ms,
            "min_ms": self.min_ms,
            "frames_ms": self.frames.ms,
            "stages": self.stages()
                .map(|(name, ms)| json!({ "name": name, "median_ms": ms }))
                .collect::<Vec<_>>(),
            "n_voxels": stats.n_voxels,
            "n_splats": stats.n_splats,
            "n_occluded": stats.n_occluded,
            "n_culled": stats.n_culled,
            "resident_bytes": cost.resident_bytes,
        })
    }

    fn text(&self) -> String {
        let Frame { image, stats, cost, .. } = &self.frames.last;
        let picture = format!("{}, {} x {} pixels", self.scene, image.width(), image.height());
        let mut rows = vec![
            ("scene", picture),
            ("backend", stats::executor(&self.caps)),
            ("frames", format!("{:>10}", self.frames.ms.len())),
            ("median", stats::milliseconds(self.median_ms)),
            ("fastest", stats::milliseconds(self.min_ms)),
        ];
        rows.extend(stats::stage_rows(self.stages()));
        rows.extend(stats::splat_rows(stats));
        rows.push(("resident", stats::resident(cost)));
        columns::pairs(rows)
    }

    /// The median of each stage.
    fn stages(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.frames.stages_ms.iter().map(|(name, ms)| (*name, median(ms)))
    }
}

/// The middle number, or the mean of the two in the middle.
pub(crate) fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 {
        sorted[middle]
    } else {
        f64::midpoint(sorted[middle - 1], sorted[middle])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::{FrameCost, FrameStats, Image, Method, StageTime};

    fn frame(stages: &[(&'static str, f64)]) -> Frame {
        let stages = stages.iter().map(|&(name, ms)| StageTime::new(name, ms)).collect();
        let mut stats = FrameStats::default();
        (stats.n_voxels, stats.n_splats, stats.n_culled) = (1, 22, 333);
        Frame::new(Image::filled(3, 2, [0.0; 4]), stats, FrameCost::new(stages, 1023))
    }

    fn report() -> Report {
        let mut frames = TimedFrames::new(frame(&[("project", 1.0), ("splat", 9.0)]), 30.0);
        frames.push(frame(&[("project", 2.0), ("splat", 7.0)]), 10.0);
        frames.push(frame(&[("project", 4.0), ("splat", 8.0)]), 20.25);
        let caps = Caps::new("ash", "Fake 3000", Method::ALL);
        Report::of("a.toml".to_owned(), &caps, frames)
    }

    #[test]
    fn bench_text() {
        let expected = "\
scene     a.toml, 3 x 2 pixels
backend   ash on Fake 3000
frames             3
median        20.250 ms
fastest       10.000 ms
project        2.000 ms
splat          8.000 ms
voxels             1
occluded           0
splatted          22
culled           333
resident  1023 bytes
";
        assert_eq!(report().text(), expected);
    }

    #[test]
    fn bench_json() {
        let answer = report().json();
        assert_eq!(answer["threads"], Value::Null, "only the CPU has threads");
        assert_eq!(answer["frames_ms"], json!([30.0, 10.0, 20.25]));
        assert_eq!(answer["stages"][1], json!({ "name": "splat", "median_ms": 8.0 }));
    }

    #[test]
    fn median_of_a_few() {
        for (numbers, expected) in [(&[3.0][..], 3.0), (&[4.0, 1.0], 2.5), (&[9.0, 1.0, 2.0], 2.0)]
        {
            assert_eq!(median(numbers), expected, "{numbers:?}");
        }
    }
}
