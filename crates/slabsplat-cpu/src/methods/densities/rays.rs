//! The rays of pixels: how they slant against the viewing direction.

use super::sheets::{Eight, LANES};
use slabsplat_core::View;

/// What a perspective view does to the way from one slab to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays {
    center: [f64; 2],
    /// World units to the right by which the ray of a pixel one further right has moved, over one world unit
    /// of depth; 0 where rays are parallel.
    pub(super) right_per_depth: f64,
}

impl Rays {
    /// For pixels that are counted from the corner of a border of that many.
    pub(super) fn new(view: &View, border: usize) -> Self {
        let right_per_depth = if view.is_perspective() {
            let near = view.near_depth();
            // Pixels grow in proportion to the distance from the eye.
            let twice_as_far = near + 1.0;
            1.0 / view.pixels_per_world(twice_as_far) - 1.0 / view.pixels_per_world(near)
        } else {
            0.0
        };
        Self {
            center: view.image_size().map(|side| 0.5 * f64::from(side) + border as f64),
            right_per_depth,
        }
    }

    /// The same of eight pixels from that one on.
    #[inline(always)]
    pub(super) fn slants(&self, [x, y]: [usize; 2]) -> [Eight; 2] {
        let mut slants = [[0.0; LANES]; 2];
        let [right, up] = &mut slants;
        for (lane, (right, up)) in right.iter_mut().zip(up).enumerate() {
            [*right, *up] = self.slant([x + lane, y]).map(|slant| slant as f32);
        }
        slants
    }

    /// World units to the right and upwards that a pixel's ray moves over one world unit of depth.
    #[inline(always)]
    pub(super) fn slant(&self, [x, y]: [usize; 2]) -> [f64; 2] {
        [
            (x as f64 + 0.5 - self.center[0]) * self.right_per_depth,
            (self.center[1] - y as f64 - 0.5) * self.right_per_depth,
        ]
    }
}
