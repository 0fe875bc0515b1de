//! The footprint of every slab: sections are projected at their slab's middle depth (paper §3.2, end).

use crate::footprints::raster::{PixelShape, Raster};
use crate::separable::b_spline::RowSpline;
use slabsplat_core::{SlabGrid, View};
use slabsplat_kernel::SeparableSections;

/// What a frame's slabs look like; made once a frame.
#[derive(Clone, Debug, Default)]
pub(super) struct SlabShapes {
    /// One for each slab, or a single one if they are all alike; none if there are too many.
    shapes: Vec<PixelShape>,
    /// How separable footprints are splatted there; as many as shapes, or none.
    splines: Vec<Option<RowSpline>>,
}

/// Most slabs whose shapes are kept: half a megabyte.
const MAX_KEPT: usize = 1 << 13;

impl SlabShapes {
    /// Makes them those of a frame.
    pub(super) fn update(
        &mut self,
        raster: &Raster,
        view: &View,
        slabs: &SlabGrid,
        separable: Option<&SeparableSections>,
    ) {
        let n_shapes = match slabs.n_slabs() {
            n_slabs if !view.is_perspective() => n_slabs.min(1),
            n_slabs if n_slabs <= MAX_KEPT => n_slabs,
            _ => 0,
        };
        self.shapes.clear();
        self.shapes.extend((0..n_shapes).map(|slab| raster.shape_at(slabs.middle(slab))));
        self.splines.clear();
        if let Some(separable) = separable {
            self.splines.extend(self.shapes.iter().map(|shape| RowSpline::new(shape, separable)));
        }
    }

    /// The footprint of all slabs, if they have the same.
    #[inline]
    pub(super) fn only(&self) -> Option<&PixelShape> {
        match self.shapes.as_slice() {
            [only] => Some(only),
            _ => None,
        }
    }

    /// How separable footprints are splatted in a slab, if they are.
    #[inline]
    pub(super) fn spline(&self, slab: usize) -> Option<&RowSpline> {
        let idx = if self.splines.len() == 1 { 0 } else { slab };
        self.splines.get(idx)?.as_ref()
    }

    /// Most rows of coefficients that any slab has on a tile.
    pub(super) fn n_coefficient_rows(&self) -> usize {
        self.splines.iter().flatten().map(RowSpline::n_rows).max().unwrap_or(0)
    }

    /// The footprint of a slab; of no meaning for one that is not drawn.
    #[inline]
    pub(super) fn of(&self, raster: &Raster, slabs: &SlabGrid, slab: usize) -> PixelShape {
        match self.shapes.as_slice() {
            [only] => *only,
            [] => raster.shape_at(slabs.middle(slab)),
            shapes => shapes[slab],
        }
    }
}
