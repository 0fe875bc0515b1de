//! `slabsplat popping`: by how much pictures change as the camera turns, or zooms.

use crate::flags::SceneFlags;
use crate::meter;
use crate::progress::Progress;
use crate::terminal;
use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use slabsplat::{Method, Motion, PoppingReport, Sweep};

/// Turn or zoom the camera in equal steps and measure by how much the picture changes in each
///
/// The pop ratio is the largest change over the median one: near 1 means that nothing pops. Jitter is the
/// mean second difference of frames over the mean first one: 0 if every pixel changes evenly, 2 if all
/// flicker. The spike is the largest of a change over the mean of those before and after it. The largest
/// step is that of a pixel's red, green or blue on black, of 255. All methods are measured, or the one that
/// --method names. The camera turns about its target around its up vector.
#[derive(Args)]
pub(crate) struct PoppingArgs {
    /// Zoom instead of turning: --from, --to and --step are factors, 0.25, 4 and 1.02 by default
    #[arg(long)]
    zooming: bool,

    /// First angle in degrees, from the scene's camera [default: 0]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    from: Option<f64>,

    /// Last angle in degrees [default: 90]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    to: Option<f64>,

    /// Degrees between two frames [default: 1]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    step: Option<f64>,

    /// Answer in JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    scene: SceneFlags,
}

pub(crate) fn run(args: &PoppingArgs) -> Result<()> {
    let sweep = args.sweep().checked()?;
    let progress = Progress::start("reading", 0);
    let (mut renderer, mut scene) = args.scene.renderer(&progress)?;
    drop(progress);
    let methods = args.scene.method().map_or(Method::ALL.to_vec(), |method| vec![method]);
    if !args.scene.says_gradients() && methods.contains(&Method::PostClassified) {
        // What was found by gradients cannot be drawn by all that are compared.
        scene.layers.iter_mut().for_each(|layer| layer.gradient_opacity = None);
    }
    let reports = args.scene.in_scene(|| meter::measure(&mut renderer, &scene, &methods, sweep))?;
    let text = if args.json {
        format!("{:#}\n", json_of(sweep, &reports))
    } else {
        meter::table(sweep.motion, &reports)
    };
    terminal::answer(&text)
}

impl PoppingArgs {
    fn sweep(&self) -> Sweep {
        let by_default = match self.zooming {
            true => Sweep::zoom(0.25, 4.0).step(1.02),
            false => Sweep::turn(0.0, 90.0),
        };
        let from = self.from.unwrap_or(by_default.from);
        let to = self.to.unwrap_or(by_default.to);
        let step = self.step.unwrap_or(by_default.step);
        let sweep = match by_default.motion {
            Motion::Zoom => Sweep::zoom(from, to),
            _ => Sweep::turn(from, to),
        };
        sweep.step(step)
    }
}

fn json_of(sweep: Sweep, reports: &[PoppingReport]) -> Value {
    let method = |report: &PoppingReport| {
        json!({
            "method": report.method.name(),
            "pop_ratio": report.pop_ratio,
            "spike": report.spike,
            "largest_change": report.largest,
            "median_change": report.median,
            "jitter": report.jitter,
            "largest_step": report.largest_step,
            "at": report.at.map(meter::rounded),
            "changes": report.changes,
        })
    };
    json!({
        "sweep": {
            "motion": meter::name(sweep.motion),
            "from": sweep.from,
            "to": sweep.to,
            "step": sweep.step,
        },
        "methods": reports.iter().map(method).collect::<Vec<_>>(),
    })
}
