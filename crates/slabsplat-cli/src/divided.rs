//! `slabsplat render --memory`: a picture of volumes that need not fit the memory.

use crate::columns::bytes;
use crate::flags::{SceneFlags, Written};
use crate::painter::NOTHING_IN_PARTS;
use crate::plain::counted;
use crate::progress::Progress;
use crate::terminal;
use anyhow::Result;
use serde_json::{Value, json};
use slabsplat::io::{SceneFile, ScratchDesc, VolumeBoxes};
use slabsplat::{DividedDesc, DividedScene};
use std::path::Path;
use std::time::Instant;

/// What a picture may take.
pub(crate) fn desc(memory_bytes: u64, scratch: Option<&Path>) -> DividedDesc {
    DividedDesc::new(memory_bytes).scratch(scratch_in(scratch))
}

/// Scratch in a folder; volumes that are unpacked are told of before.
pub(crate) fn scratch_in(folder: Option<&Path>) -> ScratchDesc {
    let told = ScratchDesc::default().on_use(|of| {
        let [file, folder] = [&of.path, &of.folder].map(|path| path.display().to_string());
        let [file, folder] = [file, folder].map(|path| terminal::flattened(&path));
        let size = bytes(of.n_bytes);
        terminal::say(format_args!(
            "{file} is unpacked into {folder} first: {size} there, until the program ends"
        ));
        if of.is_in_memory {
            terminal::warn(&format!("{folder} lies in memory: --scratch names another folder"));
        }
    });
    match folder {
        Some(folder) => told.folder(folder),
        None => told,
    }
}

/// Draws a scene within so many bytes, writes what is to be written of it, and tells what was done: in lines
/// on stderr, and in JSON, which is returned.
pub(crate) fn draw(scene: &SceneFlags, written: &Written<'_>, desc: &DividedDesc) -> Result<Value> {
    let started = Instant::now();
    let progress = Progress::start("reading", 0);
    let check = |file: &SceneFile| check(file, written);
    let divided = scene.divided(&check, desc)?;
    let watched = progress.frame("rendering");
    let picture = scene.in_scene(|| Ok(divided.picture(&watched)?))?;
    progress.stage("writing");
    let file = written.has_scene().then(|| divided.to_file()).transpose()?;
    let image = &picture.frame.image;
    written.write(image, file.as_ref())?;
    drop(progress);
    terminal::warn_all(&picture.notes);
    if picture.is_blank {
        terminal::warn(&format!("nothing is visible: {NOTHING_IN_PARTS}"));
    }
    terminal::say_found(&divided.opened().found);
    terminal::say(format_args!(
        "{}: {} x {} pixels, {}, {} ms",
        written.target.name(),
        image.width(),
        image.height(),
        counted(divided.n_boxes(), "part"),
        started.elapsed().as_millis(),
    ));
    Ok(json!({
        "picture": written.target.name(),
        "format": written.target.format.name(),
        "width": image.width(),
        "height": image.height(),
        "scene_file": written.scene.map(|path| path.display().to_string()),
        "seconds": started.elapsed().as_secs_f64(),
        "backend": divided.backend(),
        "threads": divided.n_threads(),
        "warnings": terminal::take_warnings(),
        "n_boxes": divided.n_boxes(),
        "peak_bytes": peak_bytes(),
        "volumes": volumes(&divided),
    }))
}

/// The most memory that the program has had so far, where the system tells.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let (_, peak) = status.split_once("VmHWM:")?;
    let kib: u64 = peak.split_whitespace().next()?.parse().ok()?;
    Some(kib << 10)
}

/// Whole, on their grids.
fn volumes(divided: &DividedScene) -> Vec<Value> {
    let of = |source: &VolumeBoxes| {
        let scratch = source.scratch().map(|scratch| scratch.n_bytes);
        let chunks = source.is_in_chunks().then(|| source.chunk_counts());
        json!({
            "dims": source.grid().dims(),
            "scratch_bytes": scratch,
            "n_chunks_unpacked": chunks.map(|[unpacked, _]| unpacked),
            "n_chunks_retained": chunks.map(|[_, retained]| retained),
        })
    };
    divided.sources().iter().map(of).collect()
}

/// What is known before anything is read.
fn check(file: &SceneFile, written: &Written<'_>) -> Result<()> {
    Ok(written.target.format.check(file)?)
}
