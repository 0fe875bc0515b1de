//! Views like those of figure 9: two frames on either side of 45° by each method, and what pops between.

use super::faces::popping_row;
use super::html::{Cell, Picture, paragraph, pictures, table};
use super::page::{Claim, Section};
use super::volumes::{HEAD, NERVE_CELL, StandIn, turned};
use super::{Studio, or_dash, title};
use anyhow::Result;
use slabsplat::{Method, PoppingReport, Scene, Sweep, paper};

/// Voxels along a side of the head and of the nerve cell.
const SIDES: [usize; 2] = [96, 256];

/// Pixels along a side of the pictures, and of those that are compared.
const SIDE_PIXELS: u32 = 220;
const METER_SIDE_PIXELS: u32 = 128;

const ANGLES: [f64; 2] = [44.5, 45.5];

/// Neither begins nor ends on 45°, where no axis is nearer.
const TURN: Sweep = Sweep::turn(40.25, 49.75).step(0.5);

/// How figure 9 is drawn: by which method, with slabs of which width.
#[derive(Clone, Copy)]
struct Way {
    part: &'static str,
    method: Method,
    slab_width: f64,
}

/// Figure 9a, b and c, and the method that the figure does not show.
const WAYS: [Way; 4] = [
    Way { part: "9a", method: Method::AxisAligned, slab_width: 1.0 },
    Way { part: "9b", method: Method::ImageAligned, slab_width: 1.0 },
    Way { part: "9c", method: Method::ImageAligned, slab_width: 2.0 },
    Way { part: "not shown", method: Method::EverySample, slab_width: 1.0 },
];

impl Way {
    fn of(&self, scene: &Scene) -> Scene {
        let Self { method, slab_width, .. } = *self;
        scene.clone().settings(paper::settings().method(method).slab_width(slab_width))
    }

    fn name(&self) -> String {
        match self.method {
            Method::ImageAligned => format!("image-aligned, slabs of width {}", self.slab_width),
            method => title(method).to_owned(),
        }
    }
}

pub(super) fn section(studio: &mut Studio) -> Result<Section> {
    let [head_side, cell_side] = SIDES;
    let head = scene(HEAD, head_side)?;
    let cell = scene(NERVE_CELL, cell_side)?;
    let of_head = measure(studio, &head)?;
    let of_cell = measure(studio, &cell)?;
    let body = [
        paragraph(&format!(
            "The paper shows an MRI of a brain and a nerve cell, which are not ours to give. In their place \
             stand two built-in volumes: the head phantom of Shepp and Logan with {head_side} voxels a side, and \
             a nerve cell that grew by rules, with {cell_side}. The head is smoother than any brain, so that \
             nothing distracts from what the methods do; at its borders they show the staircases that the paper \
             finds at forehead and cheeks."
        )),
        pictures(
            "Figure 9a to c, on the head: two frames a degree apart, before 45° and behind",
            &shown(studio, &head)?,
        )?,
        meter_table("The head", &of_head),
        pictures(
            "Figure 9d, on the nerve cell, the traditional method first",
            &shown(studio, &cell)?[..4],
        )?,
        meter_table("The nerve cell", &of_cell),
        paragraph(
            "The camera turns from 40.25° to 49.75° in steps of half a degree. The pop ratio is the largest change \
             of the picture over the median one: near 1, nothing pops. Jitter is the mean second difference of \
             frames over the mean first one: it falls where every pixel changes evenly.",
        ),
        paragraph(
            "Slabs of width 2 make the nerve cell flicker. On the head they leave rings, which one sees in the \
             picture; they move smoothly as it turns, and no number of this table is about stripes in a picture, \
             as that of figure 7 is.",
        ),
    ];
    Ok(Section {
        id: "figure-9",
        title: "Figure 9: two frames of a turn",
        claims: claims(&of_head, &of_cell),
        body: body.concat(),
    })
}

fn scene(stand_in: StandIn, side_voxels: usize) -> Result<Scene> {
    stand_in.scene(stand_in.volume(side_voxels)?, SIDE_PIXELS, paper::settings())
}

fn shown(studio: &mut Studio, scene: &Scene) -> Result<Vec<Picture>> {
    let mut shown = Vec::new();
    for way in &WAYS {
        for angle in ANGLES {
            let image = studio.draw(&turned(&way.of(scene), angle))?;
            shown.push(Picture { image, words: format!("{}, {angle}°", way.name()) });
        }
    }
    Ok(shown)
}

fn measure(studio: &mut Studio, scene: &Scene) -> Result<Vec<PoppingReport>> {
    let measure = |way: &Way| {
        let mut scene = way.of(scene);
        (scene.image.width, scene.image.height) = (METER_SIDE_PIXELS, METER_SIDE_PIXELS);
        studio.popping(&scene, way.method, TURN)
    };
    WAYS.iter().map(measure).collect()
}

fn meter_table(caption: &str, reports: &[PoppingReport]) -> String {
    let row = |(way, report): (&Way, &PoppingReport)| -> Vec<Cell> {
        let mut row = popping_row(way.name(), report);
        row.insert(1, way.part.into());
        row
    };
    table(
        caption,
        &["method", "figure", "pop ratio", "jitter", "largest change between"],
        WAYS.iter().zip(reports).map(row).collect(),
    )
}

fn claims(of_head: &[PoppingReport], of_cell: &[PoppingReport]) -> Vec<Claim> {
    let ratio = |reports: &[PoppingReport], idx: usize| reports[idx].pop_ratio;
    let [pops, even] = [0, 1].map(|idx| ratio(of_head, idx));
    let cell_ratio = ratio(of_cell, 1);
    let is_even = |ratio: Option<f64>| ratio.is_some_and(|ratio| ratio < 1.5);
    let jitter = |reports: &[PoppingReport]| [1, 2].map(|idx| reports[idx].jitter);
    let [on_head, on_cell] = [jitter(of_head), jitter(of_cell)];
    vec![
        Claim {
            paper: "9a: the traditional method pops where its sheets change direction",
            found: format!("pop ratio {}", or_dash(pops)).into(),
            agrees: pops.is_some_and(|ratio| 3.0 < ratio) && of_head[0].at == [44.75, 45.25],
        },
        Claim {
            paper: "9b: the new method changes in a continuous fashion",
            found: format!("pop ratio {}", or_dash(even)).into(),
            agrees: is_even(even),
        },
        Claim {
            paper: "9c: slabs of width 2 give rather disturbing artifacts",
            found: format!(
                "jitter at widths 1 and 2: {} and {} of the head, {} and {} of the nerve cell",
                or_dash(on_head[0]),
                or_dash(on_head[1]),
                or_dash(on_cell[0]),
                or_dash(on_cell[1])
            )
            .into(),
            agrees: [on_head, on_cell].into_iter().all(|[even, thick]| even < thick),
        },
        Claim {
            paper: "9d: no discrepancies in the illumination of the nerve cell",
            found: format!("pop ratio {}", or_dash(cell_ratio)).into(),
            agrees: is_even(cell_ratio),
        },
    ]
}
