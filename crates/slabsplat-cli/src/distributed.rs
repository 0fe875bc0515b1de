//! `slabsplat render --distributed`: a picture by all ranks that `mpirun` started.

use crate::columns::{aligned, bytes};
use crate::divided;
use crate::flags::{OutputFlags, SceneFlags, Written};
use crate::painter::NOTHING_IN_PARTS;
use crate::plain::counted;
use crate::progress::Progress;
use crate::ranks::Ranks;
use crate::terminal::{self, Loudness};
use anyhow::Result;
use serde_json::{Value, json};
use slabsplat::io::SceneFile;
use slabsplat::{Aim, SharedDesc};
use slabsplat_mpi::{DistributedPicture, DistributedScene, RankReport};
use std::path::Path;
use std::time::Instant;

/// What is drawn, and how it is said.
pub(crate) struct Distributed<'a> {
    pub(crate) scene: &'a SceneFlags,
    pub(crate) output: &'a OutputFlags,
    /// For each rank, if it is said.
    pub(crate) memory_bytes: Option<u64>,
    /// Where volumes are unpacked, if it is said.
    pub(crate) scratch: Option<&'a Path>,
    pub(crate) has_stats: bool,
    pub(crate) has_json: bool,
}

/// Draws a scene on all ranks; the first writes what is to be written of it, and says what was done: in lines
/// on stderr, and in JSON, which is returned.
pub(crate) fn draw(args: &Distributed<'_>, ranks: &Ranks) -> Result<Option<Value>> {
    let started = Instant::now();
    let input = args.scene.input();
    let written = ranks.is_first().then(|| args.output.written(input, args.has_json)).transpose();
    let written = ranks.all_can(written)?;
    let (file, aim) = ranks.all_can(prepared(args, written.as_ref()))?;
    let progress = Progress::start("reading", 0);
    let scene = open(args, ranks, (&file, aim))?;
    terminal::warn_all(&scene.shared().scene().opened().warnings);
    let watched = progress.frame("rendering");
    let drawn = args.scene.in_scene(|| Ok(scene.picture(&ranks.world, &watched)?))?;
    progress.stage("writing");
    let done = match (&drawn, &written) {
        (Some(drawn), Some(written)) => write(&scene, written, drawn),
        _ => Ok(()),
    };
    // No rank says that all is well before the picture is there.
    ranks.all_can(done)?;
    drop(progress);
    let Some((drawn, written)) = drawn.zip(written) else { return Ok(None) };
    tell(args, &scene, &written, &drawn, started);
    Ok(Some(answer(&scene, &written, &drawn, started)))
}

/// What is known before anything is read.
fn prepared(args: &Distributed<'_>, written: Option<&Written<'_>>) -> Result<(SceneFile, Aim)> {
    args.scene
        .in_parts(&|file| Ok(written.map_or(Ok(()), |written| written.target.format.check(file))?))
}

fn open(
    args: &Distributed<'_>,
    ranks: &Ranks,
    (file, aim): (&SceneFile, Aim),
) -> Result<DistributedScene> {
    let desc = SharedDesc::default().memory_bytes(args.memory_bytes).aim(aim);
    let desc = desc.scratch(divided::scratch_in(args.scratch));
    args.scene.in_scene(|| Ok(DistributedScene::open(&ranks.world, file, &desc)?))
}

fn write(
    scene: &DistributedScene,
    written: &Written<'_>,
    drawn: &DistributedPicture,
) -> Result<()> {
    let divided = scene.shared().scene();
    let file = written.has_scene().then(|| divided.to_file()).transpose()?;
    written.write(&drawn.picture.frame.image, file.as_ref())
}

fn tell(
    args: &Distributed<'_>,
    scene: &DistributedScene,
    written: &Written<'_>,
    drawn: &DistributedPicture,
    started: Instant,
) {
    terminal::warn_all(&drawn.picture.notes);
    if drawn.picture.is_blank {
        terminal::warn(&format!("nothing is visible: {NOTHING_IN_PARTS}"));
    }
    terminal::say_found(&scene.shared().scene().opened().found);
    terminal::say(format_args!(
        "{}: {} x {} pixels, {}, {} ms",
        written.target.name(),
        drawn.picture.frame.image.width(),
        drawn.picture.frame.image.height(),
        counted(drawn.ranks.len(), "rank"),
        started.elapsed().as_millis(),
    ));
    if args.has_stats || terminal::is_at_least(Loudness::Verbose) {
        terminal::report(format_args!("{}", table(&drawn.ranks).trim_end()));
    }
}

/// A row for each rank, and by how much the largest exceeds the mean.
fn table(ranks: &[RankReport]) -> String {
    let names =
        ["rank", "voxels", "splats", "boxes", "read", "sent", "peak", "draw", "wait", "composite"];
    let seconds = |secs: f64| format!("{secs:.3} s");
    let of_rank = |(rank, of): (usize, &RankReport)| {
        [
            rank.to_string(),
            of.n_voxels.to_string(),
            of.n_splats.to_string(),
            of.n_boxes.to_string(),
            bytes(of.n_bytes_read),
            bytes(of.n_bytes_sent),
            bytes(of.peak_bytes),
            seconds(of.drawing_secs),
            seconds(of.waiting_secs),
            seconds(of.compositing_secs),
        ]
    };
    let of = |number: fn(&RankReport) -> f64| format!("{:.2}", largest_over_mean(ranks, number));
    let largest = [
        "largest / mean".to_owned(),
        of(|of| of.n_voxels as f64),
        of(|of| of.n_splats as f64),
        of(|of| of.n_boxes as f64),
        of(|of| of.n_bytes_read as f64),
        of(|of| of.n_bytes_sent as f64),
        of(|of| of.peak_bytes as f64),
        of(|of| of.drawing_secs),
        of(|of| of.waiting_secs),
        of(|of| of.compositing_secs),
    ];
    let mut rows = vec![names.map(str::to_owned)];
    rows.extend(ranks.iter().enumerate().map(of_rank));
    rows.push(largest);
    aligned(&rows)
}

/// 1 where all are 0.
fn largest_over_mean(ranks: &[RankReport], number: fn(&RankReport) -> f64) -> f64 {
    let sum: f64 = ranks.iter().map(number).sum();
    let largest = ranks.iter().map(number).fold(0.0, f64::max);
    if sum == 0.0 { 1.0 } else { largest * ranks.len() as f64 / sum }
}

fn answer(
    scene: &DistributedScene,
    written: &Written<'_>,
    drawn: &DistributedPicture,
    started: Instant,
) -> Value {
    let image = &drawn.picture.frame.image;
    json!({
        "picture": written.target.name(),
        "format": written.target.format.name(),
        "width": image.width(),
        "height": image.height(),
        "scene_file": written.scene.map(|path| path.display().to_string()),
        "seconds": started.elapsed().as_secs_f64(),
        "backend": scene.shared().scene().backend(),
        "warnings": terminal::take_warnings(),
        "n_ranks": drawn.ranks.len(),
        "ranks": drawn.ranks.iter().map(of_rank).collect::<Vec<_>>(),
    })
}

fn of_rank(of: &RankReport) -> Value {
    json!({
        "node": of.node,
        "threads": of.n_threads,
        "n_voxels_in_box": of.n_voxels_in_box,
        "n_voxels": of.n_voxels,
        "n_splats": of.n_splats,
        "n_boxes": of.n_boxes,
        "n_voxels_read": of.n_voxels_read,
        "bytes_read": of.n_bytes_read,
        "messages_sent": of.n_messages_sent,
        "bytes_sent": of.n_bytes_sent,
        "n_pixels": of.n_pixels,
        "peak_bytes": of.peak_bytes,
        "memory_bytes": of.memory_bytes,
        "reading_seconds": of.reading_secs,
        "drawing_seconds": of.drawing_secs,
        "waiting_seconds": of.waiting_secs,
        "compositing_seconds": of.compositing_secs,
    })
}
