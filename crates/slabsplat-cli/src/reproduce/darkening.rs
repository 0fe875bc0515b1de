//! Figure 8 and eqs. 6 to 8: how thick sections are made to look like the thin ones that they stand for.

use super::html::{Cell, paragraph, table};
use super::page::{Claim, Section};
use super::{Studio, red};
use anyhow::Result;
use slabsplat::paper::{self, CubeView, cube, face_means, single_voxel, sum_over_picture};
use slabsplat::{Mode, Normalization, RenderSettings};

const WIDTHS: [f64; 3] = [0.5, 1.0, 2.0];

const NORMALIZATIONS: [(Normalization, &str); 3] = [
    (Normalization::None, "none"),
    (Normalization::Paper, "eq. 8 as it is printed"),
    (Normalization::Product, "eq. 8 under a square root"),
];

/// How a face is composited: by the paper's model with each normalisation, and by the two others.
const FACES: [(Mode, Normalization, &str); 5] = [
    (Mode::Separate, Normalization::None, "separate (the paper’s), no normalisation"),
    (Mode::Separate, Normalization::Paper, "separate, eq. 8 as it is printed"),
    (Mode::Separate, Normalization::Product, "separate, eq. 8 under a square root"),
    (Mode::Associated, Normalization::None, "associated"),
    (Mode::Extinction, Normalization::None, "extinction (slabsplat’s default)"),
];

pub(super) fn section(studio: &mut Studio) -> Result<Section> {
    let mut sums = Vec::new();
    for (normalization, _) in NORMALIZATIONS {
        sums.push(of_widths(|width| {
            voxel_sum(studio, &paper::settings().normalization(normalization).slab_width(width))
        })?);
    }
    let mut faces = Vec::new();
    for (mode, normalization, _) in FACES {
        let settings = paper::settings().mode(mode).normalization(normalization);
        let [half, one, two] =
            of_widths(|width| face_brightness(studio, &settings.clone().slab_width(width)))?;
        faces.push([1.0, one / half, two / half]);
    }
    let head = ["normalisation", "width 0.5", "width 1", "width 2"];
    let body = [
        paragraph(
            "Two thin sections of a voxel are composited, the thick one that holds both is added up (figure 8), \
             and so a picture gets brighter with the width of slabs. Eq. 8 is to undo that. Here is one white \
             voxel of opacity ½, summed over the picture; the thinnest slabs are what the others should give.",
        ),
        table(
            "One voxel, all of its light",
            &head,
            rows(NORMALIZATIONS.map(|(_, name)| name), &sums),
        ),
        paragraph(
            "Taken literally, eq. 8 does not do what eqs. 6 and 7 ask, since these compare products of two \
             footprints, opacity times colour. With the correction under a square root it does.",
        ),
        table(
            "A lit face of the cube at 45°, opacity ½, over its brightness with slabs of width 0.5",
            &["compositing", "width 0.5", "width 1", "width 2"],
            rows(FACES.map(|(.., name)| name), &faces),
        ),
        paragraph(
            "Among other voxels no normalisation of single ones is enough. Where extinction is summed, two slabs \
             have the opacity of the one that holds both, and there is little to normalise.",
        ),
    ];
    let [_, literal, root] = NORMALIZATIONS.map(|(_, name)| name).map(|name| of_name(name, &sums));
    let claims = vec![
        claim("eq. 8 makes thick sections as bright as the thin ones", literal),
        claim("the same, under the square root that eqs. 6 and 7 ask for", root),
    ];
    Ok(Section {
        id: "figure-8",
        title: "Figure 8: thick and thin sections",
        claims,
        body: body.concat(),
    })
}

/// Sums at widths of 1 and 2 over that at 0.5.
fn of_name(name: &str, sums: &[[f64; 3]]) -> [f64; 2] {
    let row = NORMALIZATIONS.iter().zip(sums).find(|((_, other), _)| *other == name);
    row.map_or([f64::NAN; 2], |(_, [half, one, two])| [one / half, two / half])
}

fn claim(paper: &'static str, ratios: [f64; 2]) -> Claim {
    let [one, two] = ratios;
    Claim {
        paper,
        found: format!("{one:.2} and {two:.2} times as bright with widths 1 and 2").into(),
        agrees: ratios.into_iter().all(|ratio| (ratio - 1.0).abs() < 0.05),
    }
}

fn of_widths(mut measure: impl FnMut(f64) -> Result<f64>) -> Result<[f64; 3]> {
    let [half, one, two] = WIDTHS;
    Ok([measure(half)?, measure(one)?, measure(two)?])
}

fn voxel_sum(studio: &mut Studio, settings: &RenderSettings) -> Result<f64> {
    let image = studio.draw(&single_voxel(settings.clone()))?;
    Ok(sum_over_picture([image.width(), image.height()], red(&image)))
}

fn face_brightness(studio: &mut Studio, settings: &RenderSettings) -> Result<f64> {
    let settings = settings.clone();
    let view = CubeView { angle_degrees: 45.0, opacity: 0.5, ambient: 0.1, settings };
    let image = studio.draw(&cube(&view))?;
    Ok(face_means(red(&image))[1])
}

fn rows<const N: usize>(names: [&str; N], numbers: &[[f64; 3]]) -> Vec<Vec<Cell>> {
    let row = |(name, numbers): (&&str, &[f64; 3])| {
        let mut row: Vec<Cell> = vec![(*name).into()];
        row.extend(numbers.iter().map(|number| format!("{number:.3}").into()));
        row
    };
    names.iter().zip(numbers).map(row).collect()
}
