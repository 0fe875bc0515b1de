//! The footprint of every slab: sections are projected at their slab's middle depth (paper §3.2, end).

use crate::footprints::raster::{PixelShape, Raster};
use crate::separable::slab::SeparableSlab;
use slabsplat_core::{SlabGrid, View};
use slabsplat_kernel::{FootprintShape, SeparableSections, SeparableShapes};

/// What a frame's slabs look like; made once a frame.
#[derive(Clone, Debug, Default)]
pub(super) struct SlabShapes {
    /// One for each slab, or a single one if they are all alike; none if there are too many.
    shapes: Vec<PixelShape>,
    /// How separable footprints are drawn there, if they are: whole ones, and what slabs cut; as many as
    /// shapes, or none.
    separable: Vec<[Option<SeparableSlab>; 2]>,
}

/// Most slabs whose shapes are cached: half a megabyte.
const MAX_KEPT: usize = 1 << 13;

impl SlabShapes {
    /// Makes them those of a frame.
    pub(super) fn update(
        &mut self,
        raster: &Raster,
        view: &View,
        slabs: &SlabGrid,
        separable: Option<(&SeparableSections, &SeparableShapes)>,
    ) {
        let n_shapes = match slabs.n_slabs() {
            n_slabs if !view.is_perspective() => n_slabs.min(1),
            n_slabs if n_slabs <= MAX_KEPT => n_slabs,
            _ => 0,
        };
        self.shapes.clear();
        self.shapes.extend((0..n_shapes).map(|slab| raster.shape_at(slabs.middle(slab))));
        self.separable.clear();
        if let Some((sections, shapes)) = separable {
            let of_slab =
                |slab: usize| separable_slab(raster, slabs.middle(slab), sections, shapes);
            self.separable.extend((0..n_shapes).map(of_slab));
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

    /// How separable footprints are drawn in a slab, if they are: whole ones, and what it cuts.
    #[inline]
    pub(super) fn separable(&self, slab: usize) -> [Option<&SeparableSlab>; 2] {
        let idx = if self.separable.len() == 1 { 0 } else { slab };
        self.separable.get(idx).map_or([None; 2], |slab| slab.each_ref().map(Option::as_ref))
    }

    /// Most quads of coefficients that any slab has on a tile.
    pub(super) fn n_coefficients(&self) -> usize {
        let slabs = self.separable.iter().flatten().flatten();
        slabs.map(SeparableSlab::n_quads).max().unwrap_or(0)
    }

    /// The footprint of a slab; of no meaning for one that is not drawn.
    #[inline]
    pub(super) fn of(&self, raster: &Raster, slabs: &SlabGrid, slab: usize) -> PixelShape {
        self.cached(slab).copied().unwrap_or_else(|| raster.shape_at(slabs.middle(slab)))
    }

    /// The same, unless there are too many slabs.
    #[inline(always)]
    pub(super) fn cached(&self, slab: usize) -> Option<&PixelShape> {
        match self.shapes.as_slice() {
            [only] => Some(only),
            shapes => shapes.get(slab),
        }
    }
}

/// Whole footprints at a depth, and what slabs cut.
fn separable_slab(
    raster: &Raster,
    depth: f64,
    sections: &SeparableSections,
    shapes: &SeparableShapes,
) -> [Option<SeparableSlab>; 2] {
    let of = |shape: &FootprintShape, gain: f64| {
        let pixels = raster.shape_like(shape, depth);
        SeparableSlab::new(pixels, gain as f32, shape.is_sheared(), sections)
    };
    [of(&shapes.whole, 1.0), of(&shapes.cut, shapes.cut_gain)]
}
