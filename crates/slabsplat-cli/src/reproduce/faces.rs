//! Figures 2 and 6: the binary cube on either side of the angle at which slices change their axis.

use super::cube::{magnified, profile, profile_plot};
use super::html::{Cell, Picture, paragraph, pictures, table};
use super::page::{Claim, Section};
use super::plot::{Axis, Line, Scale, plot};
use super::{METHODS, Studio, or_dash, red, title};
use anyhow::Result;
use slabsplat::paper::{self, CubeView, cube, face_means};
use slabsplat::{Image, Method, PoppingReport, Scene, Sweep};

/// The paper has 45° and 45.2°. At 45° neither axis is nearer, so that here both lie as far from it.
const ANGLES: [f64; 2] = [44.9, 45.1];

const TURN: Sweep = Sweep::turn(40.1, 49.9).step(0.2);

/// The cube by one method at both angles.
struct Faces {
    method: Method,
    measured: [Image; 2],
    popping: PoppingReport,
}

impl Faces {
    fn measure(studio: &mut Studio, method: Method) -> Result<Self> {
        let [before, after] = ANGLES.map(|angle| studio.draw(&scene(method, angle)));
        let popping = studio.popping(&scene(method, 0.0), method, TURN)?;
        Ok(Self { method, measured: [before?, after?], popping })
    }

    /// Means of the left and the right face at both angles.
    fn means(&self) -> [[f64; 2]; 2] {
        self.measured.each_ref().map(|image| face_means(red(image)))
    }

    /// The brighter face over the other at the first angle, if they change sides at the second; else 1.
    fn imbalance(&self) -> f64 {
        let [[left, right], [left_then, right_then]] = self.means();
        let ratio = left / right;
        if (ratio < 1.0) == (left_then < right_then) { 1.0 } else { ratio.max(1.0 / ratio) }
    }
}

fn scene(method: Method, angle_degrees: f64) -> Scene {
    let settings = paper::settings().method(method);
    cube(&CubeView { angle_degrees, opacity: 1.0, ambient: 0.0, settings })
}

pub(super) fn section(studio: &mut Studio) -> Result<Section> {
    let mut all = Vec::new();
    let mut shown = Vec::new();
    for method in METHODS {
        all.push(Faces::measure(studio, method)?);
        for angle in ANGLES {
            let image = studio.draw(&magnified(scene(method, angle)))?;
            shown.push(Picture { image, words: format!("{}, {angle}°", title(method)) });
        }
    }
    let body = [
        paragraph(
            "A binary cube of 16 voxels a side, white and opaque, with diffuse light from the eye and none where \
             there is no gradient; slabs of width 1. The paper shows it at 45° and 45.2°, here it stands as far \
             before 45° as behind.",
        ),
        pictures(
            "Figure 2 (axis-aligned) and figure 6 (image-aligned), and the original method",
            &shown,
        )?,
        table(
            "Mean brightness of the faces, left and right",
            &["method", "44.9°", "", "45.1°", "", "brighter : darker face"],
            all.iter().map(means_row).collect(),
        ),
        profile_plot(&profiles(&all)),
        paragraph(
            "The paper prints no brightness. It says that the face which is parallel to the sheets is much the \
             brighter, that it is another one after 45°, and that with its own method both have the same shade, \
             darker than before: both faces are composited now.",
        ),
        changes_plot(&all),
        table(
            "The same as numbers: the largest change over the median one, and how unevenly pixels change",
            &["method", "pop ratio", "jitter", "between"],
            all.iter()
                .map(|faces| popping_row(title(faces.method).to_owned(), &faces.popping))
                .collect(),
        ),
    ];
    let claims = claims(&all);
    Ok(Section {
        id: "figures-2-and-6",
        title: "Figures 2 and 6: the cube at 45°",
        claims,
        body: body.concat(),
    })
}

fn means_row(faces: &Faces) -> Vec<Cell> {
    let means = faces.means();
    let mut row: Vec<Cell> = vec![title(faces.method).into()];
    row.extend(means.as_flattened().iter().map(|mean| format!("{mean:.4}").into()));
    let [[left, right], _] = means;
    row.push(format!("{:.3} : 1", left.max(right) / left.min(right)).into());
    row
}

/// What the popping meter reads of one turn.
pub(super) fn popping_row(name: String, report: &PoppingReport) -> Vec<Cell> {
    let [from, to] = report.at;
    vec![
        name.into(),
        or_dash(report.pop_ratio).into(),
        or_dash(report.jitter).into(),
        format!("{from:.1}° and {to:.1}°").into(),
    ]
}

/// Of the two methods that the paper compares.
fn profiles(all: &[Faces]) -> Vec<Line> {
    let of_method = |faces: &Faces| {
        let line = |idx: usize| {
            profile(format!("{}, {}°", faces.method, ANGLES[idx]), &faces.measured[idx])
        };
        [line(0), line(1)]
    };
    all.iter().take(2).flat_map(of_method).collect()
}

fn changes_plot(all: &[Faces]) -> String {
    let half_step = TURN.step / 2.0;
    let lines = all.iter().map(|faces| {
        let changes = faces.popping.changes.iter().enumerate();
        let points = changes.map(|(idx, change)| [TURN.at(idx) + half_step, *change]);
        Line { label: title(faces.method).to_owned(), points: points.collect() }
    });
    plot(
        "By how much the picture changes from one frame to the next, 0.2° apart, as the cube turns: a pop is a \
         peak",
        &Axis {
            label: "degrees",
            range: [40.0, 50.0],
            ticks: &[40.0, 42.0, 44.0, 45.0, 46.0, 48.0, 50.0],
            scale: Scale::Linear,
        },
        &Axis {
            label: "mean change of a channel",
            range: [1e-5, 1.0],
            ticks: &[1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0],
            scale: Scale::Logarithmic,
        },
        &lines.collect::<Vec<_>>(),
    )
}

fn claims(all: &[Faces]) -> Vec<Claim> {
    let [axis_aligned, image_aligned, ..] = all else { return Vec::new() };
    let popping = |faces: &Faces| or_dash(faces.popping.pop_ratio);
    let [of_axis, of_image] =
        [axis_aligned, image_aligned].map(|f| f.popping.pop_ratio.unwrap_or(1.0));
    vec![
        Claim {
            paper: "figure 2: the face parallel to the sheets is much brighter, and after 45° it is the other one",
            found: format!("{:.2} times as bright", axis_aligned.imbalance()).into(),
            agrees: 1.5 < axis_aligned.imbalance(),
        },
        Claim {
            paper: "figure 6: both faces have the same brightness at both angles",
            found: format!("within {:.1} %", 100.0 * (image_aligned.imbalance() - 1.0)).into(),
            agrees: image_aligned.imbalance() < 1.01,
        },
        Claim {
            paper: "popping at 45° no longer occurs",
            found: format!(
                "pop ratio {}, {} before",
                popping(image_aligned),
                popping(axis_aligned)
            )
            .into(),
            agrees: of_image < 1.5 && 10.0 < of_axis,
        },
    ]
}
