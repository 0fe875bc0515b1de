//! The hits of a tile's samples.

use crate::clip::{Polygon, bounds_of, is_behind_near};
use crate::coverage::Coverage;
use crate::elements::{Element, Frame};
use crate::samples::{N_SAMPLES, SAMPLES, SampleSet};
use crate::surface::Surface;
use crate::tube::Tube;
use crate::vertices::Corner;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{RegionInView, ViewRay};
use slabsplat_traverse::PixelRect;
use std::ops::Range;

/// Where the ray of a sample ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hit {
    /// In world units, from the centre of what is seen.
    pub depth: f32,
    /// Lit.
    pub color: [f32; 3],
}

/// The nearest hits of the samples of a rectangle of pixels. Made to be used again.
#[derive(Debug, Default)]
pub(crate) struct TileHits {
    left: u32,
    top: u32,
    n_columns: usize,
    /// Of each sample, pixel by pixel, row by row.
    nearest: Vec<Nearest>,
    /// The element whose colour was found last, and that, if it has one alone.
    last: Option<(u32, [f32; 3])>,
}

/// What a sample hits first: a depth, and what is there.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    depth: f64,
    element: u32,
}

const NOTHING: Nearest = Nearest { depth: f64::INFINITY, element: 0 };

impl TileHits {
    /// Makes it that of some pixels, of which nothing is hit.
    pub(crate) fn start(&mut self, pixels: &PixelRect) {
        let [n_columns, n_rows] = [0, 1].map(|axis| (pixels.end[axis] - pixels.min[axis]) as usize);
        (self.left, self.top, self.n_columns) = (pixels.min[0], pixels.min[1], n_columns);
        self.nearest.clear();
        self.nearest.resize(n_columns * n_rows * N_SAMPLES, NOTHING);
        self.last = None;
    }

    /// Adds what is hit of an element.
    pub(crate) fn add(&mut self, frame: &Frame<'_>, element: u32) {
        match frame.element(element) {
            Element::Triangle(surface) => self.add_triangle(frame, element, &surface),
            Element::Tube(tube) => self.add_tube(frame, element, &tube),
        }
    }

    fn add_triangle(&mut self, frame: &Frame<'_>, element: u32, surface: &Surface<'_>) {
        let corners = surface.vertices.map(|vertex| vertex.corner);
        let region = surface.of_mesh.region.as_ref();
        let view = &frame.plan.view;
        if is_behind_near(&corners, view) {
            return self.add_piece(frame, (element, region), &corners);
        }
        for piece in Polygon::behind_near(corners, view).triangles() {
            self.add_piece(frame, (element, region), &piece);
        }
    }

    fn add_piece(
        &mut self,
        frame: &Frame<'_>,
        (element, region): (u32, Option<&RegionInView>),
        corners: &[Corner; 3],
    ) {
        let Some(bounds) = bounds_of(corners) else { return };
        let [columns, rows] = self.pixels_within(bounds);
        let mut coverage = None;
        for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
            let pixel = [self.left + column as u32, self.top + row as u32];
            let samples = SampleSet::within(bounds, pixel.map(f64::from));
            if samples.is_empty() {
                continue;
            }
            // Many a small triangle lies between samples, and needs no more.
            let Some(coverage) = coverage.get_or_insert_with(|| Coverage::new(corners)) else {
                return;
            };
            let first = (row * self.n_columns + column) * N_SAMPLES;
            coverage.samples(pixel.map(f64::from), samples, |sample, depth| {
                let ray = || ray(frame, pixel, sample);
                let is_there = || region.is_none_or(|region| holds(region, point(&ray(), depth)));
                let nearest = &mut self.nearest[first + sample];
                if depth <= nearest.depth && is_there() {
                    nearest.replace(Nearest { depth, element }, frame, ray);
                }
            });
        }
    }

    fn add_tube(&mut self, frame: &Frame<'_>, element: u32, tube: &Tube<'_>) {
        let view = &frame.plan.view;
        let Some(bounds) = tube.shape.bounds(view) else { return };
        let band = tube.shape.band(view);
        let [columns, rows] = self.pixels_within(bounds);
        for row in rows {
            let top = f64::from(self.top + row as u32);
            let Some([first, last]) =
                band.map_or(Some([bounds[0][0], bounds[1][0]]), |it| it.in_row(top))
            else {
                continue;
            };
            let narrowed = self.columns_within([first, last]);
            for column in narrowed.start.max(columns.start)..narrowed.end.min(columns.end) {
                self.add_tube_to_pixel(frame, (element, tube, bounds), [column, row]);
            }
        }
    }

    fn add_tube_to_pixel(
        &mut self,
        frame: &Frame<'_>,
        (element, tube, bounds): (u32, &Tube<'_>, [[f64; 2]; 2]),
        [column, row]: [usize; 2],
    ) {
        let pixel = [self.left + column as u32, self.top + row as u32];
        let near = frame.plan.view.near_depth();
        let region = tube.of_mesh.region.as_ref();
        let first = (row * self.n_columns + column) * N_SAMPLES;
        for sample in SampleSet::within(bounds, pixel.map(f64::from)).iter() {
            let ray = ray(frame, pixel, sample);
            let Some(depths) = tube.shape.met_by(&ray) else { continue };
            let is_there = |depth: &f64| {
                let is_in_region = |region| holds(region, point(&ray, *depth));
                near <= *depth && region.is_none_or(is_in_region)
            };
            let Some(depth) = depths.into_iter().find(is_there) else { continue };
            let nearest = &mut self.nearest[first + sample];
            if depth <= nearest.depth {
                nearest.replace(Nearest { depth, element }, frame, || ray);
            }
        }
    }

    /// The columns and the rows whose samples may lie within bounds, from the first.
    fn pixels_within(&self, [min, max]: [[f64; 2]; 2]) -> [Range<usize>; 2] {
        let n_rows = self.nearest.len() / N_SAMPLES / self.n_columns.max(1);
        [self.columns_within([min[0], max[0]]), range_within([min[1], max[1]], self.top, n_rows)]
    }

    fn columns_within(&self, ends: [f64; 2]) -> Range<usize> {
        range_within(ends, self.left, self.n_columns)
    }

    /// Calls `take` with each pixel that is hit, from the first column and row, and its hits, nearest first.
    pub(crate) fn finish(&mut self, frame: &Frame<'_>, mut take: impl FnMut([usize; 2], &[Hit])) {
        let Self { left, top, n_columns, nearest, last } = self;
        let mut hits = [Hit::default(); N_SAMPLES];
        for (idx, nearest) in nearest.chunks_exact(N_SAMPLES).enumerate() {
            let [column, row] = [idx % *n_columns, idx / *n_columns];
            let pixel = [*left + column as u32, *top + row as u32];
            let mut n_hits = 0;
            for (sample, nearest) in nearest.iter().enumerate() {
                if nearest.depth == f64::INFINITY {
                    continue;
                }
                let color = match last {
                    Some((element, color)) if *element == nearest.element => *color,
                    _ => {
                        let color = nearest.color(frame, &ray(frame, pixel, sample));
                        let is_even = frame.element(nearest.element).is_even();
                        *last = is_even.then_some((nearest.element, color));
                        color
                    }
                };
                hits[n_hits] = Hit { depth: nearest.depth as f32, color };
                n_hits += 1;
            }
            if 0 < n_hits {
                let hits = &mut hits[..n_hits];
                hits.sort_by(|a, b| a.depth.total_cmp(&b.depth));
                take([column, row], hits);
            }
        }
    }

    /// Bytes held.
    pub(crate) fn resident_bytes(&self) -> usize {
        self.nearest.capacity() * size_of::<Nearest>()
    }
}

impl Nearest {
    /// Takes another hit that is not behind it: one before it, or at the same depth that of the lesser
    /// colour.
    fn replace(&mut self, other: Self, frame: &Frame<'_>, ray: impl Fn() -> ViewRay) {
        let color = |hit: &Self| hit.color(frame, &ray());
        if other.depth < self.depth || color(&other) < color(self) {
            *self = other;
        }
    }

    fn color(&self, frame: &Frame<'_>, ray: &ViewRay) -> [f32; 3] {
        frame.element(self.element).color(ray, self.depth, &frame.plan.view)
    }
}

/// The pixels along an axis, from the first of so many, whose samples may lie between two places.
fn range_within([min, max]: [f64; 2], first: u32, n: usize) -> Range<usize> {
    let [min, max] = [min, max].map(|place| place - f64::from(first));
    // Casts saturate.
    (min.max(0.0) as usize).min(n)..((max + 1.0).max(0.0) as usize).min(n)
}

fn ray(frame: &Frame<'_>, pixel: [u32; 2], sample: usize) -> ViewRay {
    frame.plan.view.ray([0, 1].map(|axis| f64::from(pixel[axis]) + SAMPLES[sample][axis]))
}

fn point(ray: &ViewRay, depth: f64) -> DVec3 {
    ray.start + depth * ray.step
}

fn holds(region: &RegionInView, point: DVec3) -> bool {
    let is_behind = region.planes().iter().all(|plane| plane.normal.dot(point) <= plane.distance);
    is_behind != region.is_inverted()
}
