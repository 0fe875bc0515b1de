//! Figure 7: the cube with slabs of three widths.

use super::cube::{magnified, profile, profile_plot};
use super::html::{Picture, paragraph, pictures, table};
use super::page::{Claim, Section};
use super::{Studio, red};
use anyhow::Result;
use slabsplat::Scene;
use slabsplat::paper::{self, CubeView, cube, face_means, face_profile, stripes};

const WIDTHS: [f64; 3] = [0.5, 1.0, 2.0];

fn scene(slab_width: f64) -> Scene {
    let settings = paper::settings().slab_width(slab_width);
    cube(&CubeView { angle_degrees: 45.0, opacity: 1.0, ambient: 0.0, settings })
}

pub(super) fn section(studio: &mut Studio) -> Result<Section> {
    let mut measured = Vec::new();
    let mut shown = Vec::new();
    for width in WIDTHS {
        measured.push(studio.draw(&scene(width))?);
        let image = studio.draw(&magnified(scene(width)))?;
        shown.push(Picture { image, words: format!("image-aligned, slabs of width {width}") });
    }
    let found: Vec<f64> = measured.iter().map(|image| stripes(&face_profile(red(image)))).collect();
    let brightness: Vec<f64> = measured.iter().map(|image| face_means(red(image))[1]).collect();
    let rows = WIDTHS.iter().zip(&found).zip(&brightness).map(|((width, stripes), mean)| {
        [format!("{width}"), format!("{stripes:.4}"), format!("{mean:.4}")].map(Into::into).into()
    });
    let profiles = WIDTHS.iter().zip(&measured);
    let profiles = profiles.map(|(width, image)| profile(format!("slabs of width {width}"), image));
    let body = [
        paragraph("The cube of figure 6 at 45°, with thinner and with thicker slabs."),
        pictures("Figure 7", &shown)?,
        profile_plot(&profiles.collect::<Vec<_>>()),
        table(
            "Stripes are the standard deviation of brightness along a face over its mean",
            &["slab width", "stripes", "mean brightness"],
            rows.collect(),
        ),
        paragraph(
            "The paper prints no numbers. Where thick sections are composited near the eye, the face is bright; \
             with slabs of width 2 that shows as stripes, and with thinner ones the kernels blur it.",
        ),
    ];
    Ok(Section {
        id: "figure-7",
        title: "Figure 7: slab widths",
        claims: claims(&found, &brightness),
        body: body.concat(),
    })
}

fn claims(stripes: &[f64], brightness: &[f64]) -> Vec<Claim> {
    let (&[half, one, two], &[dark, middle, bright]) = (stripes, brightness) else {
        return Vec::new();
    };
    vec![
        Claim {
            paper: "a slab width of 2 produces strong periodic artifacts",
            found: format!("stripes {two:.3}, and {one:.3} at width 1").into(),
            agrees: 0.05 < two && 5.0 * one < two,
        },
        Claim {
            paper: "a slab width of 0.5 does not improve much on 1",
            found: format!("stripes {half:.4} and {one:.4}").into(),
            agrees: half < 0.01 && one < 0.01,
        },
        Claim {
            paper: "thinner slabs produce darker images",
            found: format!("{dark:.3}, {middle:.3} and {bright:.3}").into(),
            agrees: dark < middle && middle < bright,
        },
    ]
}
