//! Layers that are shown by one density each (model §12), one after the other: none hides another.
//!
//! ```text
//! for each layer:
//!     the largest, or the least, of what sheets hold                 (extremes.rs)
//!     or the mean: by whole footprints, where these are enough       (means.rs, grazed.rs)
//!                  by sheets elsewhere
//!     its colour and opacity                                         (one_for_all.rs)
//! join what came of all layers                                       (joined.rs)
//! ```

use super::extremes::Extremes;
use super::grazed::ParallelRays;
use super::joined::JoinedLayers;
use super::layer_to_draw::LayerToDraw;
use super::means::{Means, WholeMeans};
use super::one_for_all::classify;
use super::rings::{Rings, Scratch};
use super::saturation::Saturation;
use crate::methods::slabs::{self, render_one};
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use fearless_simd::Level;
use slabsplat_backend::FramePlan;
use slabsplat_core::{Cancelled, Statistic};

/// Draws layers by the density that stands for all of each.
#[derive(Clone, Copy)]
pub(super) struct OneByOne<'a> {
    pub(super) plan: &'a FramePlan<'a>,
    pub(super) level: Level,
    pub(super) statistic: Statistic,
}

/// A layer, and its index among how many.
#[derive(Clone, Copy)]
struct Turn<'a> {
    layer: &'a LayerToDraw<'a>,
    nth: (usize, usize),
}

type SlabBuffers = slabs::Buffers<Rings, Scratch>;

impl OneByOne<'_> {
    /// Draws onto empty tiles; returns how many voxels were never tossed, being occluded.
    pub(super) fn draw(
        self,
        layers: &[LayerToDraw<'_>],
        tiles: &mut Tiles,
        (slabs, joined): (&mut SlabBuffers, &mut JoinedLayers),
        watch: &mut Stopwatch<'_>,
    ) -> Result<u64, Cancelled> {
        let are_several = 1 < layers.len();
        if are_several {
            joined.clear(tiles);
        }
        let mut n_occluded = 0;
        for (idx, layer) in layers.iter().enumerate() {
            let turn = Turn { layer, nth: (idx, layers.len()) };
            let up = match self.statistic {
                Statistic::Maximum => Some(1.0),
                Statistic::Minimum => Some(-1.0),
                Statistic::Average => None,
            };
            let worst = layer.scale.worst(self.statistic, &layer.layer.relevant);
            let up_from = up.map(|up| (up, worst));
            n_occluded += match up_from {
                Some(up_from) => self.find_extremes(turn, up_from, tiles, slabs, watch)?,
                None => self.take_means(turn, tiles, slabs, watch)?,
            };
            let worst = up_from.map(|(_, worst)| worst);
            classify(tiles, layer.layer.transfer, &layer.scale, worst);
            if are_several {
                joined.add(tiles);
                tiles.reopen();
            }
        }
        if are_several {
            joined.put(tiles);
        }
        Ok(n_occluded)
    }

    /// The largest densities, if `up` is 1; the least, if it is −1.
    fn find_extremes(
        self,
        Turn { layer, nth }: Turn<'_>,
        (up, worst): (f32, f32),
        tiles: &mut Tiles,
        slabs: &mut SlabBuffers,
        watch: &mut Stopwatch<'_>,
    ) -> Result<u64, Cancelled> {
        let extremes = Extremes {
            up,
            worst,
            per_rise: (1.0 / layer.scale.rise()) as f32,
            saturation: Saturation::new(layer.layer.transfer, &layer.scale, up.into()),
            slabs: &layer.splats.slabs.grid,
            limits: layer.limits,
            per_full_length: layer.per_full_length(),
        };
        let in_slabs = layer.in_slabs(self.plan, self.level);
        render_one(in_slabs, nth, &extremes, tiles, slabs, watch)
    }

    /// By whole footprints, and by sheets where these are not enough.
    fn take_means(
        self,
        Turn { layer, nth }: Turn<'_>,
        tiles: &mut Tiles,
        slabs: &mut SlabBuffers,
        watch: &mut Stopwatch<'_>,
    ) -> Result<u64, Cancelled> {
        let grid = &layer.splats.slabs.grid;
        let mut n_occluded = None;
        if let Some(in_slabs) = layer.whole_in_slabs(self.plan, self.level) {
            n_occluded = Some(render_one(in_slabs, nth, &WholeMeans, tiles, slabs, watch)?);
            ParallelRays::new(layer.layer, grid).settle(&layer.limits, tiles);
        }
        let (limits, per_full_length) = (layer.limits, layer.per_full_length());
        let means = Means { slabs: grid, limits, per_full_length };
        let in_slabs = layer.in_slabs(self.plan, self.level);
        let n_not_needed = render_one(in_slabs, nth, &means, tiles, slabs, watch)?;
        Ok(n_occluded.unwrap_or(n_not_needed))
    }
}
