//! Which edges of the box have coordinates, and what of these is drawn.
//!
//! Of the two outer edges of an axis the upright axis has them at the left one, and the others at the lower
//! one. Which axis is upright follows from the camera's up vector, which stays as things turn. So another
//! edge is taken only where the one before it ceases to be an outer edge, as a face comes to the front or
//! goes behind; there both are seen along the same line if the axis is the one that things turn about.

use slabsplat_core::glam::DVec2;
use slabsplat_core::{Acquisition, Orientation, Scene};

use super::bounds::{Bounds, Edge};
use super::scale::{Axis, Placed, Scale, middle_of};
use crate::screen::Screen;
use crate::shapes::{Line, draw_lines};
use crate::sheet::Sheet;
use crate::text::{Label, draw_text};

/// What is drawn along one axis.
#[derive(Clone, Debug)]
pub(super) struct Labelled<'a> {
    pub(super) scale: Scale<'a>,
    pub(super) name: Placed,
    pub(super) numbers: Vec<Placed>,
}

/// Ems between a number and what is written on other axes; and the least of them, where an axis would have no
/// scale otherwise.
const APART: f64 = 0.5;
const LEAST_APART: f64 = 0.1;

/// An edge is seen end on where it is shorter than this part of its length.
const END_ON: f64 = 0.4;

/// Draws coordinates along an outer edge of each axis.
pub(crate) fn draw_coordinates(
    sheet: &mut Sheet<'_>,
    scene: &Scene,
    screen: &Screen,
    acquisition: Acquisition,
) {
    let Some(bounds) = Bounds::of(scene) else { return };
    let unit = bounds.unit(acquisition.is_metric);
    let em = f64::from(sheet.text_size());
    let axes = [0, 1, 2].map(|idx| Axis::of(&bounds, idx, unit, screen, em));
    let names = [0, 1, 2].map(|idx| match unit.symbol {
        "" => name(idx, acquisition.orientation).to_owned(),
        unit => format!("{} ({unit})", name(idx, acquisition.orientation)),
    });
    let (labelled, missing) = lay_out(sheet, &bounds, &axes, &names, screen);
    for labelled in &labelled {
        draw(sheet, labelled);
    }
    if !missing.is_empty() {
        let missing: Vec<&str> =
            missing.into_iter().map(|idx| name(idx, acquisition.orientation)).collect();
        sheet.no_room_for(&format!("what is written on the axes {}", missing.join(", ")));
    }
}

/// Of a body, where coordinates grow.
pub(super) fn name(axis: usize, orientation: Orientation) -> &'static str {
    match orientation {
        Orientation::Anatomical => ["R", "A", "S"][axis],
        Orientation::Unknown | Orientation::Pictures => ["x", "y", "z"][axis],
    }
}

/// What is written, which takes its places on the sheet; and the axes that have no room, other than those
/// that are seen end on.
pub(super) fn lay_out<'a>(
    sheet: &mut Sheet<'_>,
    bounds: &Bounds,
    axes: &'a [Axis; 3],
    names: &[String; 3],
    screen: &Screen,
) -> (Vec<Labelled<'a>>, Vec<usize>) {
    let edges = bounds.edges(screen);
    let upright = screen.upright_axis();
    let middle = screen.point(bounds.middle());
    let order = [upright, (upright + 1) % 3, (upright + 2) % 3];
    let (mut scales, mut missing) = (Vec::new(), Vec::new());
    for idx in order {
        let outer = outer_edges(&edges, idx, upright, screen);
        let seen = outer.iter().find(|edge| axes[idx].has_ticks_on(edge, screen));
        let scale = seen.and_then(|edge| Scale::of(&axes[idx], *edge, screen, middle?));
        match scale {
            Some(scale) => scales.push(scale),
            None if is_end_on(&outer, &axes[idx], screen) => {}
            None => missing.push(idx),
        }
    }
    let lines: Vec<(usize, Line)> =
        scales.iter().map(|scale| (scale.axis.idx, scale.line)).collect();
    let numbers: Vec<Placed> = scales.iter().flat_map(|scale| scale.numbers.clone()).collect();
    let mut named = Vec::new();
    for scale in scales {
        let idx = scale.axis.idx;
        match name_of(sheet, &scale, &names[idx], idx == upright, (&lines, &numbers)) {
            Some(name) => {
                sheet.take(name.bounds());
                named.push((scale, name));
            }
            None => missing.push(idx),
        }
    }
    let names: Vec<(usize, Placed)> =
        named.iter().map(|(scale, name)| (scale.axis.idx, name.clone())).collect();
    let mut all: Vec<Labelled<'a>> = Vec::new();
    for (scale, name) in named {
        let idx = scale.axis.idx;
        let other_names = names.iter().filter(|(axis, _)| *axis != idx).map(|(_, name)| name);
        let others: Vec<&Placed> =
            other_names.chain(all.iter().flat_map(|labelled| &labelled.numbers)).collect();
        let free = |ems: f64| -> Vec<Placed> {
            let is_its = |number: &&Placed| {
                sheet.is_free(number.bounds())
                    && others.iter().all(|other| number.is_apart(other, ems * scale.axis.em))
                    && is_nearest(number, idx, &lines)
            };
            scale.numbers.iter().filter(is_its).cloned().collect()
        };
        let numbers = Some(free(APART)).filter(|numbers| 2 <= numbers.len());
        let numbers = numbers.unwrap_or_else(|| free(LEAST_APART));
        if numbers.len() < 2 {
            missing.push(idx);
            continue;
        }
        numbers.iter().for_each(|number| sheet.take(number.bounds()));
        all.push(Labelled { scale, name, numbers });
    }
    missing.sort_unstable();
    (all, missing)
}

/// The edges of an axis that are part of the outline, the one that is to have coordinates first.
fn outer_edges(edges: &[Edge], idx: usize, upright: usize, screen: &Screen) -> Vec<Edge> {
    let outer = edges.iter().filter(|edge| edge.axis == idx && edge.n_front == 1);
    let middles = outer.filter_map(|edge| Some((*edge, middle_of(edge, screen)?)));
    let mut outer: Vec<(Edge, DVec2)> = middles.collect();
    let place = |middle: &DVec2| if idx == upright { middle.x } else { -middle.y };
    outer.sort_by(|(_, a), (_, b)| place(a).total_cmp(&place(b)));
    outer.into_iter().map(|(edge, _)| edge).collect()
}

fn is_end_on(outer: &[Edge], axis: &Axis, screen: &Screen) -> bool {
    let lines = outer.iter().filter_map(|edge| screen.line(edge.ends));
    lines.map(|[from, to]| from.distance(to)).all(|length| length < END_ON * axis.pixels)
}

/// Where a scale's name has room: on no coordinates, or else at least on none of its own.
fn name_of(
    sheet: &Sheet<'_>,
    scale: &Scale<'_>,
    name: &str,
    is_upright: bool,
    (lines, numbers): (&[(usize, Line)], &[Placed]),
) -> Option<Placed> {
    let places = scale.name_places(name, is_upright).into_iter();
    let places: Vec<Placed> = places.map(|place| place.within(sheet.size())).collect();
    let suits = |place: &&Placed, numbers: &[Placed]| {
        sheet.is_free(place.bounds())
            && is_nearest(place, scale.axis.idx, lines)
            && numbers.iter().all(|number| place.is_apart(number, 0.0))
    };
    let best = places.iter().find(|place| suits(place, numbers));
    best.or_else(|| places.iter().find(|place| suits(place, &scale.numbers))).cloned()
}

/// Whether no labelled edge of another axis is nearer.
fn is_nearest(placed: &Placed, idx: usize, lines: &[(usize, Line)]) -> bool {
    let distance = |is_own: bool| {
        let distances = lines.iter().filter(|(axis, _)| (*axis == idx) == is_own);
        distances.map(|(_, line)| placed.distance_to(*line)).fold(f64::INFINITY, f64::min)
    };
    // At a corner that two edges share both are as near.
    distance(true) <= distance(false) + 1e-6
}

fn draw(sheet: &mut Sheet<'_>, Labelled { scale, name, numbers }: &Labelled<'_>) {
    let em = scale.axis.em;
    let [from, to] = scale.line;
    let (ink, pen) = (sheet.ink_at(from.midpoint(to).y), sheet.pen());
    let marks: Vec<Line> =
        scale.ticks.iter().map(|at| [*at, *at + scale.outwards * (0.4 * em)]).collect();
    draw_lines(sheet.image, &marks, pen, ink);
    for Placed { text, center, .. } in numbers.iter().chain([name]) {
        let ink = sheet.ink_at(center.y);
        let at = [center.x as f32, center.y as f32];
        let size_pixels = em as f32;
        draw_text(sheet.image, &Label { text, at, anchor: [0.5, 0.5], size_pixels, ink });
    }
}
