//! The triangles, lines and points of a frame, on every tile.

use crate::elements::{Element, Frame, Numbers, OfMesh};
use crate::tile::{Hit, TileHits};
use crate::vertices::{Vertex, project};
use rayon::prelude::*;
use slabsplat_backend::MeshesPlan;
use slabsplat_core::{Cancelled, FrameHandle, View};
use slabsplat_traverse::{
    PixelRect, TileBuckets, TileGrid, TileRect, Workspaces, resize_for_frame,
};

/// Where the vertices and elements of a frame's meshes are. Made to be used again.
#[derive(Debug, Default)]
pub struct Rasterizer {
    /// Of all meshes.
    vertices: Vec<Vertex>,
    meshes: Vec<OfMesh>,
    buckets: TileBuckets,
    workspaces: Workspaces<TileHits>,
}

/// The hits on a tile, to be found.
#[derive(Debug)]
pub struct HitsOnTile<'a> {
    frame: &'a Frame<'a>,
    elements: &'a TileBuckets,
    tile_idx: usize,
    pixels: PixelRect,
    hits: &'a mut TileHits,
    handle: &'a FrameHandle,
}

impl Rasterizer {
    /// Rasterises the meshes of a plan: calls `work` for every tile, in parallel, with the target that is the
    /// tile's.
    ///
    /// # Errors
    /// If the frame is cancelled; what targets were given is then of no meaning.
    ///
    /// # Panics
    /// If there are more than 2³² triangles, lines and points.
    pub fn for_each_tile<T: Send>(
        &mut self,
        (plan, handle): (&MeshesPlan<'_>, &FrameHandle),
        tiles: &TileGrid,
        targets: &mut [T],
        work: impl Fn(&mut T, HitsOnTile<'_>) + Sync,
    ) -> Result<(), Cancelled> {
        self.start((plan, handle), tiles)?;
        let Self { vertices, meshes, buckets: elements, workspaces } = self;
        let frame = Frame { plan, vertices, meshes };
        let image_size = plan.view.image_size();
        let workspaces = workspaces.for_all_threads();
        let targets = targets.par_iter_mut().enumerate().with_max_len(1);
        targets.for_each(|(tile_idx, target)| {
            let min = tiles.origin(tile_idx).map(|pixel| pixel as u32);
            let end = [0, 1].map(|axis| (min[axis] + tiles.step()).min(image_size[axis]));
            let (pixels, hits) = (PixelRect { min, end }, &mut *workspaces.of_this_thread());
            if !handle.is_cancelled() {
                work(
                    target,
                    HitsOnTile { frame: &frame, elements, tile_idx, pixels, hits, handle },
                );
            }
        });
        handle.check()
    }

    /// Projects the vertices of a frame, and tosses its elements onto tiles.
    fn start(
        &mut self,
        (plan, handle): (&MeshesPlan<'_>, &FrameHandle),
        tiles: &TileGrid,
    ) -> Result<(), Cancelled> {
        let Self { vertices, meshes, buckets, .. } = self;
        meshes.clear();
        let Numbers { n_vertices, n_elements } = OfMesh::append(plan, meshes);
        assert!(u32::try_from(n_elements).is_ok(), "a frame has up to 2³² triangles");
        resize_for_frame(vertices, n_vertices, handle)?;
        for (of_mesh, OfMesh { first_vertex, .. }) in plan.meshes.iter().zip(&*meshes) {
            let n_own = of_mesh.layer.mesh.positions().len();
            project((plan, handle), of_mesh, &mut vertices[*first_vertex..][..n_own]);
        }
        handle.check()?;
        let frame = Frame { plan, vertices, meshes };
        let tiles_of = |idx| tiles_of(&frame.element(idx as u32), &plan.view, tiles);
        buckets.toss(tiles, n_elements, tiles_of, handle)
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        self.vertices.capacity() * size_of::<Vertex>()
            + self.buckets.resident_bytes()
            + self.workspaces.sum_of(TileHits::resident_bytes)
    }
}

impl HitsOnTile<'_> {
    /// Calls `take` with each of the tile's own pixels that is hit, counted from the first column and row,
    /// and with its hits, at most [`N_SAMPLES`](crate::N_SAMPLES) and the nearest first.
    pub fn for_each_pixel(self, take: impl FnMut([usize; 2], &[Hit])) {
        let Self { frame, hits, handle, .. } = self;
        let mut elements = self.elements.on_tile(self.tile_idx).peekable();
        if elements.peek().is_none() {
            return;
        }
        hits.start(&self.pixels);
        for element in elements {
            if handle.is_cancelled() {
                return;
            }
            hits.add(frame, element as u32);
        }
        hits.finish(frame, take);
    }
}

/// The tiles on which an element may lie.
fn tiles_of(element: &Element<'_>, view: &View, tiles: &TileGrid) -> TileRect {
    let Some([min, max]) = element.bounds(view) else { return TileRect::EMPTY };
    let size = view.image_size();
    let border = tiles.border() as u32;
    let mut pixels = PixelRect { min: [0; 2], end: [0; 2] };
    for axis in 0..2 {
        // Casts saturate.
        let end = ((max[axis] + 1.0).max(0.0) as u32).min(size[axis]);
        let first = min[axis].max(0.0) as u32;
        if end <= first {
            return TileRect::EMPTY;
        }
        (pixels.min[axis], pixels.end[axis]) = (first + border, end + border);
    }
    tiles.tiles_of(&pixels)
}
