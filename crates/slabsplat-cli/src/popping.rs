//! `slabsplat popping`: by how much pictures change as the camera turns.

use crate::flags::SceneFlags;
use crate::meter;
use crate::progress::Progress;
use crate::terminal;
use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use slabsplat::{Method, PoppingReport, Sweep};

/// Turn the camera in equal steps and measure by how much the picture changes in each
///
/// The pop ratio is the largest change over the median one: near 1 means that nothing pops. Jitter is the
/// mean second difference of frames over the mean first one: 0 if every pixel changes evenly, 2 if all
/// flicker. The largest step is that of a pixel's red, green or blue on black, of 255. All methods are
/// measured, or the one that --method names. The camera turns about its target around its up vector.
#[derive(Args)]
pub(crate) struct PoppingArgs {
    /// First angle in degrees, from the scene's camera
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true)]
    from: f64,

    /// Last angle in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 90.0, allow_hyphen_values = true)]
    to: f64,

    /// Degrees between two frames
    #[arg(long, value_name = "DEGREES", default_value_t = 1.0, allow_hyphen_values = true)]
    step: f64,

    /// Answer in JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    scene: SceneFlags,
}

pub(crate) fn run(args: &PoppingArgs) -> Result<()> {
    let PoppingArgs { from, to, step, .. } = *args;
    let sweep = Sweep::new(from, to).step_degrees(step).checked()?;
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
        meter::table(&reports)
    };
    terminal::answer(&text)
}

fn json_of(sweep: Sweep, reports: &[PoppingReport]) -> Value {
    let method = |report: &PoppingReport| {
        json!({
            "method": report.method.name(),
            "pop_ratio": report.pop_ratio,
            "largest_change": report.largest,
            "median_change": report.median,
            "jitter": report.jitter,
            "largest_step": report.largest_step,
            "at_degrees": report.at_degrees.map(meter::degrees),
            "changes": report.changes,
        })
    };
    json!({
        "sweep": {
            "from": sweep.from_degrees,
            "to": sweep.to_degrees,
            "step": sweep.step_degrees,
        },
        "methods": reports.iter().map(method).collect::<Vec<_>>(),
    })
}
