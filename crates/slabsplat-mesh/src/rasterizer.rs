//! The triangles of a frame, on every tile.

use crate::clip::{Polygon, bounds_of, is_behind_near};
use crate::surface::Surface;
use crate::tile::{Hit, TileHits};
use crate::vertices::{Vertex, project};
use rayon::prelude::*;
use slabsplat_backend::{MeshPlan, MeshesPlan};
use slabsplat_core::glam::DMat3;
use slabsplat_core::{Cancelled, FrameHandle};
use slabsplat_traverse::{
    PixelRect, TileBuckets, TileGrid, TileRect, Workspaces, resize_for_frame,
};

/// Where the vertices and triangles of a frame's meshes are. Made to be used again.
#[derive(Debug, Default)]
pub struct Rasterizer {
    /// Of all meshes.
    vertices: Vec<Vertex>,
    /// The first vertex and the first triangle of each mesh, and where the last ones end.
    firsts: Vec<[usize; 2]>,
    /// What takes the normals of each mesh to the world.
    world_from_normals: Vec<DMat3>,
    buckets: TileBuckets,
    workspaces: Workspaces<TileHits>,
}

/// A frame whose vertices are projected.
#[derive(Debug)]
pub(crate) struct Frame<'a> {
    pub(crate) plan: &'a MeshesPlan<'a>,
    vertices: &'a [Vertex],
    firsts: &'a [[usize; 2]],
    world_from_normals: &'a [DMat3],
}

/// The hits on a tile, to be found.
#[derive(Debug)]
pub struct HitsOnTile<'a> {
    frame: &'a Frame<'a>,
    triangles: &'a TileBuckets,
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
    /// If there are more than 2³² triangles.
    pub fn for_each_tile<T: Send>(
        &mut self,
        (plan, handle): (&MeshesPlan<'_>, &FrameHandle),
        tiles: &TileGrid,
        targets: &mut [T],
        work: impl Fn(&mut T, HitsOnTile<'_>) + Sync,
    ) -> Result<(), Cancelled> {
        self.start((plan, handle), tiles)?;
        let Self { vertices, firsts, world_from_normals, buckets: triangles, workspaces } = self;
        let frame = Frame { plan, vertices, firsts, world_from_normals };
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
                    HitsOnTile { frame: &frame, triangles, tile_idx, pixels, hits, handle },
                );
            }
        });
        handle.check()
    }

    /// Projects the vertices of a frame, and tosses its triangles onto tiles.
    fn start(
        &mut self,
        (plan, handle): (&MeshesPlan<'_>, &FrameHandle),
        tiles: &TileGrid,
    ) -> Result<(), Cancelled> {
        let Self { vertices, firsts, world_from_normals, buckets, .. } = self;
        let world_from_normal =
            |of_mesh: &MeshPlan<'_>| of_mesh.layer.world_from_mesh().matrix3.inverse().transpose();
        world_from_normals.clear();
        world_from_normals.extend(plan.meshes.iter().map(world_from_normal));
        let mut ends = [0, 0];
        firsts.clear();
        firsts.push(ends);
        for of_mesh in &plan.meshes {
            let mesh = &of_mesh.layer.mesh;
            ends[0] += mesh.positions().len();
            ends[1] += mesh.triangles().len();
            firsts.push(ends);
        }
        let [n_vertices, n_triangles] = ends;
        assert!(u32::try_from(n_triangles).is_ok(), "a frame has up to 2³² triangles");
        resize_for_frame(vertices, n_vertices, handle)?;
        for (of_mesh, of_all) in plan.meshes.iter().zip(firsts.windows(2)) {
            project((plan, handle), of_mesh, &mut vertices[of_all[0][0]..of_all[1][0]]);
        }
        handle.check()?;
        let frame = Frame { plan, vertices, firsts, world_from_normals };
        let tiles_of = |triangle| frame.tiles_of(triangle as u32, tiles);
        buckets.toss(tiles, n_triangles, tiles_of, handle)
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
        let mut triangles = self.triangles.on_tile(self.tile_idx).peekable();
        if triangles.peek().is_none() {
            return;
        }
        hits.start(&self.pixels);
        for triangle in triangles {
            if handle.is_cancelled() {
                return;
            }
            hits.add(frame, triangle as u32);
        }
        hits.finish(frame, take);
    }
}

impl<'a> Frame<'a> {
    /// A triangle by its number among those of all meshes.
    pub(crate) fn surface(&self, triangle: u32) -> Surface<'a> {
        let triangle = triangle as usize;
        let mesh_idx = self.firsts.partition_point(|first| first[1] <= triangle) - 1;
        let [first_vertex, first_triangle] = self.firsts[mesh_idx];
        let of_mesh = &self.plan.meshes[mesh_idx];
        let triangle = triangle - first_triangle;
        let vertices = of_mesh.layer.mesh.triangles()[triangle]
            .map(|vertex| &self.vertices[first_vertex + vertex as usize]);
        let world_from_normal = &self.world_from_normals[mesh_idx];
        Surface { of_mesh, triangle, vertices, world_from_normal }
    }

    /// The tiles on which a triangle may lie.
    fn tiles_of(&self, triangle: u32, tiles: &TileGrid) -> TileRect {
        let (corners, view) =
            (self.surface(triangle).vertices.map(|vertex| vertex.corner), &self.plan.view);
        let bounds = if is_behind_near(&corners, view) {
            bounds_of(&corners)
        } else {
            bounds_of(Polygon::behind_near(corners, view).corners())
        };
        let Some([min, max]) = bounds else { return TileRect::EMPTY };
        let size = self.plan.view.image_size();
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
}
