//! Where rays end at opaque meshes. The host finds it, by the crate that the CPU backend does, and anew only
//! if something changed.

use crate::frame_params::slabs_of;
use crate::surface_elements::{Element, SQUARE_SIDE, Square, SquareOfPixels, put_together};
use slabsplat_backend::{FramePlan, MeshesPlan, Splats};
use slabsplat_core::{Cancelled, FrameHandle, SlabGrid};
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
    /// Whether rays end in parts, from the middle of a sheet to that of the next, which densities composite.
    pub(crate) are_parts: bool,
}

/// A part of a ray is shown with the sheet that comes so many behind the one in whose middle it ends:
/// `N_SHEETS − 1 − SECOND` of `shaders/shared/sheets.wgsl`.
const SHEETS_BEHIND_PART: u32 = 2;

impl LastSurfaces {
    /// The surfaces of a plan, if it has meshes.
    pub(crate) fn of(
        &mut self,
        plan: &FramePlan<'_>,
        frame: &FrameHandle,
    ) -> Result<Option<Arc<Surfaces>>, Cancelled> {
        let Some(meshes) = &plan.meshes else {
            *self = Self::default();
            return Ok(None);
        };
        let sheets = Sheets::of(plan);
        let is_same = |last: &Arc<Surfaces>| {
            let (seen, of_sheets) = &last.made_of;
            *of_sheets == sheets && seen.is_of(meshes)
        };
        if !self.surfaces.as_ref().is_some_and(is_same) {
            let elements = elements((meshes, frame), &sheets, &mut self.rasterizer)?;
            let made_of = (SeenMeshes::of(meshes), sheets);
            self.surfaces = Some(Arc::new(Surfaces { elements, made_of }));
        }
        Ok(self.surfaces.clone())
    }
}

impl Sheets {
    fn of(plan: &FramePlan<'_>) -> Self {
        let splats = plan.layers.first().map(|layer| &layer.splats);
        Self {
            slabs: splats.and_then(slabs_of).map(|slabs| slabs.grid),
            are_split: plan.compositing.sums_extinction(),
            are_parts: matches!(splats, Some(Splats::Densities(_))),
        }
    }

    /// The sheet in which a depth lies, as many as there are if behind all of them, and what counts of it
    /// before that depth. Of densities the sheet with which the part is shown in which it lies.
    pub(crate) fn at(&self, depth: f32) -> (u32, f32) {
        let Some(slabs) = &self.slabs else { return (0, 0.0) };
        let position = (f64::from(depth) - slabs.front(0)) / slabs.thickness();
        let n_slabs = slabs.n_slabs();
        if !self.are_parts {
            return self.within(position, n_slabs);
        }
        // A part begins in the middle of a sheet, the first before all sheets and the last in the last one.
        let (part, counted) = self.within(position + 0.5, n_slabs + 1);
        (part + SHEETS_BEHIND_PART, counted)
    }

    /// Which of `n` on end holds a position, and what counts of it before that.
    fn within(&self, position: f64, n: usize) -> (u32, f32) {
        if position < 0.0 {
            return (0, 0.0);
        }
        if n as f64 <= position {
            return (n as u32, 0.0);
        }
        let share = position.fract();
        let counted = match self.are_split {
            true => share as f32,
            false if 0.5 < share => 1.0,
            false => 0.0,
        };
        (position as u32, counted)
    }
}

/// Rasterises in squares that are larger than a tile, as triangles are.
fn elements(
    frame: (&MeshesPlan<'_>, &FrameHandle),
    sheets: &Sheets,
    rasterizer: &mut Rasterizer,
) -> Result<Vec<Element>, Cancelled> {
    let image_size = frame.0.view.image_size();
    let grid = TileGrid::new(image_size, SQUARE_SIDE, 0);
    let mut squares = Vec::new();
    squares.resize_with(grid.n_tiles(), Square::default);
    rasterizer.for_each_tile(frame, &grid, &mut squares, |square, hits| {
        let mut pixels = SquareOfPixels::default();
        hits.for_each_pixel(|pixel, hits| pixels.push(pixel, hits, sheets));
        *square = pixels.by_tile();
    })?;
    Ok(put_together(image_size, &squares))
}
