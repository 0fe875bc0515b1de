//! Which samples a triangle covers, and how deep it is there.
//!
//! A sample is covered if it lies to the left of all three edges, or on them. On which side it lies is
//! exact, as numbers are: where rounding could tell another side, the predicate of Shewchuk ("Adaptive
//! Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997) is asked. So an edge has
//! just one place, whichever of its two triangles it belongs to.

use crate::samples::{SAMPLES, SampleSet};
use crate::vertices::Corner;
use robust::{Coord, orient2d};
use std::cmp::Ordering;

/// A triangle in the image that has an area, its corners the way round in which what is inside is left.
pub(crate) struct Coverage {
    /// Each from one corner to the next, the first opposite to the first corner.
    edges: [Edge; 3],
    /// Scales and depths of the corners.
    scales: [f64; 3],
    depths: [f64; 3],
}

/// A side of a triangle.
#[derive(Clone, Copy)]
struct Edge {
    start: [f64; 2],
    end: [f64; 2],
}

/// On which side of an edge all samples of a pixel are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Inside,
    Outside,
    Either,
}

/// A difference of products of differences is off by no more than this part of both products: by 4 roundings
/// each, and one of the difference.
const MAX_ERROR: f64 = 8.0 * f64::EPSILON;

impl Coverage {
    /// `None` if it is seen from the side.
    ///
    /// Corners are put into one order first: files have triangles twice, one for each side, and both must be
    /// equally deep to the last bit, or rounding would choose between their colours.
    pub(crate) fn new(corners: &[Corner; 3]) -> Option<Self> {
        let mut corners = corners.each_ref();
        let place = |corner: &Corner| [corner.at[0], corner.at[1], corner.point.z];
        corners.sort_by(|a, b| place(a).partial_cmp(&place(b)).unwrap_or(Ordering::Equal));
        let [a, b, c] = corners;
        let area = Edge { start: a.at, end: b.at }.exact(c.at);
        if area == 0.0 {
            return None;
        }
        let [a, b, c] = if area < 0.0 { [a, c, b] } else { [a, b, c] };
        let edge = |start: &Corner, end: &Corner| Edge { start: start.at, end: end.at };
        Some(Self {
            edges: [edge(b, c), edge(c, a), edge(a, b)],
            scales: [a.scale, b.scale, c.scale],
            depths: [a, b, c].map(|corner| corner.point.z),
        })
    }

    /// Calls `take` with each of these samples of a pixel that is covered, and its depth.
    #[inline]
    pub(crate) fn samples(
        &self,
        pixel: [f64; 2],
        of_pixel: SampleSet,
        mut take: impl FnMut(usize, f64),
    ) {
        let sides = self.edges.map(|edge| edge.side_of_pixel(pixel));
        if sides.contains(&Side::Outside) {
            return;
        }
        for sample in of_pixel.iter() {
            let place = SAMPLES[sample];
            let at = [pixel[0] + place[0], pixel[1] + place[1]];
            let mut weights = [0.0; 3];
            let mut is_covered = true;
            for ((edge, side), weight) in self.edges.iter().zip(sides).zip(&mut weights) {
                *weight = if side == Side::Inside { edge.rounded(at).0 } else { edge.left_by(at) };
                is_covered &= 0.0 <= *weight;
            }
            if is_covered {
                take(sample, self.depth(weights));
            }
        }
    }

    /// The depth where the triangle is divided into such areas, at most that of the farthest corner.
    fn depth(&self, weights: [f64; 3]) -> f64 {
        let [a, b, c] = [0, 1, 2].map(|corner| weights[corner] * self.scales[corner]);
        let [z_a, z_b, z_c] = self.depths;
        (a * z_a + b * z_b + c * z_c) / (a + b + c)
    }
}

impl Edge {
    /// How far a point lies to the left, times the edge's length, and how far off that may be.
    #[inline(always)]
    fn rounded(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let ([x0, y0], [x1, y1]) = (self.start, self.end);
        let (along, across) = ((x1 - x0) * (y - y0), (y1 - y0) * (x - x0));
        (along - across, MAX_ERROR * (along.abs() + across.abs()))
    }

    /// The same with the right sign, and 0 only on the edge.
    #[inline(always)]
    fn left_by(&self, at: [f64; 2]) -> f64 {
        let (left_by, error) = self.rounded(at);
        if error < left_by.abs() { left_by } else { self.exact(at) }
    }

    #[cold]
    fn exact(&self, at: [f64; 2]) -> f64 {
        let [start, end, at] = [self.start, self.end, at].map(|[x, y]| Coord { x, y });
        orient2d(start, end, at)
    }

    #[inline(always)]
    fn side_of_pixel(&self, pixel: [f64; 2]) -> Side {
        let (left_by, error) = self.rounded(pixel.map(|corner| corner + 0.5));
        let extent =
            0.5 * ((self.end[0] - self.start[0]).abs() + (self.end[1] - self.start[1]).abs());
        // The error elsewhere in the pixel is larger by that of what its extent adds.
        let sure = error + (1.0 + MAX_ERROR) * extent;
        match left_by {
            left_by if sure < left_by => Side::Inside,
            left_by if left_by < -sure => Side::Outside,
            _ => Side::Either,
        }
    }
}
