//! `slabsplat demo`: the main job on built-in data. Pictures of every built-in volume by all four methods,
//! and the popping table of the paper's cube.

mod shots;

use crate::progress::Progress;
use crate::{meter, output, stats, terminal};
use anyhow::{Context, Result};
use clap::Args;
use shots::{CUBE_TURN, SHOTS, Shot};
use slabsplat::io::{self, PictureFormat, Provenance, SceneFile, VolumeSource};
use slabsplat::{Frame, Method, Renderer};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Render built-in volumes with all four methods, and measure how the methods pop
#[derive(Args)]
pub(crate) struct DemoArgs {
    /// Where the pictures go; it is made if there is none
    #[arg(value_name = "FOLDER", default_value = "slabsplat-demo")]
    folder: PathBuf,
}

pub(crate) fn run(args: &DemoArgs) -> Result<()> {
    let folder = &args.folder;
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut renderer = Renderer::open("auto", terminal::warn)?;
    let side = shots::SIDE_PIXELS;
    terminal::answer(&format!(
        "Pictures of {side} x {side} pixels in {}, by {}:\n\n",
        folder.display(),
        stats::executor(renderer.caps()),
    ))?;
    terminal::answer("picture                             voxels drawn      ms\n")?;
    for shot in SHOTS {
        draw(shot, folder, &mut renderer)?;
    }
    measure(&mut renderer)
}

/// One volume by all methods. The voxels are sorted once.
fn draw(shot: &Shot, folder: &Path, renderer: &mut Renderer) -> Result<()> {
    let progress = Progress::start("rendering", 0);
    let volume = Arc::new(io::builtin_volume(shot.volume, None)?);
    let name = shot.volume.to_owned();
    let file = SceneFile::of_volume(VolumeSource::Builtin { name, size: None });
    let scenes = Method::ALL.iter().map(|&method| shot.scene(volume.clone(), method));
    let scenes = scenes.collect::<Result<Vec<_>>>()?;
    let mut lines = String::new();
    for scene in scenes {
        let started = Instant::now();
        let Frame { image, stats, .. } = renderer.render(&scene)?;
        let ms = started.elapsed().as_millis();
        let name = format!("{}-{}.png", shot.volume, scene.settings.method);
        let path = folder.join(&name);
        let mut source = file.completed(&scene)?;
        renderer.caps().name.clone_into(&mut source.backend);
        let provenance = Provenance::of_scene(&source, &path)?;
        output::write_picture(&path, PictureFormat::Png, &image, Some(&provenance))?;
        lines += &format!("{name:<34}  {:>12}  {ms:>6}\n", stats.n_voxels);
    }
    drop(progress);
    terminal::answer(&lines)
}

fn measure(renderer: &mut Renderer) -> Result<()> {
    let scene = shots::popping_scene(io::builtin_volume("cube", None)?)?;
    let reports = meter::measure(renderer, &scene, Method::ALL, CUBE_TURN)?;
    terminal::answer(&format!(
        "\nThe cube turns from {} to {} degrees in steps of {}. By how much does the picture change in a \
         step?\nThe pop ratio is the largest change over the median: near 1, nothing pops. Jitter is how unevenly \
         pixels change: near 0, nothing flickers.\n\n{}",
        CUBE_TURN.from,
        CUBE_TURN.to,
        CUBE_TURN.step,
        meter::table(CUBE_TURN.motion, &reports),
    ))
}
