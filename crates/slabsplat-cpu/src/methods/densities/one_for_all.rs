//! What pixels show by the one density that stands for all on its ray (model §12).
//!
//! Until it is known, a tile's pixels hold what was found in their first two channels, a scaled density times
//! how much there is of it, and how much: 1 for the largest or the least, and for a mean the length that it
//! was taken over. The third is by how much it counts.

use crate::pixels::quad::QUAD;
use crate::pixels::tiles::Tiles;
use rayon::prelude::*;
use slabsplat_backend::densities::ValueScale;
use slabsplat_core::TransferFunction;

/// Makes pixels of what was found. The largest and the least densities were drawn to `worst` by how much less
/// than in full their sheets count, so that those which hold next to nothing are not the best; of what the
/// best one counts that is taken back, or the rim would have the colour of `worst`.
pub(super) fn classify(
    tiles: &mut Tiles,
    transfer: &TransferFunction,
    scale: &ValueScale,
    worst: Option<f32>,
) {
    let density = |found: f32, much: f32, counting: f32| {
        let [found, much, counting] = [found, much, counting].map(f64::from);
        match worst.map(f64::from) {
            Some(worst) => worst + (found - worst) / counting,
            None => found / much,
        }
    };
    tiles.tiles.par_iter_mut().for_each(|tile| {
        for quad in tile.pixels.iter_mut().flatten() {
            for pixel in 0..QUAD {
                let [found, much, counting, opacity] = quad.pixel(pixel);
                // Pixels that are not the tile's are opaque from the start.
                if opacity == 0.0 {
                    let shown = if 0.0 < much && 0.0 < counting {
                        let value = scale.value(density(found, much, counting));
                        shown(transfer, value).map(|channel| counting * channel)
                    } else {
                        [0.0; 4]
                    };
                    quad.set_pixel(pixel, shown);
                }
            }
        }
    });
}

/// Premultiplied colour and opacity of a density.
pub(super) fn shown(transfer: &TransferFunction, value: f64) -> [f32; 4] {
    let opacity = transfer.opacity(value);
    let [r, g, b] = transfer.color(value);
    [opacity * r, opacity * g, opacity * b, opacity].map(|channel| channel as f32)
}
