//! The regions of a frame's layers, on every tile.

use super::stage::Stage;
use crate::pixels::blocks::Blocks;
use crate::pixels::tile_region::TileRegion;
use crate::pixels::tiles::Tiles;
use rayon::prelude::*;

/// Made to be used again.
#[derive(Debug, Default)]
pub(super) struct Regions {
    /// Of each group of layers that have one region, on each tile; nothing if that is everywhere.
    groups: Vec<Vec<TileRegion>>,
    /// The group of each layer.
    group_of: Vec<usize>,
}

/// A layer's region.
#[derive(Clone, Copy)]
pub(super) struct OfRegion<'a> {
    /// On each tile; `None` if it is everywhere.
    pub(super) tiles: Option<&'a [TileRegion]>,
    /// Whether the next layer has the same, so that their sums are cut at once.
    pub(super) is_that_of_next: bool,
    /// Whether all layers have the same.
    pub(super) is_only: bool,
}

impl Regions {
    /// Makes them those of a frame, and closes what none of them shows of its empty tiles.
    pub(super) fn update<'a>(
        &mut self,
        stages: impl Iterator<Item = &'a Stage<'a>>,
        splits_slabs: bool,
        tiles: &mut Tiles,
    ) {
        let Self { groups, group_of } = self;
        group_of.clear();
        let mut last = None;
        for stage in stages {
            let region = &stage.layer.region;
            if last == Some(region) {
                group_of.extend(group_of.last().copied());
                continue;
            }
            last = Some(region);
            let group = group_of.last().map_or(0, |group| group + 1);
            group_of.push(group);
            groups.resize_with(groups.len().max(group + 1), Vec::new);
            make(&mut groups[group], stage, splits_slabs, tiles);
        }
        let n_groups = group_of.last().map_or(0, |group| group + 1);
        groups.truncate(n_groups);
        if groups.iter().all(|tiles| !tiles.is_empty()) {
            for (tile_idx, tile) in tiles.tiles.iter_mut().enumerate() {
                let over = groups.iter().map(|group| group[tile_idx].over_from(f32::NEG_INFINITY));
                if let Some(over) = over.reduce(Blocks::and) {
                    tile.close_all(over);
                }
            }
        }
    }

    /// In the order of the layers.
    pub(super) fn of_layers(&self) -> impl Iterator<Item = OfRegion<'_>> {
        let Self { groups, group_of } = self;
        group_of.iter().enumerate().map(|(layer, &group)| OfRegion {
            tiles: (!groups[group].is_empty()).then_some(&*groups[group]),
            is_that_of_next: group_of.get(layer + 1) == Some(&group),
            is_only: groups.len() == 1,
        })
    }

    pub(super) fn resident_bytes(&self) -> usize {
        self.groups.iter().map(Vec::capacity).sum::<usize>() * TileRegion::BYTES
    }
}

/// Makes the region of a layer on each tile; none if it is everywhere.
fn make(of_tiles: &mut Vec<TileRegion>, stage: &Stage<'_>, splits_slabs: bool, tiles: &Tiles) {
    let Some(region) = &stage.layer.region else { return of_tiles.clear() };
    let border = tiles.grid.border() as i64;
    of_tiles.resize_with(tiles.tiles.len(), TileRegion::default);
    of_tiles.par_iter_mut().zip(&tiles.tiles).for_each(|(of_tile, tile)| {
        let corner = tile.origin.map(|pixel| pixel as i64 - border);
        of_tile.update(region, &stage.layer.view, corner, splits_slabs);
    });
}
