//! `slabsplat render`: one picture.

#[cfg(feature = "mpi")]
use crate::distributed::{self, Distributed};
use crate::flags::{OutputFlags, SceneFlags, Written, values};
use crate::plain::counted;
use crate::progress::Progress;
use crate::ranks::{RankFlags, Ranks};
use crate::terminal::{self, Loudness};
use crate::{advice, divided, stats};
use anyhow::Result;
use clap::{ArgGroup, Args};
use serde_json::{Value, json};
use slabsplat::io::SceneFile;
use slabsplat::{Caps, Frame, Layer, Mode, OpenScene, Scene};
use std::path::PathBuf;
use std::time::Instant;

/// Render a scene or a volume into a picture
#[derive(Args)]
#[command(group(ArgGroup::new("in_boxes").args(["memory", "distributed"]).multiple(true)))]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    output: OutputFlags,

    /// Tell on stderr what the frame cost: each stage, what was splatted, memory
    #[arg(long)]
    stats: bool,

    /// Answer in JSON: what was written, time, warnings, statistics
    #[arg(long)]
    json: bool,

    /// Draw within so much memory, however large the volumes are, box by box on the CPU: as 800MiB or 2GiB
    #[arg(
        long, value_name = "SIZE", value_parser = values::bytes, help_heading = "Output",
        conflicts_with = "stats"
    )]
    memory: Option<u64>,

    /// Where --memory and --distributed unpack volumes that cannot be read box by box; by default in the
    /// system's folder for temporary files
    #[arg(long, value_name = "FOLDER", help_heading = "Output", requires = "in_boxes")]
    scratch: Option<PathBuf>,

    #[command(flatten)]
    ranks: RankFlags,

    #[command(flatten)]
    scene: SceneFlags,
}

pub(crate) fn run(args: &RenderArgs) -> Result<()> {
    if let Some(ranks) = args.ranks.start()? {
        return on_ranks(args, ranks);
    }
    let written = args.output.written(args.scene.input(), args.json)?;
    let done = match args.memory {
        Some(memory_bytes) => {
            let desc = divided::desc(memory_bytes, args.scratch.as_deref());
            divided::draw(&args.scene, &written, &desc)?
        }
        None => draw(&args.scene, &written, args.stats)?,
    };
    if args.json { terminal::answer(&format!("{done:#}\n")) } else { Ok(()) }
}

/// Draws a picture together with all other ranks.
#[cfg(feature = "mpi")]
fn on_ranks(args: &RenderArgs, ranks: Ranks) -> Result<()> {
    let distributed = Distributed {
        scene: &args.scene,
        output: &args.output,
        memory_bytes: args.memory,
        scratch: args.scratch.as_deref(),
        has_stats: args.stats,
        has_json: args.json,
    };
    let done = distributed::draw(&distributed, &ranks);
    match ranks.ended(done)? {
        Some(done) if args.json => terminal::answer(&format!("{done:#}\n")),
        _ => Ok(()),
    }
}

/// There are no others.
#[cfg(not(feature = "mpi"))]
fn on_ranks(_: &RenderArgs, ranks: Ranks) -> Result<()> {
    match ranks {}
}

/// Draws a scene, writes what is to be written of it, and tells what was done: in lines on stderr, and in
/// JSON, which is returned.
pub(crate) fn draw(scene: &SceneFlags, written: &Written<'_>, with_stats: bool) -> Result<Value> {
    let started = Instant::now();
    let progress = Progress::start("reading", 0);
    let check = |file: &SceneFile| Ok(written.target.format.check(file)?);
    let (mut renderer, mut opened) = scene.opened(&progress, &check)?;
    let watched = progress.frame("rendering");
    let picture = scene
        .in_scene(|| advice::picture(&mut renderer, &opened.scene, opened.acquisition, &watched))?;
    progress.stage("writing");
    // What drew it, and not what might have: another backend has other bits.
    renderer.caps().name.clone_into(&mut opened.backend);
    let file = written.has_scene().then(|| opened.to_file()).transpose()?;
    written.write(&picture.frame.image, file.as_ref())?;
    drop(progress);
    terminal::warn_all(&picture.notes);
    if picture.is_blank {
        let why = nothing_visible(&opened.scene, &picture.frame);
        terminal::warn(&format!("nothing is visible: {why}"));
    }
    let done = Done { written, file, started, frame: picture.frame, caps: renderer.caps() };
    done.tell(&opened, with_stats);
    Ok(done.json())
}

/// What was done.
struct Done<'a> {
    written: &'a Written<'a>,
    /// If it was written anywhere.
    file: Option<SceneFile>,
    started: Instant,
    frame: Frame,
    caps: &'a Caps,
}

impl Done<'_> {
    fn tell(&self, opened: &OpenScene, with_stats: bool) {
        for layer in &opened.scene.layers {
            let (grid, range) = (layer.volume.grid(), layer.volume.summary().range);
            let values = range.map_or("no finite values".to_owned(), |[min, max]| {
                format!("values from {min} to {max}")
            });
            terminal::detail(format_args!("volume of {:?} voxels, {values}", grid.dims()));
        }
        terminal::say_found(&opened.found);
        terminal::say(format_args!(
            "{}: {} x {} pixels, {} drawn, {} ms{}",
            self.written.target.name(),
            self.frame.image.width(),
            self.frame.image.height(),
            counted(self.frame.stats.n_voxels as usize, "voxel"),
            self.started.elapsed().as_millis(),
            by_which(self.caps),
        ));
        if let Some(path) = self.written.scene {
            terminal::say(format_args!("{}: its scene", path.display()));
        }
        if with_stats || terminal::is_at_least(Loudness::Verbose) {
            terminal::report(format_args!("{}", stats::text(&self.frame, self.caps)));
        }
    }

    fn json(&self) -> Value {
        let Frame { image, stats, cost, .. } = &self.frame;
        let stages = cost.stages.iter().map(|stage| json!({ "name": stage.name, "ms": stage.ms }));
        json!({
            "picture": self.written.target.name(),
            "format": self.written.target.format.name(),
            "width": image.width(),
            "height": image.height(),
            "scene_file": self.written.scene.map(|path| path.display().to_string()),
            "volumes": self.file.as_ref().map(volumes),
            "seconds": self.started.elapsed().as_secs_f64(),
            "backend": self.caps.name,
            "device": self.caps.device,
            "threads": (self.caps.name == "cpu").then(rayon::current_num_threads),
            "warnings": terminal::take_warnings(),
            "stages": stages.collect::<Vec<_>>(),
            "n_voxels": stats.n_voxels,
            "n_splats": stats.n_splats,
            "n_occluded": stats.n_occluded,
            "n_culled": stats.n_culled,
            "n_tiles": stats.n_tiles,
            "n_saturated_tiles": stats.n_saturated_tiles,
            "resident_bytes": cost.resident_bytes,
        })
    }
}

/// What tells which volumes were drawn.
fn volumes(scene: &SceneFile) -> Vec<Value> {
    let volume = |layer: &slabsplat::io::LayerFile| json!({ "name": layer.volume.to_string(), "hash": layer.hash.map(|hash| hash.to_string()) });
    scene.layers.iter().map(volume).collect()
}

/// The CPU goes without saying.
fn by_which(caps: &Caps) -> String {
    match caps.name {
        "cpu" => String::new(),
        _ => format!(", {}", stats::executor(caps)),
    }
}

/// Why a picture is empty, which is seldom what was meant.
pub(crate) fn nothing_visible(scene: &Scene, frame: &Frame) -> String {
    let ranges = scene.layers.iter().filter_map(|layer| layer.volume.summary().range);
    let range = ranges.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
    let is_cut = scene.layers.iter().any(|layer| !layer.region.is_everywhere());
    match range {
        None if !scene.meshes.is_empty() && scene.layers.is_empty() => {
            "the camera looks past it, or all of it is cut off".to_owned()
        }
        None => "no voxel has a finite value".to_owned(),
        Some([min, max])
            if scene.settings.mode == Mode::Isosurfaces && frame.stats.n_voxels == 0 =>
        {
            format!("no isosurface lies within all values, {min} to {max}")
        }
        Some(_) if frame.stats.n_voxels == 0 => {
            let mut whys: Vec<String> = scene.layers.iter().map(why_unlisted).collect();
            whys.dedup();
            whys.join("; ")
        }
        Some(_) if is_cut => "all of it is cut off, or the camera looks past it".to_owned(),
        Some(_) => "the camera looks past it".to_owned(),
    }
}

/// Why no voxel of a layer is visible, wherever the camera is.
fn why_unlisted(layer: &Layer) -> String {
    let Some([min, max]) = layer.volume.summary().range else {
        return "no voxel has a finite value".to_owned();
    };
    let has_opacity =
        layer.transfer.iso_ranges().iter().any(|range| range.lo <= max && min <= range.hi);
    let why = if layer.labels.as_ref().is_some_and(|labels| !labels.any_visible()) {
        "all labels that voxels have are invisible"
    } else if layer.transfer_2d.is_some() {
        "no voxel has a value and a gradient that have an opacity"
    } else if !has_opacity {
        return format!("the opacity of all values, {min} to {max}, is 0");
    } else if layer.labels.is_some() {
        "no voxel of a visible label has a value that has an opacity"
    } else {
        "no voxel has an opacity"
    };
    why.to_owned()
}
