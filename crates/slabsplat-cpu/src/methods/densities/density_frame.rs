//! What the stages of a frame of densities share.

use super::classify::Classifier;
use super::gradient::Spacing;
use super::rays::Rays;
use super::values::ValueScale;
use super::voxel::DensityVoxel;
use crate::footprints::raster::Raster;
use slabsplat_backend::{DensitySplats, FramePlan, Slabs};
use slabsplat_kernel::CubicSectionTable;
use slabsplat_traverse::{TileGrid, TileRect};

/// Pixels around a tile that are summed with it.
const BORDER: f32 = 1.0;

/// A gradient counts in full from this part of the range of values on, per `unit`: less is the noise of a
/// plateau, and a normal must not turn about within it.
const FAINT_GRADIENT: f64 = 1.0 / 256.0;

/// A frame that is about to be drawn.
pub(super) struct DensityFrame<'a> {
    pub(super) plan: &'a FramePlan<'a>,
    pub(super) slabs: &'a Slabs,
    pub(super) table: &'a CubicSectionTable,
    pub(super) raster: Raster,
    pub(super) rays: Rays,
    pub(super) scale: ValueScale,
    pub(super) classifier: Classifier<'a>,
    /// Of a gradient, see [`FAINT_GRADIENT`]; scaled, per world unit.
    pub(super) faint: f64,
}

impl<'a> DensityFrame<'a> {
    /// A frame of a volume whose finite values are of that range, if there are any.
    pub(super) fn new(
        plan: &'a FramePlan<'a>,
        DensitySplats { slabs, table }: &'a DensitySplats,
        finite: Option<[f64; 2]>,
    ) -> Self {
        let scale = ValueScale::new(finite, plan.transfer);
        let range = finite.map_or(0.0, |range| scale.extent(range));
        Self {
            plan,
            slabs,
            table,
            raster: Raster::new(plan),
            rays: Rays::new(&plan.view),
            scale,
            classifier: Classifier::new(plan, scale),
            // Never 0, which a gradient of 0 would be divided by.
            faint: (FAINT_GRADIENT * range / plan.volume.grid().unit()).max(f64::MIN_POSITIVE),
        }
    }

    /// The first and the last slab that the kernel of a voxel meets.
    #[inline]
    pub(super) fn slabs_of(&self, voxel: &DensityVoxel) -> [usize; 2] {
        let (depth, half_depth) = (voxel.point[2], self.raster.half_depth);
        self.slabs.grid.meeting(f64::from(depth - half_depth), f64::from(depth + half_depth))
    }

    /// The tiles on which a voxel's sections fall, or beside which: in the border that is summed with them. A
    /// section's place and size change monotonically with its slab's depth, so that the first and the last
    /// bound all of them.
    pub(super) fn tiles_of(&self, voxel: &DensityVoxel, tiles: &TileGrid) -> TileRect {
        let [first, last] = self.slabs_of(voxel);
        let first = first.max(self.slabs.first_drawn);
        if last < first {
            return TileRect::EMPTY;
        }
        let [near, far] = [first, last].map(|slab| {
            let shape = self.raster.shape_at(self.slabs.grid.middle(slab));
            self.raster.bounds(&shape, voxel.point)
        });
        let min = [0, 1].map(|axis| near[0][axis].min(far[0][axis]) - BORDER);
        let max = [0, 1].map(|axis| near[1][axis].max(far[1][axis]) + BORDER);
        let pixels = tiles.pixels_within(min, max);
        pixels.map_or(TileRect::EMPTY, |pixels| tiles.tiles_of(&pixels))
    }

    /// How far the neighbours of a slab's pixels are apart.
    pub(super) fn spacing_at(&self, slab: usize) -> Spacing {
        let grid = &self.slabs.grid;
        Spacing {
            pixel: 1.0 / self.plan.view.pixels_per_world(grid.middle(slab)),
            slab: grid.thickness(),
            lean: [0.0; 2],
            faint: self.faint,
        }
    }
}
