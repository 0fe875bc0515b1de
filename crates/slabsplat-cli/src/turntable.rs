//! `slabsplat turntable`: a film of a thing that turns.

use crate::filming::Filming;
use crate::flags::{FilmFlags, SceneFlags};
use crate::progress::Progress;
use crate::ranks::{self, Ranks};
use anyhow::{Result, bail};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use slabsplat::TurnAxis;
use slabsplat::film::Turn;
use slabsplat::io::{FilmFile, SceneFile, TurnFile};
use std::time::Instant;

/// Film a scene or a volume as it turns
///
/// Camera and lights go around what the camera looks at, as if the thing turned before them; where the camera
/// is found, all of it is in the picture at any angle. A whole turn is seamless. While the film is made its
/// frames are in a folder FILE.frames: an interrupted run is continued by the same command.
#[derive(Args)]
pub(crate) struct TurntableArgs {
    #[command(flatten)]
    film: FilmFlags,

    /// What it turns about: what is upwards, what is to the right in the picture, or an axis of the world
    #[arg(long, value_parser = axis_parser(), default_value = "up")]
    axis: TurnAxis,

    /// How far the camera goes to its own right; negative to its left [default: 360, with --rock 60]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    degrees: Option<f64>,

    /// Go to and fro about where the camera is, instead of around
    #[arg(long)]
    rock: bool,

    #[command(flatten)]
    scene: SceneFlags,
}

fn axis_parser() -> impl TypedValueParser<Value = TurnAxis> {
    PossibleValuesParser::new(TurnAxis::NAMES).try_map(|name| name.parse::<TurnAxis>())
}

/// How long it takes, where nobody says it.
pub(crate) const USUAL_SECONDS: f64 = 6.0;

pub(crate) fn run(args: &TurntableArgs) -> Result<()> {
    let others = args.film.ranks.start()?;
    let done = turn(args, others.as_ref());
    ranks::ended(others, done)
}

fn turn(args: &TurntableArgs, others: Option<&Ranks>) -> Result<()> {
    let started = Instant::now();
    let (path, format) = ranks::all_can(others, args.film.target(args.scene.input()))?;
    let rate = args.film.rate(None)?;
    let n_frames = args.film.n_frames(rate, USUAL_SECONDS)?;
    let turn = args.turn(n_frames)?;
    let check = |file: &SceneFile| args.film.check(format, file, rate);
    let progress = Progress::start("reading", 0);
    let painter =
        args.film.painter(&args.scene, (&progress, &check), &|_, camera| turn.views(camera));
    let mut painter = ranks::all_can(others, painter)?;
    drop(progress);
    let Turn { axis, degrees, is_rocking, .. } = turn;
    let mut film = FilmFile::default();
    film.frames_per_second = Some(rate.per_second());
    film.seconds = Some(f64::from(n_frames) / rate.per_second());
    film.turn = Some(TurnFile::new(axis, degrees, is_rocking));
    painter.opened_mut().sources.film = Some(film);
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
    filming.run_turn(turn)
}

impl TurntableArgs {
    fn turn(&self, n_frames: u32) -> Result<Turn> {
        let degrees = self.degrees.unwrap_or(if self.rock { 60.0 } else { 360.0 });
        let max = TurnFile::MAX_DEGREES;
        if !(-max..=max).contains(&degrees) {
            bail!("--degrees is up to {max} either way, and not {degrees}");
        }
        let turn = Turn::new(self.axis, degrees, n_frames);
        Ok(if self.rock { turn.rocking() } else { turn })
    }
}
