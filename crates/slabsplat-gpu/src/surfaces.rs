//! Where rays end at opaque meshes. The host finds it, by the crate that the CPU backend does, and anew only
//! if something changed.

use crate::surface_elements::{Element, SQUARE_SIDE, Square, SquareOfPixels, put_together};
use slabsplat_backend::{ColorSplats, FramePlan, MeshesPlan, Splats};
use slabsplat_core::SlabGrid;
use slabsplat_mesh::{Rasterizer, SeenMeshes};
use slabsplat_traverse::TileGrid;
use std::sync::Arc;

/// The surfaces of the last frame, and memory.
#[derive(Debug, Default)]
pub(crate) struct LastSurfaces {
    rasterizer: Rasterizer,
    surfaces: Option<Arc<Surfaces>>,
}

/// All surfaces of a frame.
#[derive(Debug)]
pub(crate) struct Surfaces {
    /// As the shaders read them.
    pub(crate) elements: Vec<Element>,
    made_of: (SeenMeshes, Sheets),
}

/// The sheets in which rays end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sheets {
    /// None if there are meshes alone.
    pub(crate) slabs: Option<SlabGrid>,
    /// Whether a slab can count in part.
    pub(crate) are_split: bool,
}

impl LastSurfaces {
    /// The surfaces of a plan, if it has meshes.
    pub(crate) fn of(&mut self, plan: &FramePlan<'_>) -> Option<Arc<Surfaces>> {
        let Some(meshes) = &plan.meshes else {
            *self = Self::default();
            return None;
        };
        let sheets = Sheets::of(plan);
        let is_same = |last: &Arc<Surfaces>| {
            let (seen, of_sheets) = &last.made_of;
            *of_sheets == sheets && seen.is_of(meshes)
        };
        if !self.surfaces.as_ref().is_some_and(is_same) {
            let elements = elements(meshes, &sheets, &mut self.rasterizer);
            let made_of = (SeenMeshes::of(meshes), sheets);
            self.surfaces = Some(Arc::new(Surfaces { elements, made_of }));
        }
        self.surfaces.clone()
    }
}

impl Sheets {
    fn of(plan: &FramePlan<'_>) -> Self {
        let slabs = plan.layers.first().and_then(|layer| match &layer.splats {
            Splats::Colors(ColorSplats::Sections(sections)) => Some(sections.slabs.grid),
            Splats::Colors(_) | Splats::Densities(_) => None,
        });
        Self { slabs, are_split: plan.compositing.sums_extinction() }
    }

    /// The sheet in which a depth lies, as many as there are if behind all of them, and what counts of it
    /// before that depth.
    pub(crate) fn at(&self, depth: f32) -> (u32, f32) {
        let Some(slabs) = &self.slabs else { return (0, 0.0) };
        let place = (f64::from(depth) - slabs.front(0)) / slabs.thickness();
        if place < 0.0 {
            return (0, 0.0);
        }
        if slabs.n_slabs() as f64 <= place {
            return (slabs.n_slabs() as u32, 0.0);
        }
        let share = place.fract();
        let counted = match self.are_split {
            true => share as f32,
            false if 0.5 < share => 1.0,
            false => 0.0,
        };
        (place as u32, counted)
    }
}

/// Rasterises in squares that are larger than a tile, as triangles are.
fn elements(plan: &MeshesPlan<'_>, sheets: &Sheets, rasterizer: &mut Rasterizer) -> Vec<Element> {
    let image_size = plan.view.image_size();
    let grid = TileGrid::new(image_size, SQUARE_SIDE, 0);
    let mut squares = Vec::new();
    squares.resize_with(grid.n_tiles(), Square::default);
    rasterizer.for_each_tile(plan, &grid, &mut squares, |square, hits| {
        let mut pixels = SquareOfPixels::default();
        hits.for_each_pixel(|pixel, hits| pixels.push(pixel, hits, sheets));
        *square = pixels.by_tile();
    });
    put_together(image_size, &squares)
}
