//! The slabs of a frame as the image sees them: which of them a kernel meets, and the pixels that it covers
//! there.

use super::slab_shapes::SlabShapes;
use super::stage::Stage;
use crate::footprints::raster::{FootprintBounds, PixelShape, Raster};
use slabsplat_backend::{FramePlan, Slabs};
use slabsplat_core::SlabGrid;
use slabsplat_traverse::BrickBounds;

/// How thick a range of slabs is, in voxel steps: some three bricks. Thinner, and most voxels would wait for
/// another range; thicker, and more is taken in that turns out to be occluded.
const RANGE_THICKNESS: f64 = 32.0;

/// The same of volumes of more than so many voxels, of which a range takes hundreds of megabytes, and of
/// parts, which have a budget of memory.
const OF_LARGE: f64 = 16.0;
const LARGE: usize = 1 << 27;

/// Slabs, and the shapes of footprints in them.
pub(super) struct SlabView<'a> {
    pub(super) grid: &'a SlabGrid,
    pub(super) raster: &'a Raster,
    /// Of what else a brick may be drawn by: nothing's is wider.
    widest: Option<&'a Raster>,
    pub(super) shapes: &'a SlabShapes,
    /// The first slab whose sections are drawn.
    pub(super) first_drawn: usize,
    /// How many slabs before a slab the voxels may start whose sections it holds.
    pub(super) n_before: usize,
    /// How many slabs are gone through at a time.
    pub(super) n_per_range: usize,
}

impl<'a> SlabView<'a> {
    /// Those of a frame in which sheets have the sums of so many slabs.
    pub(super) fn new(
        slabs: &'a Slabs,
        stage: &Stage<'a>,
        shapes: &'a SlabShapes,
        at_once: usize,
    ) -> Self {
        let Stage { plan, raster, finest: (_, widest), .. } = *stage;
        let Slabs { grid, first_drawn, n_before, .. } = slabs;
        let n_per_range = (range_thickness(plan) / grid.thickness()) as usize;
        Self {
            grid,
            raster,
            widest: stage.has_finer().then_some(widest),
            shapes,
            first_drawn: *first_drawn,
            n_before: *n_before,
            n_per_range: n_per_range.clamp(1, grid.n_slabs()).next_multiple_of(at_once),
        }
    }

    /// The first and the last slab that the kernel of a voxel at that depth meets.
    #[inline]
    pub(super) fn meeting(&self, depth: f32) -> [usize; 2] {
        let half_depth = self.raster.half_depth;
        self.grid.meeting(f64::from(depth - half_depth), f64::from(depth + half_depth))
    }

    /// The footprint of a slab's sections.
    #[inline]
    pub(super) fn shape(&self, slab: usize) -> PixelShape {
        self.shapes.of(self.raster, self.grid, slab)
    }

    /// The pixels that sections of a brick's voxels, or of what it may be drawn by instead, may touch: the
    /// least and the largest corner; `None` if none of them is drawn.
    pub(super) fn bounds_of_brick(&self, bounds: &BrickBounds) -> Option<[[f32; 2]; 2]> {
        let BrickBounds { center, half_extents } = *bounds;
        let ends = [center[2] - half_extents[2], center[2] + half_extents[2]];
        let first = self.meeting(ends[0])[0].max(self.first_drawn);
        let last = self.meeting(ends[1])[1];
        if last < first {
            return None;
        }
        let corner = |sign: f32| [0, 1, 2].map(|axis| center[axis] + sign * half_extents[axis]);
        let shapes = [first, last].map(|slab| match self.widest {
            Some(widest) => widest.shape_at(self.grid.middle(slab)),
            None => self.shape(slab),
        });
        let raster = self.widest.unwrap_or(self.raster);
        let all = shapes.iter().flat_map(|shape| {
            [corner(-1.0), corner(1.0)].map(|point| raster.bounds(shape).at(point))
        });
        all.reduce(union)
    }

    /// The pixels that voxels' sections may touch, wherever they lie, if all slabs see one footprint and all
    /// are drawn.
    #[inline(always)]
    pub(super) fn bounds_in_all(&self) -> Option<FootprintBounds> {
        let only = self.shapes.only().filter(|_| self.first_drawn == 0);
        only.map(|only| self.raster.bounds(only))
    }

    /// The pixels that a voxel's sections may touch, of the slabs that its kernel meets: none if none of them
    /// is drawn. Their position and size change monotonically with their slabs' depth, so that the first and
    /// the last one bound all of them.
    #[inline(always)]
    pub(super) fn bounds_between(
        &self,
        [first, last]: [usize; 2],
        point: [f32; 3],
    ) -> Option<[[f32; 2]; 2]> {
        let first = first.max(self.first_drawn);
        if last < first {
            return None;
        }
        // A closure would not be compiled for the vectors of the caller.
        let (near, far) = (self.bounds_in(first).at(point), self.bounds_in(last).at(point));
        Some(union(near, far))
    }

    /// The pixels that sections in a slab may touch.
    #[inline(always)]
    fn bounds_in(&self, slab: usize) -> FootprintBounds {
        match self.shapes.cached(slab) {
            Some(shape) => self.raster.bounds(shape),
            None => self.raster.bounds(&self.shape(slab)),
        }
    }
}

/// The same in world units.
fn range_thickness(plan: &FramePlan<'_>) -> f64 {
    let n_voxels = plan.layers.iter().map(|layer| layer.volume.grid().n_voxels());
    let is_large = plan.part.is_some() || n_voxels.fold(0, usize::saturating_add) > LARGE;
    plan.least_unit() * if is_large { OF_LARGE } else { RANGE_THICKNESS }
}

/// The least rectangle around two.
#[inline(always)]
fn union([min, max]: [[f32; 2]; 2], [a, b]: [[f32; 2]; 2]) -> [[f32; 2]; 2] {
    [[a[0].min(min[0]), a[1].min(min[1])], [b[0].max(max[0]), b[1].max(max[1])]]
}
