//! `slabsplat film`: a film of a scene with key frames.

use crate::filming::Filming;
use crate::flags::{FilmFlags, SceneFlags};
use crate::progress::Progress;
use crate::ranks::{self, Ranks};
use crate::turntable::USUAL_SECONDS;
use anyhow::{Result, bail};
use clap::Args;
use slabsplat::film::{Film, Turn};
use slabsplat::io::{SceneFile, TurnFile};
use slabsplat::{Camera, Scene, TurnAxis};
use std::time::Instant;

/// Film a scene file that has key frames or a turn, in [film]
///
/// Flags change the scene, which is how all is at the beginning; key frames say what it becomes. A film in
/// .webp or .apng says what it shows, and can stand for the scene file. While the film is made its frames are
/// in a folder FILE.frames: an interrupted run is continued by the same command.
#[derive(Args)]
#[command(mut_arg("seconds", |arg| arg.help(SECONDS)))]
pub(crate) struct FilmArgs {
    #[command(flatten)]
    film: FilmFlags,

    #[command(flatten)]
    scene: SceneFlags,
}

/// Unlike a turntable, key frames say how long they last.
const SECONDS: &str = "How long the film is, in seconds [default: as the scene file says; else until the last \
                       key; of a turn 6]";

pub(crate) fn run(args: &FilmArgs) -> Result<()> {
    let others = args.film.ranks.start()?;
    let done = film(args, others.as_ref());
    ranks::ended(others, done)
}

fn film(args: &FilmArgs, others: Option<&Ranks>) -> Result<()> {
    let started = Instant::now();
    let (path, format) = ranks::all_can(others, args.film.target(args.scene.input()))?;
    let check = |file: &SceneFile| {
        let of_file = file.film.as_ref().and_then(|film| film.frames_per_second);
        args.film.check(format, file, args.film.rate(of_file)?)
    };
    let progress = Progress::start("reading", 0);
    let painter = args.film.painter(&args.scene, (&progress, &check), &views);
    let mut painter = ranks::all_can(others, painter)?;
    drop(progress);
    let Some(file) = &mut painter.opened_mut().sources.film else { return no_film(args) };
    let rate = args.film.rate(file.frames_per_second)?;
    file.frames_per_second = Some(rate.per_second());
    file.seconds = args.film.seconds(rate).or(file.seconds);
    let seconds_of_turn = file.seconds.unwrap_or(USUAL_SECONDS);
    let film = args.scene.in_scene(|| painter.film())?;
    let seconds = film.as_ref().map_or(seconds_of_turn, Film::seconds);
    let n_frames = args.film.n_frames(rate, seconds)?;
    let turn = painter.opened().turn(n_frames);
    let filming = Filming {
        flags: &args.film,
        scene_flags: &args.scene,
        path,
        format,
        started,
        painter,
        length: (n_frames, rate),
        ranks: others,
    };
    match (turn, film) {
        (Some(turn), _) => filming.run_turn(turn),
        (None, Some(film)) => {
            let at = |frame_idx| film.seconds_of(frame_idx, n_frames);
            filming.run(|frame_idx| Ok::<Scene, _>(film.scene_at(at(frame_idx))?))
        }
        (None, None) => no_film(args),
    }
}

fn no_film(args: &FilmArgs) -> Result<()> {
    let what = "it has no [film] with key frames; slabsplat turntable films what has none";
    args.scene.in_scene(|| bail!(what))
}

/// Where a camera that is found may be, if keys turn it.
fn views(file: &SceneFile, camera: &Camera) -> Vec<Camera> {
    if let Some(turn) = file.film.as_ref().and_then(|film| film.turn) {
        let TurnFile { axis, degrees, is_rocking, .. } = turn;
        let turn = Turn::new(axis, degrees, 1);
        return if is_rocking { turn.rocking() } else { turn }.views(camera);
    }
    let keys = file.film.iter().flat_map(|film| &film.keys);
    let azimuths = keys.filter_map(|key| key.azimuth_degrees);
    let [least, largest] = azimuths.fold([0.0_f64; 2], |[min, max], it| [min.min(it), max.max(it)]);
    let turn = |degrees| Turn::new(TurnAxis::Up, degrees, 1);
    [least, largest].into_iter().flat_map(|degrees| turn(degrees).views(camera)).collect()
}
