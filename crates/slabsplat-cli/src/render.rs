//! `slabsplat render`: one picture.

use crate::flags::SceneFlags;
use crate::progress::Progress;
use crate::{output, stats, terminal};
use anyhow::{Context, Result, bail};
use clap::Args;
use slabsplat::{Caps, Frame, Mode, OpenScene, Scene};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Render a scene or a volume into a picture
#[derive(Args)]
pub(crate) struct RenderArgs {
    /// The picture: .exr (32-bit float, premultiplied) or .png (8 bits)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Tell on stderr what the frame cost: each stage, what was splatted, memory
    #[arg(long)]
    stats: bool,

    #[command(flatten)]
    scene: SceneFlags,
}

pub(crate) fn run(args: &RenderArgs) -> Result<()> {
    check_output(&args.output)?;
    let started = Instant::now();
    let progress = Progress::start("reading", 0);
    let (mut renderer, OpenScene { scene, found, .. }) =
        args.scene.open_with_renderer(&progress)?;
    progress.stage("rendering");
    let frame = args.scene.in_scene(|| Ok(renderer.render(&scene)?))?;
    progress.stage("writing");
    output::write_picture(&args.output, &frame.image)?;
    drop(progress);
    if let Some(why) = nothing_visible(&scene, &frame) {
        terminal::warn(&format!("nothing is visible: {why}"));
    }
    if !found.is_empty() {
        terminal::say(format_args!("shown as {}", found.join("; and ")));
    }
    terminal::say(format_args!(
        "{}: {} x {} pixels, {} voxels drawn, {} ms{}",
        args.output.display(),
        frame.image.width(),
        frame.image.height(),
        frame.stats.n_voxels,
        started.elapsed().as_millis(),
        by_which(renderer.caps()),
    ));
    if args.stats {
        terminal::say(format_args!("{}", stats::text(&frame, renderer.caps())));
    }
    Ok(())
}

/// The CPU goes without saying.
fn by_which(caps: &Caps) -> String {
    match caps.name {
        "cpu" => String::new(),
        _ => format!(", {}", stats::executor(caps)),
    }
}

/// An empty picture is seldom what was meant.
fn nothing_visible(scene: &Scene, frame: &Frame) -> Option<String> {
    let background = scene.image.premultiplied_background();
    if frame.image.pixels().iter().any(|pixel| *pixel != background) {
        return None;
    }
    let ranges = scene.layers.iter().filter_map(|layer| layer.volume.summary().range);
    let range = ranges.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
    let is_cut = scene.layers.iter().any(|layer| !layer.region.is_everywhere());
    Some(match range {
        None if !scene.meshes.is_empty() && scene.layers.is_empty() => {
            "the camera looks past it, or all of it is cut off".to_owned()
        }
        None => "no voxel has a finite value".to_owned(),
        Some([min, max])
            if scene.settings.mode == Mode::Isosurfaces && frame.stats.n_voxels == 0 =>
        {
            format!("no isosurface lies within all values, {min} to {max}")
        }
        Some([min, max]) if frame.stats.n_voxels == 0 => {
            format!("the opacity of all values, {min} to {max}, is 0")
        }
        Some(_) if is_cut => "all of it is cut off, or the camera looks past it".to_owned(),
        Some(_) => "the camera looks past it".to_owned(),
    })
}

/// What would fail after the work must fail before it.
fn check_output(path: &Path) -> Result<()> {
    let is_known =
        |extension: &OsStr| ["exr", "png"].iter().any(|e| extension.eq_ignore_ascii_case(e));
    if !path.extension().is_some_and(is_known) {
        bail!("cannot tell the format of {}: name the picture .exr or .png", path.display());
    }
    if path.is_dir() {
        bail!("cannot write {}: it is a directory", path.display());
    }
    let directory = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let metadata = std::fs::metadata(directory)
        .with_context(|| format!("cannot write to the directory {}", directory.display()))?;
    if !metadata.is_dir() {
        bail!("cannot write {}: {} is not a directory", path.display(), directory.display());
    }
    Ok(())
}
