//! How rays end at opaque surfaces on their way through the slabs of a tile (model §14).
//!
//! ```text
//! of a pixel: n of its 8 rays are left, and 1 − opacity is what goes through all 8 together
//! for each ray that ends within the slab:
//!     color += (1 − opacity)/n · (what of the slab lies before the surface, and then the surface)
//! for the others: the whole slab
//! opacity = 1 − what goes through the others
//! ```
//!
//! So a pixel has one opacity, whatever part of it a surface covers, and a slab in which none of its rays
//! ends is composited as if there were no surfaces. A pixel whose rays have all ended is as opaque as can be.

use super::blocks::{BLOCK_SIDE, BLOCKS_ACROSS};
use super::quad::QUAD;
use super::sheet::Sheet;
use super::tile::Tile;
use slabsplat_core::Compositing;
use slabsplat_mesh::Hit;

/// What a slab is to rays that end in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlabToEndIn {
    pub(crate) compositing: Compositing,
    /// The depths of its faces.
    pub(crate) faces: [f32; 2],
    /// Opacity from which a pixel is saturated.
    pub(crate) cutoff: f32,
}

/// What is added to a pixel, for each of its rays what goes through it.
struct Added {
    color: [f64; 3],
    /// What continues behind.
    through: f64,
}

impl Tile {
    /// Ends rays at surfaces before a depth, where nothing is left to be composited before that.
    #[inline(always)]
    pub(crate) fn end_rays_before(&mut self, depth: f32, cutoff: f32) {
        if self.surfaces.any_before(depth) {
            self.end_rays(depth, cutoff, |_, ended, n_left| {
                let mut color = [0.0; 3];
                ended.iter().for_each(|hit| add(&mut color, 1.0, hit.color.map(f64::from)));
                Added { color, through: n_left as f64 }
            });
        }
    }

    /// Composites a slab at the pixels of which rays end in it, or before it, and takes it from their sheet.
    #[inline(always)]
    pub(crate) fn end_rays_in(&mut self, slab: SlabToEndIn, sheet: &mut Sheet) {
        if self.surfaces.any_before(slab.faces[1]) {
            self.end_rays(slab.faces[1], slab.cutoff, |[column, row], ended, n_left| {
                let quad = &mut sheet.sums[row][column / QUAD];
                let sums = quad.pixel(column % QUAD);
                quad.set_pixel(column % QUAD, [0.0; 4]);
                slab.composited(sums.map(f64::from), ended, n_left)
            });
        }
    }

    /// A function of its own: most tiles of most slabs have nothing to end.
    #[inline(never)]
    fn end_rays(
        &mut self,
        depth: f32,
        cutoff: f32,
        mut composited: impl FnMut([usize; 2], &[Hit], usize) -> Added,
    ) {
        let all = (0..BLOCKS_ACROSS).flat_map(|row| (0..BLOCKS_ACROSS).map(move |c| [c, row]));
        for block in all {
            if !self.surfaces.any_in_block_before(block, depth) {
                continue;
            }
            let [first_column, first_row] = block.map(|it| it * BLOCK_SIDE);
            for row in first_row..first_row + BLOCK_SIDE {
                for column in first_column..first_column + BLOCK_SIDE {
                    let (n_rays, ended) = self.surfaces.come_to([column, row], depth);
                    if ended.is_empty() {
                        continue;
                    }
                    let n_left = n_rays - ended.len();
                    let Added { color, through } = composited([column, row], ended, n_left);
                    let quad = &mut self.pixels[row][column / QUAD];
                    let [r, g, b, opacity] = quad.pixel(column % QUAD).map(f64::from);
                    let of_ray = (1.0 - opacity) / n_rays as f64;
                    let mut pixel = [r, g, b];
                    add(&mut pixel, of_ray, color);
                    let [r, g, b] = pixel.map(|channel| channel as f32);
                    // Exactly 1 if none is left, whatever was rounded.
                    quad.set_pixel(column % QUAD, [r, g, b, (1.0 - of_ray * through) as f32]);
                }
            }
            self.surfaces.note_next(block);
            self.close_if_saturated(block, cutoff);
        }
        self.surfaces.note_next_of_all();
    }
}

impl SlabToEndIn {
    fn composited(&self, sums: [f64; 4], ended: &[Hit], n_left: usize) -> Added {
        let mut added = Added { color: [0.0; 3], through: 0.0 };
        for hit in ended {
            let share = f64::from(self.share_before(hit.depth));
            let [r, g, b, opacity] = self.compositing.resolve(sums.map(|sum| share * sum));
            add(&mut added.color, 1.0, [r, g, b]);
            add(&mut added.color, 1.0 - opacity, hit.color.map(f64::from));
        }
        let [r, g, b, opacity] = self.compositing.resolve(sums);
        add(&mut added.color, n_left as f64, [r, g, b]);
        added.through = n_left as f64 * (1.0 - opacity);
        added
    }

    /// What part of it lies before a depth that is not behind it.
    fn share_before(&self, depth: f32) -> f32 {
        let [front, back] = self.faces;
        if self.compositing.sums_extinction() {
            ((depth - front) / (back - front)).max(0.0)
        } else if 0.5 * (front + back) < depth {
            1.0
        } else {
            0.0
        }
    }
}

fn add(sum: &mut [f64; 3], weight: f64, color: [f64; 3]) {
    for (sum, channel) in sum.iter_mut().zip(color) {
        *sum += weight * channel;
    }
}
