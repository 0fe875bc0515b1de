//! A layer where pixels are larger than voxels (model §16): bricks of voxels or of cells, made when they are
//! seen.
//!
//! ```text
//! from the coarsest level on:
//!     bricks that lie far enough away for the level, and whose parents do not, are drawn by it
//!     of these, what is no longer occluded when its slabs come is made (slabsplat-traverse), and if it has
//!     more contrast than the plan allows, its children are drawn by the next level instead
//! ```
//!
//! 1. Sheets sum extinction, and colour times extinction. Such sums are made of voxels first, which gives the
//!    same sum, and one footprint goes for all of a cell.
//! 2. What a cell holds depends on neither the view nor the light, and serves until the transfer function
//!    changes.
//! 3. What is occluded is never made.
//! 4. Cells are lit by means of their voxels' normals, once for many voxels.

use super::Stage;
use super::lit_faces::LitFaces;
use super::slabs::{BrickVoxels, ReadRoom, Voxels};
use crate::footprints::raster::Raster;
use crate::voxels::relevant::OnDemand;
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;
use slabsplat_backend::{CellsPlan, LayerPlan};
use slabsplat_core::glam::DVec3;
use slabsplat_kernel::{CellDifferences, ShareByCells};
use slabsplat_traverse::{
    Brick, BrickBounds, BrickMaker, BrickView, BricksOnDemand, CellBrick, Cells16, VoxelRecord,
};

/// A level of a layer, as the view sees it.
pub(super) struct SeenLevel<'a> {
    pub(super) plan: &'a LayerPlan<'a>,
    pub(super) raster: Raster,
    pub(super) bricks: BrickView,
    /// What may be drawn of it; everything of voxels.
    cells: Option<&'a CellsPlan<'a>>,
    /// The share of its bricks that may be, if that is the same at all depths: in parallel rays.
    everywhere: Option<ShareByCells>,
}

/// The bricks of a level.
pub(super) struct LevelVoxels<'a> {
    stage: &'a Stage<'a>,
    on_demand: &'a OnDemand<'a>,
    level: u32,
    seen: &'a SeenLevel<'a>,
    coarser: Option<&'a SeenLevel<'a>>,
    faces: Option<LitFaces<'a>>,
}

impl<'a> SeenLevel<'a> {
    /// All levels of a layer, voxels first.
    pub(super) fn all(layer: &'a LayerPlan<'a>) -> Vec<Self> {
        let seen = |plan: &'a LayerPlan<'a>, cells: Option<&'a CellsPlan<'a>>| Self {
            plan,
            raster: Raster::new(plan, 0),
            bricks: BrickView::of_cells(plan.volume.grid(), plan.level, &plan.grid(), &plan.view),
            cells,
            everywhere: cells.filter(|_| !plan.view.is_perspective()).map(|c| c.share_at(0.0)),
        };
        let cells = layer.cells().map(|cells| seen(&cells.plan, Some(cells)));
        std::iter::once(seen(layer, None)).chain(cells).collect()
    }

    /// Whether a brick lies where this level may be drawn.
    fn reaches(&self, brick_idx: u32, bricks: &BricksOnDemand) -> bool {
        let Some(cells) = self.cells else { return true };
        let share = self.everywhere.unwrap_or_else(|| {
            let bounds = self.bricks.bounds(&whole(brick_idx));
            let front = f64::from(bounds.center[2] - bounds.half_extents[2]);
            cells.share_at(front - self.plan.half_depth)
        });
        let is_at_end = bricks.is_at_end(self.plan.level, brick_idx);
        share.includes(self.bricks.grid().coords_in_whole(brick_idx), is_at_end)
    }

    /// Whether all bricks do.
    fn reaches_everything(&self) -> bool {
        self.everywhere.is_some_and(|share| share.is_all())
    }
}

/// A brick, whatever it holds.
fn whole(brick_idx: u32) -> Brick {
    Brick { brick_idx, first: 0, n_voxels: 0 }
}

impl<'a> LevelVoxels<'a> {
    /// Those of one of the levels of a layer.
    pub(super) fn new(
        stage: &'a Stage<'a>,
        on_demand: &'a OnDemand<'a>,
        levels: &'a [SeenLevel<'a>],
        level: usize,
    ) -> Self {
        Self {
            stage,
            on_demand,
            level: level as u32,
            seen: &levels[level],
            coarser: levels.get(level + 1),
            faces: LitFaces::of(stage.layer),
        }
    }

    fn maker(&self) -> BrickMaker<'_> {
        let Stage { lighting, frame, .. } = self.stage;
        let OnDemand { lister, moments_from, .. } = self.on_demand;
        BrickMaker { lister, lighting, moments_from: *moments_from, frame }
    }

    /// Whether a brick is drawn by this level as far as its depth is concerned.
    fn is_of_this_level(&self, brick_idx: u32) -> bool {
        let bricks = self.on_demand.bricks;
        let parent = || bricks.parent(self.level, brick_idx);
        self.seen.reaches(brick_idx, bricks)
            && !self.coarser.is_some_and(|seen| seen.reaches(parent(), bricks))
    }

    /// Whether cells are alike enough, and faint enough, to stand for their voxels.
    fn allows(&self, cells: &CellBrick) -> bool {
        let differences = CellDifferences {
            contrast: cells.contrast(),
            spread: cells.spread(),
            spread_of_extinction: cells.spread_of_extinction(),
            noise: cells.noise(),
            extinction: cells.largest_of_voxels(),
        };
        self.seen.cells.is_none_or(|CellsPlan { limits, lit, .. }| limits.allow(*lit, &differences))
    }

    /// Whether a brick may lie where the light of a lit face begins or ends, which cells would blur.
    fn is_near_lit_face(&self, brick: &Brick) -> bool {
        self.faces.as_ref().is_some_and(|faces| {
            let BrickBounds { center, half_extents } = self.seen.bricks.bounds(brick);
            let [center, half_extents] =
                [center, half_extents].map(|v| DVec3::from_array(v.map(f64::from)));
            faces.may_be_in(center, half_extents)
        })
    }

    /// Colours cells of a brick: extinction times what light makes of them, and extinction.
    #[inline(always)]
    fn color_cells(&self, cells: &CellBrick, records: &[VoxelRecord], colors: &mut [[f32; 4]]) {
        let light = self.stage.lighting.light();
        for (records, colors) in records.chunks(Cells16::N).zip(colors.chunks_mut(Cells16::N)) {
            let cells = Cells16::of(cells, records);
            // A closure would not be compiled for the vectors of this function.
            let [r, g, b] = match light {
                None => cells.colors,
                Some(light) => light.on_cells(&cells),
            };
            let mut weighted = [[0.0; 4]; Cells16::N];
            for i in 0..Cells16::N {
                let mu = cells.extinctions[i];
                weighted[i] = [mu * r[i], mu * g[i], mu * b[i], mu];
            }
            colors.copy_from_slice(&weighted[..colors.len()]);
        }
    }
}

impl Voxels for LevelVoxels<'_> {
    fn n_voxels(&self) -> u64 {
        if self.level == 0 { self.on_demand.bricks.n_voxels() } else { 0 }
    }

    fn bricks(&self, range_of: &(dyn Fn(&Brick) -> u32 + Sync), into: &mut Vec<(u32, u32)>) {
        let OnDemand { bricks, lister, .. } = self.on_demand;
        into.clear();
        // In parallel rays mostly all are of the coarsest level.
        if self.coarser.is_some_and(SeenLevel::reaches_everything) {
            return;
        }
        let here = bricks
            .may_hold(self.level, lister)
            .par_iter()
            .filter(|idx| self.is_of_this_level(**idx));
        into.par_extend(here.map(|&idx| (range_of(&whole(idx)), idx)));
    }

    fn brick(&self, key: u32) -> Brick {
        whole(key)
    }

    fn read<'a>(&'a self, brick: &Brick, room: &'a mut ReadRoom) -> Option<BrickVoxels<'a>> {
        let bricks = self.on_demand.bricks;
        let ReadRoom { made, records } = room;
        if self.level == 0 {
            return Some(BrickVoxels::new(bricks.voxels(self.maker(), brick.brick_idx, records)));
        }
        if self.is_near_lit_face(brick) {
            return None;
        }
        let cells = bricks.cells(self.maker(), self.level, brick.brick_idx, made);
        if !self.allows(cells) {
            return None;
        }
        records.clear();
        records.extend(cells.slots());
        Some(BrickVoxels { records, n_voxels: cells.n_voxels(), cells: Some(cells) })
    }

    fn finer<'a>(&'a self, key: u32) -> Box<dyn Iterator<Item = u32> + 'a> {
        Box::new(self.on_demand.bricks.children(self.level, key, &self.on_demand.lister))
    }

    fn color(
        &self,
        brick: &Brick,
        read: &BrickVoxels<'_>,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        let Some(cells) = read.cells else {
            let faces = self.faces.as_ref();
            return self.stage.color(faces, brick, records, colors);
        };
        dispatch!(self.stage.level, simd => simd.vectorize(
            #[inline(always)]
            || self.color_cells(cells, records, colors),
        ));
    }
}
