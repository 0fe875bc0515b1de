//! Which cells are seen from a direction: those on whose rays enough is in the way of light.
//!
//! The cells' extinction is summed on a coarse picture of parallel rays. A cell in a pixel that stays nearly
//! clear is haze that nobody sees, and no reason to make what matters smaller.

use slabsplat_core::glam::DVec3;

use super::visible::{Cell, Cells};

/// Opacity of a pixel from which on it is seen.
const MIN_OPACITY: f64 = 0.08;

/// A pixel's side in cells: cells of one plane leave no pixel between them empty.
const PIXEL_CELLS: f64 = 1.5;

/// Pixels of a side of the coarse picture, at most.
const MAX_SIDE: f64 = 512.0;

/// Right, up and forward of a picture, each of length 1.
pub(super) type Axes = [DVec3; 3];

/// A cell as it is seen: its middle, and how far it reaches, to the right, upwards and forward.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) middle: DVec3,
    pub(super) reach: DVec3,
}

/// The cells that are seen along `axes`.
pub(super) fn seen(parts: &[Cells], axes: Axes) -> Vec<Seen> {
    let along = |v: DVec3| DVec3::from_array(axes.map(|axis| v.dot(axis)));
    let mut all = Vec::new();
    for part in parts {
        let reach = DVec3::from_array(axes.map(|axis| part.reach(axis)));
        all.extend(
            part.cells.iter().map(|cell| (Seen { middle: along(cell.middle), reach }, cell.weight)),
        );
    }
    let Some(picture) = Picture::of(&all, parts) else { return Vec::new() };
    all.retain(|(seen, _)| picture.is_seen(seen.middle));
    all.into_iter().map(|(seen, _)| seen).collect()
}

/// Optical depths of parallel rays.
struct Picture {
    origin: DVec3,
    pixel: f64,
    width: usize,
    depths: Vec<f64>,
}

impl Picture {
    /// `None` if there are no cells.
    fn of(cells: &[(Seen, f64)], parts: &[Cells]) -> Option<Self> {
        let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [min, max] = cells
            .iter()
            .fold(nothing, |[min, max], (seen, _)| [min.min(seen.middle), max.max(seen.middle)]);
        let span = max - min;
        let with_cells = parts.iter().filter(|part| !part.cells.is_empty());
        let largest = with_cells.map(Cells::size).reduce(f64::max)?;
        let pixel = (PIXEL_CELLS * largest).max(span.x.max(span.y) / MAX_SIDE);
        let pixel = pixel.max(f64::MIN_POSITIVE);
        let [width, height] = [span.x, span.y].map(|span| (span / pixel) as usize + 1);
        let mut picture = Self { origin: min, pixel, width, depths: vec![0.0; width * height] };
        for (seen, weight) in cells {
            let pixel_idx = picture.pixel_of(seen.middle);
            picture.depths[pixel_idx] += weight / pixel / pixel;
        }
        Some(picture)
    }

    fn pixel_of(&self, at: DVec3) -> usize {
        let [x, y] = [0, 1].map(|axis| ((at[axis] - self.origin[axis]) / self.pixel) as usize);
        y * self.width + x
    }

    fn is_seen(&self, at: DVec3) -> bool {
        MIN_OPACITY <= 1.0 - (-self.depths[self.pixel_of(at)]).exp()
    }
}

/// The sum of the cells' weights in either half of a direction, and all of them; used to tell which way up a
/// thing stands.
pub(super) fn weights(cells: &[Cell], is_in: impl Fn(DVec3) -> bool) -> f64 {
    let weights = cells.iter().filter(|cell| is_in(cell.middle)).map(|cell| cell.weight);
    weights.filter(|weight| weight.is_finite()).sum()
}
