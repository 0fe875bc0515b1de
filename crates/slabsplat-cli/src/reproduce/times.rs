//! The times of §5, by stage and method: printed, and here.

use super::Studio;
use super::html::{Cell, paragraph, table};
use super::page::{Claim, Section};
use super::volumes::{HEAD, NERVE_CELL, StandIn, turned};
use crate::advice;
use crate::bench::median;
use anyhow::Result;
use slabsplat::paper::{self, PRINTED_TIMES, PrintedTimes};
use slabsplat::{Frame, Method, RenderSettings, Scene};
use std::time::Instant;

/// Voxels along a side: of both volumes about as many are relevant as of the paper's.
const SIDES: [usize; 2] = [168, 532];

/// The paper does not say how large its pictures were.
const SIDE_PIXELS: u32 = 300;

/// Frames that are timed, a degree apart, after one that makes lists and tables.
const N_FRAMES: u16 = 3;

/// How a volume is drawn.
struct Way {
    name: &'static str,
    settings: fn() -> RenderSettings,
    /// What the paper prints of it, sorting and shading included.
    printed_secs: fn(&PrintedTimes) -> Option<f64>,
}

const WAYS: [Way; 4] = [
    Way {
        name: "axis-aligned",
        settings: || paper::settings().method(Method::AxisAligned),
        printed_secs: |printed| Some(printed.shade_secs + printed.axis_aligned_secs),
    },
    Way {
        name: "image-aligned",
        settings: paper::settings,
        printed_secs: |printed| {
            Some(printed.shade_secs + printed.image_aligned_secs + printed.sort_secs.unwrap_or(0.0))
        },
    },
    Way {
        name: "every-sample",
        settings: || paper::settings().method(Method::EverySample),
        printed_secs: |_| None,
    },
    Way {
        name: "image-aligned, by default",
        settings: RenderSettings::default,
        printed_secs: |_| None,
    },
];

/// What a volume took in one way.
struct Measured {
    frame: Frame,
    ms: f64,
}

pub(super) fn section(studio: &mut Studio) -> Result<Section> {
    let mut of_volumes = Vec::new();
    for (stand_in, side) in [HEAD, NERVE_CELL].into_iter().zip(SIDES) {
        of_volumes.push(measure(studio, stand_in, side)?);
    }
    let [head_side, cell_side] = SIDES;
    let mut body = vec![paragraph(&format!(
        "§5 gives the times of an SGI Onyx with InfiniteReality, whose graphics hardware drew the splats. Beside \
         them stand those of the machine that made this page, on the head phantom with {head_side} voxels a side \
         and the nerve cell with {cell_side}: about as many relevant voxels as the paper’s. The pictures have \
         {SIDE_PIXELS}² pixels; the paper does not say how many its own had. A time is the median of {N_FRAMES} \
         frames of a turning camera, plan included."
    ))];
    for ((measured, printed), stand_in) in
        of_volumes.iter().zip(&PRINTED_TIMES).zip([HEAD, NERVE_CELL])
    {
        body.push(whole_frames(measured, printed, stand_in));
        body.push(stages(measured, stand_in));
    }
    body.push(paragraph(
        "The paper’s time is that of sorting, shading and splatting, as far as it prints them; the ratio is that of \
         times for as many voxels. The last row is what slabsplat does if nobody asks for the paper’s settings: \
         extinction instead of separate sums, what is occluded is culled, and faint sections are merged. Intake \
         finds the voxels of the next slabs, shades, projects and tosses them, which takes the place of the \
         paper’s sort. Splatted sections are counted once for every tile of the picture that they touch, and \
         not where saturated pixels hide them. Shading and compositing do not grow with them, and a section covers \
         fewer pixels than a whole footprint: time grows much less than their number.",
    ));
    body.push(paragraph(
        "The paper gives the brain’s voxels as 256 × 256 × 145 and the relevant ones as about 1.2 million or 16 %; \
         16 % are 1.5 million, and 1.2 million are 13 %.",
    ));
    let claims =
        of_volumes.iter().zip(&PRINTED_TIMES).map(|(measured, printed)| claim(measured, printed));
    let claims = claims.collect();
    Ok(Section { id: "section-5", title: "§5: times", claims, body: body.concat() })
}

fn measure(studio: &mut Studio, stand_in: StandIn, side: usize) -> Result<Vec<Measured>> {
    let scene = stand_in.scene(stand_in.volume(side)?, SIDE_PIXELS, paper::settings())?;
    let measure = |way: &Way| time(studio, &scene.clone().settings((way.settings)()));
    WAYS.iter().map(measure).collect()
}

fn time(studio: &mut Studio, scene: &Scene) -> Result<Measured> {
    let mut frame_at = |degrees: u16| {
        let scene = turned(scene, 30.0 + f64::from(degrees));
        let started = Instant::now();
        let frame = advice::render(&mut studio.renderer, &scene)?;
        anyhow::Ok(Measured { frame, ms: started.elapsed().as_secs_f64() * 1e3 })
    };
    let mut last = frame_at(0)?;
    let mut all_ms = Vec::new();
    for degrees in 1..=N_FRAMES {
        last = frame_at(degrees)?;
        all_ms.push(last.ms);
    }
    Ok(Measured { ms: median(&all_ms), ..last })
}

fn whole_frames(measured: &[Measured], printed: &PrintedTimes, stand_in: StandIn) -> String {
    let rows = WAYS.iter().zip(measured).map(|(way, measured)| {
        let printed_secs = (way.printed_secs)(printed);
        vec![
            way.name.into(),
            printed_secs.map_or("–".to_owned(), |secs| format!("{secs:.1} s")).into(),
            millions(measured.frame.stats.n_voxels as f64).into(),
            millions(measured.frame.stats.n_splats as f64).into(),
            Cell::of_machine(format!("{:.0} ms", measured.ms)),
            Cell::of_machine(printed_secs.map_or("–".to_owned(), |secs| {
                format!("{:.0} ×", speed(secs, printed, measured))
            })),
        ]
    });
    table(
        &format!(
            "{}, {} relevant voxels in the paper; here {}",
            printed.volume,
            millions(printed.n_voxels),
            stand_in.builtin
        ),
        &[
            "method",
            "printed",
            "relevant voxels here",
            "sections splatted",
            "a frame here",
            "faster by",
        ],
        rows.collect(),
    )
}

/// How much less time a relevant voxel takes here.
fn speed(printed_secs: f64, printed: &PrintedTimes, measured: &Measured) -> f64 {
    let ours = measured.ms * 1e-3 / measured.frame.stats.n_voxels as f64;
    printed_secs / printed.n_voxels / ours
}

/// A column for each stage that any method has, in the order of frames.
fn stages(measured: &[Measured], stand_in: StandIn) -> String {
    let mut names: Vec<&str> = Vec::new();
    for stage in measured.iter().flat_map(|measured| &measured.frame.cost.stages) {
        if !names.contains(&stage.name) {
            names.push(stage.name);
        }
    }
    let rows = WAYS.iter().zip(measured).map(|(way, measured)| {
        let stages = &measured.frame.cost.stages;
        let ms = |name: &&str| {
            let stage = stages.iter().find(|stage| stage.name == *name);
            Cell::of_machine(stage.map_or("–".to_owned(), |stage| format!("{:.1}", stage.ms)))
        };
        std::iter::once(way.name.into()).chain(names.iter().map(ms)).collect()
    });
    let rows = rows.collect();
    let head: Vec<&str> = std::iter::once("method").chain(names.iter().copied()).collect();
    table(
        &format!("{}, milliseconds of each stage of its last frame", stand_in.builtin),
        &head,
        rows,
    )
}

/// §5 on sections and times: both of `image-aligned` over those of `axis-aligned`.
fn claim(measured: &[Measured], printed: &PrintedTimes) -> Claim {
    let [axis_aligned, image_aligned] = [&measured[0], &measured[1]];
    let n_splats = [axis_aligned, image_aligned].map(|m| m.frame.stats.n_splats as f64);
    let sections = n_splats[1] / n_splats[0];
    let times = image_aligned.ms / axis_aligned.ms;
    let by_paper = printed.image_aligned_secs / printed.axis_aligned_secs;
    Claim {
        paper: "the time is roughly proportional to the number of partial splats",
        found: Cell::of_machine(format!(
            "{}: {sections:.1} times as many take {times:.1} times as long; in the paper it is {by_paper:.1} times",
            printed.volume
        )),
        agrees: (0.4..2.5).contains(&(times / sections)),
    }
}

fn millions(number: f64) -> String {
    format!("{:.2} million", number * 1e-6)
}
