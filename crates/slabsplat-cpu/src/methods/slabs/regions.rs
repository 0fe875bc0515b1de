//! The regions of a frame's layers, and the part of it that is drawn, on every tile.

use crate::pixels::blocks::Blocks;
use crate::pixels::tile_region::{ConvexSet, TileRegion};
use crate::pixels::tiles::Tiles;
use rayon::prelude::*;
use slabsplat_backend::{FramePlan, LayerPlan};
use slabsplat_core::View;

/// Made to be used again.
#[derive(Debug, Default)]
pub(super) struct Regions {
    /// Of each group of layers that have one region, on each tile; nothing if that is everywhere.
    groups: Vec<Vec<TileRegion>>,
    /// The group of each layer.
    group_of: Vec<usize>,
    /// The part of the frame that is drawn, on each tile; nothing if that is all of it.
    part: Vec<TileRegion>,
}

/// The regions of all layers, on one tile.
#[derive(Clone, Copy)]
pub(in crate::methods) struct RegionsOnTile<'a> {
    regions: &'a Regions,
    tile_idx: usize,
}

impl Regions {
    /// Makes them those of a frame, and closes what none of them shows of its empty tiles.
    pub(super) fn update<'a>(
        &mut self,
        plan: &FramePlan<'_>,
        layers: impl Iterator<Item = &'a LayerPlan<'a>>,
        splits_slabs: bool,
        tiles: &mut Tiles,
    ) {
        let Self { groups, group_of, part } = self;
        group_of.clear();
        let mut last = None;
        for layer in layers {
            let region = &layer.region;
            if last == Some(region) {
                group_of.extend(group_of.last().copied());
                continue;
            }
            last = Some(region);
            let group = group_of.last().map_or(0, |group| group + 1);
            group_of.push(group);
            groups.resize_with(groups.len().max(group + 1), Vec::new);
            let set = region.as_ref().map(ConvexSet::Region);
            make(&mut groups[group], set, (&layer.view, splits_slabs), tiles);
        }
        let view = plan.layers.first().map(|layer| &layer.view);
        if let Some(view) = view {
            let set = plan.part.as_ref().map(ConvexSet::Part);
            make(part, set, (view, splits_slabs), tiles);
        }
        let n_groups = group_of.last().map_or(0, |group| group + 1);
        groups.truncate(n_groups);
        for (tile_idx, tile) in tiles.tiles.iter_mut().enumerate() {
            tile.close_all(self.on_tile(tile_idx).over_from(f32::NEG_INFINITY));
        }
    }

    pub(super) fn on_tile(&self, tile_idx: usize) -> RegionsOnTile<'_> {
        RegionsOnTile { regions: self, tile_idx }
    }

    pub(super) fn resident_bytes(&self) -> usize {
        let n_regions = self.groups.iter().map(Vec::capacity).sum::<usize>();
        (n_regions + self.part.capacity()) * TileRegion::BYTES
    }
}

impl<'a> RegionsOnTile<'a> {
    /// Where a layer is seen; `None` if that is everywhere.
    #[inline]
    pub(in crate::methods) fn of(&self, layer: usize) -> Option<&'a TileRegion> {
        self.regions.groups[self.regions.group_of[layer]].get(self.tile_idx)
    }

    /// The part of the frame that is drawn; `None` if that is all of it.
    #[inline]
    pub(in crate::methods) fn part(&self) -> Option<&'a TileRegion> {
        self.regions.part.get(self.tile_idx)
    }

    /// Whether any pixel may have a share of a slab in the part. Not block by block: where footprints are
    /// separable, those of voxels in a block have a little to say in others, as they do in the whole.
    #[inline]
    pub(in crate::methods) fn part_shows(&self, faces: [f32; 2]) -> bool {
        self.part().is_none_or(|part| !part.showing(faces).is_empty())
    }

    /// Whether the next layer has the same, so that their sums are cut at once.
    #[inline]
    pub(in crate::methods) fn is_that_of_next(&self, layer: usize) -> bool {
        let group_of = &self.regions.group_of;
        group_of.get(layer + 1) == Some(&group_of[layer])
    }

    /// Whether all layers have the same.
    #[inline]
    pub(in crate::methods) fn is_only(&self) -> bool {
        self.regions.groups.len() == 1
    }

    /// The blocks in which nothing is seen behind a depth, as the part or all regions end before.
    #[inline]
    pub(super) fn over_from(&self, depth: f32) -> Blocks {
        if self.part().is_some_and(|part| part.over_from(depth) == Blocks::ALL) {
            return Blocks::ALL;
        }
        self.all_over_from(depth)
    }

    /// The same of all regions.
    #[inline]
    fn all_over_from(&self, depth: f32) -> Blocks {
        let mut over = Blocks::ALL;
        for group in &self.regions.groups {
            let Some(region) = group.get(self.tile_idx) else { return Blocks::NONE };
            over = over.and(region.over_from(depth));
        }
        over
    }
}

/// Makes a region, or a part, on each tile; none if it is everywhere.
fn make(
    of_tiles: &mut Vec<TileRegion>,
    set: Option<ConvexSet<'_>>,
    (view, splits_slabs): (&View, bool),
    tiles: &Tiles,
) {
    let Some(set) = set else { return of_tiles.clear() };
    let border = tiles.grid.border() as i64;
    of_tiles.resize_with(tiles.tiles.len(), TileRegion::default);
    of_tiles.par_iter_mut().zip(&tiles.tiles).for_each(|(of_tile, tile)| {
        let corner = tile.origin.map(|pixel| pixel as i64 - border);
        of_tile.update(&set, view, corner, splits_slabs);
    });
}
