//! An edge of the box with coordinates: where they are in the picture, and how many have room beside each
//! other.
//!
//! How far coordinates are apart follows from the size that the box has in the picture, and not from the
//! angle at which an edge is seen: in a film of a thing that turns it stays. Where an edge is foreshortened
//! until they touch, every second or fifth is written, then the first and the last, and none where these
//! touch too.

use slabsplat_core::glam::DVec2;
use slabsplat_core::round_ticks;

use super::bounds::{Bounds, Edge};
use crate::lengths::Unit;
use crate::screen::Screen;
use crate::shapes::{Line, clipped};
use crate::sheet::written;
use crate::text::measure_text;

/// Round coordinates along an axis, on whichever edge they will stand.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) idx: usize,
    unit: Unit,
    ticks: Vec<Tick>,
    /// Pixels from end to end if it lay in the plane of the picture.
    pub(super) pixels: f64,
    /// Pixels of an em.
    pub(super) em: f64,
}

#[derive(Clone, Debug)]
struct Tick {
    coordinate: f64,
    /// The step at which it is, counted from 0.
    number: i64,
    text: String,
    size: DVec2,
}

/// A box of text in the picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) text: String,
    pub(super) center: DVec2,
    pub(super) size: DVec2,
}

/// An edge with coordinates.
#[derive(Clone, Debug)]
pub(super) struct Scale<'a> {
    pub(super) axis: &'a Axis,
    /// As far as it is in the picture.
    pub(super) line: Line,
    /// Away from the box, of length 1.
    pub(super) outwards: DVec2,
    /// Where coordinates are on the line.
    pub(super) ticks: Vec<DVec2>,
    pub(super) numbers: Vec<Placed>,
    /// The largest size of a coordinate, written or not.
    widest: DVec2,
}

/// Ems between coordinates, at least, on an edge that is not foreshortened.
const SPACING: f64 = 6.0;

/// Ems between an edge and its coordinates, and between these and what they are of.
const GAP: f64 = 0.6;
const NAME_GAP: f64 = 0.25;

/// Ems between two coordinates.
const APART: f64 = 0.5;

impl Axis {
    pub(super) fn of(bounds: &Bounds, idx: usize, unit: Unit, screen: &Screen, em: f64) -> Self {
        let ends = bounds.0.map(|end| end[idx] / unit.in_world);
        let pixels = bounds.size()[idx] * screen.pixels_per_world();
        let n_steps = (pixels / (SPACING * em)).clamp(2.0, 100.0) as u32;
        // One coordinate alone is no scale.
        let mut finer = (n_steps..n_steps + 8).map(|n_steps| round_ticks(ends, n_steps));
        let ticks = finer.find(|ticks| 3 <= ticks.len()).unwrap_or_default();
        let step = ticks.get(1).map_or(1.0, |second| second - ticks[0]);
        let tick = |coordinate: f64| {
            let text = written(coordinate);
            let size = size_of(&text, em);
            Tick { coordinate, number: (coordinate / step).round() as i64, text, size }
        };
        Self { idx, unit, ticks: ticks.into_iter().map(tick).collect(), pixels, em }
    }

    /// Whether enough of an edge is in the picture for a scale.
    pub(super) fn has_ticks_on(&self, edge: &Edge, screen: &Screen) -> bool {
        2 <= self.ticks_on(edge, screen).len()
    }

    /// The coordinates that are in the picture, along an edge, and where.
    fn ticks_on(&self, edge: &Edge, screen: &Screen) -> Vec<(&Tick, DVec2)> {
        let is_seen = |at: &DVec2| at.cmpge(DVec2::ZERO).all() && at.cmple(screen.size()).all();
        let at = |tick: &Tick| {
            let mut point = edge.ends[0];
            point[self.idx] = tick.coordinate * self.unit.in_world;
            screen.point(point).filter(is_seen)
        };
        self.ticks.iter().filter_map(|tick| Some((tick, at(tick)?))).collect()
    }

    /// From a coordinate to the next.
    pub(super) fn step(&self) -> f64 {
        match &self.ticks[..] {
            [first, second, ..] => second.coordinate - first.coordinate,
            _ => 1.0,
        }
    }

    /// Every how many coordinates may be written: those whose steps are round again.
    fn strides(&self) -> [i64; 4] {
        let step = self.step();
        let leading = step / 10.0_f64.powf((step * (1.0 + 1e-9)).log10().floor());
        match leading.round() as i64 {
            2 => [1, 5, 10, 50],
            5 => [1, 2, 4, 10],
            _ => [1, 2, 5, 10],
        }
    }
}

impl<'a> Scale<'a> {
    /// `None` if fewer than two coordinates of the edge are in the picture, and apart.
    pub(super) fn of(axis: &'a Axis, edge: Edge, screen: &Screen, middle: DVec2) -> Option<Self> {
        let whole @ [from, to] = screen.line(edge.ends)?;
        let line = clipped(whole, DVec2::ZERO, screen.size())?;
        let across = (to - from).try_normalize()?.perp();
        let outwards = if 0.0 <= across.dot(from.midpoint(to) - middle) { across } else { -across };
        let widest = axis.ticks.iter().fold(DVec2::ZERO, |widest, tick| widest.max(tick.size));
        let ticks = axis.ticks_on(&edge, screen);
        let mut scale =
            Self { axis, line, outwards, ticks: Vec::new(), numbers: Vec::new(), widest };
        scale.ticks = ticks.iter().map(|(_, at)| *at).collect();
        let number = |(tick, at): &(&Tick, DVec2)| {
            let center = at + outwards * (GAP * axis.em + support(tick.size, outwards));
            Placed { text: tick.text.clone(), center, size: tick.size }.within(screen.size())
        };
        let of = |chosen: &dyn Fn(&Tick) -> bool| {
            let chosen = ticks.iter().filter(|(tick, _)| chosen(tick));
            let numbers: Vec<Placed> = chosen.map(&number).collect();
            let are_apart =
                numbers.windows(2).all(|pair| pair[0].is_apart(&pair[1], APART * axis.em));
            (2 <= numbers.len() && are_apart).then_some(numbers)
        };
        let ends = [ticks.first()?.0.number, ticks.last()?.0.number];
        let strides = axis.strides().into_iter();
        scale.numbers = strides
            .map(|stride| of(&|tick: &Tick| tick.number % stride == 0))
            .find(Option::is_some)
            .unwrap_or_else(|| of(&|tick: &Tick| ends.contains(&tick.number)))?;
        Some(scale)
    }

    /// Where what the coordinates are of may stand, the best first: upright edges have it at their upper end,
    /// others beyond the coordinates; where neither has room it is at whichever end has.
    pub(super) fn name_places(&self, name: &str, is_upright: bool) -> Vec<Placed> {
        let size = size_of(name, self.axis.em);
        let [from, to] = self.line;
        let beyond = (GAP + NAME_GAP) * self.axis.em
            + 2.0 * support(self.widest, self.outwards)
            + support(size, self.outwards);
        let beside =
            [0.5, 0.3, 0.7, 0.1, 0.9].map(|part| from.lerp(to, part) + self.outwards * beyond);
        let [lower, upper] = if to.y < from.y { [from, to] } else { [to, from] };
        let ends = [(upper, lower), (lower, upper)].map(|(end, other)| {
            let along = (end - other).normalize_or_zero();
            end + along * (0.75 * self.axis.em + support(size, along))
                + self.outwards * (GAP * self.axis.em + support(size, self.outwards))
        });
        let at_upper = is_upright.then_some(ends[0]);
        let placed = |center| Placed { text: name.to_owned(), center, size };
        at_upper.into_iter().chain(beside).chain(ends).map(placed).collect()
    }
}

impl Placed {
    pub(super) fn bounds(&self) -> [DVec2; 2] {
        [self.center - 0.5 * self.size, self.center + 0.5 * self.size]
    }

    /// Moved into a picture of that size, if it is not in it.
    pub(super) fn within(self, size: DVec2) -> Self {
        let half = 0.5 * self.size;
        let center = self.center.min(size - half).max(half);
        Self { center, ..self }
    }

    pub(super) fn is_apart(&self, other: &Self, gap: f64) -> bool {
        let between = (self.center - other.center).abs() - 0.5 * (self.size + other.size);
        // Above each other lines of text are apart as they are.
        gap <= between.x || 0.0 <= between.y
    }

    /// How far its middle is from a line.
    pub(super) fn distance_to(&self, [from, to]: Line) -> f64 {
        let along = to - from;
        let part = (self.center - from).dot(along) / along.length_squared();
        // Of a point, which has no direction, the quotient is NaN.
        let part = if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) };
        self.center.distance(from + along * part)
    }
}

/// How far a box reaches from its middle along a direction of length 1.
fn support(size: DVec2, way: DVec2) -> f64 {
    0.5 * size.dot(way.abs())
}

fn size_of(text: &str, em: f64) -> DVec2 {
    DVec2::from(measure_text(text, em as f32).map(f64::from))
}

/// An edge of the box by its middle, for what it is chosen by.
pub(super) fn middle_of(edge: &Edge, screen: &Screen) -> Option<DVec2> {
    screen.line(edge.ends).map(|[from, to]| from.midpoint(to))
}
