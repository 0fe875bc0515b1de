//! `slabsplat turntable`: a film of a thing that turns.

use crate::filming::Filming;
use crate::flags::{FilmFlags, SceneFlags};
use crate::progress::Progress;
use anyhow::{Result, bail};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use slabsplat::Scene;
use slabsplat::film::{Axis, Turn};
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
    axis: Axis,

    /// How far the camera goes to its own right; negative to its left [default: 360, with --rock 60]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    degrees: Option<f64>,

    /// Go to and fro about where the camera is, instead of around
    #[arg(long)]
    rock: bool,

    #[command(flatten)]
    scene: SceneFlags,
}

fn axis_parser() -> impl TypedValueParser<Value = Axis> {
    PossibleValuesParser::new(Axis::NAMES).try_map(|name| name.parse::<Axis>())
}

/// How long it takes, where nobody says it.
const USUAL_SECONDS: f64 = 6.0;

/// Most turns of a film.
const MAX_DEGREES: f64 = 360_000.0;

pub(crate) fn run(args: &TurntableArgs) -> Result<()> {
    let started = Instant::now();
    let (path, format) = args.film.target()?;
    let rate = args.film.rate(None)?;
    let n_frames = args.film.n_frames(rate, USUAL_SECONDS)?;
    let turn = args.turn(n_frames)?;
    let progress = Progress::start("reading", 0);
    let (renderer, opened) =
        args.scene.opened_around(&progress, &|_, camera| turn.views(camera))?;
    drop(progress);
    let Turn { axis, degrees, is_rocking, .. } = turn;
    let motion = format!("motion = {degrees} degrees about {axis:?}, rocking {is_rocking}\n");
    let base = opened.scene.clone();
    let filming = Filming {
        flags: &args.film,
        scene_flags: &args.scene,
        path,
        format,
        started,
        renderer,
        opened,
        length: (n_frames, rate),
        motion,
    };
    filming.run(|frame_idx| Ok::<Scene, _>(turn.scene_at(&base, frame_idx)?))
}

impl TurntableArgs {
    fn turn(&self, n_frames: u32) -> Result<Turn> {
        let degrees = self.degrees.unwrap_or(if self.rock { 60.0 } else { 360.0 });
        if !(-MAX_DEGREES..=MAX_DEGREES).contains(&degrees) {
            bail!("--degrees is up to {MAX_DEGREES} either way, and not {degrees}");
        }
        Ok(Turn { axis: self.axis, degrees, is_rocking: self.rock, n_frames })
    }
}
