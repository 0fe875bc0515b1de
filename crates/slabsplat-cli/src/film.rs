//! `slabsplat film`: a film of a scene with key frames.

use crate::filming::Filming;
use crate::flags::{FilmFlags, SceneFlags};
use crate::progress::Progress;
use anyhow::{Context, Result};
use clap::Args;
use slabsplat::film::{Axis, Turn};
use slabsplat::io::SceneFile;
use slabsplat::{Camera, Scene};
use std::time::Instant;

/// Film a scene file that has key frames, in [film]
///
/// Flags change the scene, which is how all is at the beginning; key frames say what it becomes. While the
/// film is made its frames are in a folder FILE.frames: an interrupted run is continued by the same command.
#[derive(Args)]
pub(crate) struct FilmArgs {
    #[command(flatten)]
    film: FilmFlags,

    #[command(flatten)]
    scene: SceneFlags,
}

pub(crate) fn run(args: &FilmArgs) -> Result<()> {
    let started = Instant::now();
    let (path, format) = args.film.target()?;
    let progress = Progress::start("reading", 0);
    let (renderer, mut opened) = args.scene.opened_around(&progress, &views)?;
    drop(progress);
    let Some(file) = &mut opened.sources.film else {
        return args.scene.in_scene(|| Err(anyhow::anyhow!(NO_FILM)));
    };
    let rate = args.film.rate(file.frames_per_second)?;
    file.seconds = args.film.seconds(rate).or(file.seconds);
    let film = args.scene.in_scene(|| opened.film()?.context(NO_FILM))?;
    let n_frames = args.film.n_frames(rate, film.seconds())?;
    let filming = Filming {
        flags: &args.film,
        scene_flags: &args.scene,
        path,
        format,
        started,
        renderer,
        opened,
        length: (n_frames, rate),
        motion: String::new(),
    };
    let at = |frame_idx| film.seconds_of(frame_idx, n_frames);
    filming.run(|frame_idx| Ok::<Scene, _>(film.scene_at(at(frame_idx))?))
}

const NO_FILM: &str = "it has no [film] with key frames; slabsplat turntable films what has none";

/// Where a camera that is found may be, if keys turn it.
fn views(file: &SceneFile, camera: &Camera) -> Vec<Camera> {
    let keys = file.film.iter().flat_map(|film| &film.keys);
    let azimuths = keys.filter_map(|key| key.azimuth_degrees);
    let [least, largest] = azimuths.fold([0.0_f64; 2], |[min, max], it| [min.min(it), max.max(it)]);
    let turn = |degrees| Turn { axis: Axis::Up, degrees, is_rocking: false, n_frames: 1 };
    [least, largest].into_iter().flat_map(|degrees| turn(degrees).views(camera)).collect()
}
