//! How large boxes may be within a budget of memory.

use super::painter::CPU;
use super::refine::MOST_GROUPS;
use super::shares::Shares;
use super::{DividedDesc, DividedError};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Camera, Grid, ImageDesc, Layer, PartBox, PartSupport, PartTree, Scene, View};
use std::ops::Range;
use thiserror::Error;

/// The memory is too little to draw anything.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "{} of memory are too few to draw a picture of this size box by box: it takes {}",
    in_mib(*.memory_bytes),
    in_mib(*.needed_bytes)
)]
#[non_exhaustive]
pub struct NoRoom {
    /// What there is.
    pub memory_bytes: u64,
    /// What it takes at least.
    pub needed_bytes: u64,
}

/// Rounded up, as what is needed has to suffice.
fn in_mib(n_bytes: u64) -> String {
    format!("{} MiB", n_bytes.div_ceil(1 << 20))
}

/// What boxes may take.
pub(super) struct Budget {
    memory_bytes: u64,
    /// What there is beside them and threads.
    shared_bytes: u64,
    n_threads: usize,
    /// Of the picture.
    n_tiles: usize,
    camera: Camera,
    is_refined: bool,
    listing: Listing,
    /// Whether there is as much as the smallest boxes need, as nobody said how much there is.
    grows: bool,
}

/// How those who draw have the relevant voxels of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Listing {
    /// The CPU makes bricks of them when they are seen, and retains none.
    BrickByBrick,
    /// For a GPU the host lists all of them.
    All,
}

/// The program and its tables.
const OF_PROGRAM: u64 = 40 << 20;

/// A thread's stack, its tile's sheets, what it takes in at once, and what its allocator retains of that:
/// measured, 15 MiB with glibc's.
const OF_THREAD: u64 = 16 << 20;

/// What threads may take of all that is there for them and for voxels: one of so many parts.
const OF_THREADS: u64 = 2;

/// A picture that is drawn, what is in front of it, tiles, and where their rays are in a part and in regions.
const OF_PIXEL: u64 = 112;

/// Of a picture that is shown while others are made: what is behind it, of each group of boxes, what it is
/// made of, and what becomes of it.
const OF_REFINED_PIXEL: u64 = 4 * MOST_GROUPS as u64 + 3 * 16;

/// Of a voxel that is listed: its record, if it is relevant, and its brick's.
const OF_LISTED_VOXEL: u64 = 9;

/// The same of one that may be drawn as part of a cell: its share of cells, also of such as may not stand
/// for it.
const OF_LISTED_CELLS: u64 = 3;

/// So many voxels take a byte for what is known of their bricks, which is 128 bytes of each.
const PER_BYTE_OF_BRICKS: u64 = 4;

/// Of a voxel in the range of depth that is drawn: projected and shaded, and on its tiles.
const OF_VOXEL_IN_RANGE: u64 = 72;

/// Of such a voxel on a tile that a thread draws: it sorts all that are there.
const OF_VOXEL_ON_TILE: u64 = 36;

/// Pixels along a side of a tile.
const TILE_SIDE: f64 = 32.0;

/// How many voxel steps are in such a range, what waits for the next one included.
const IN_RANGE: u64 = 27;

/// The part of what is there for voxels that chunks have which several boxes meet: of a box of 264³ voxels a
/// side of chunks of 64³ is a fortieth.
const OF_CHUNKS: u64 = 8;

/// What a share has for voxels, at least.
const OF_SHARE: u64 = 64 << 20;

/// The least side of a box.
const LEAST_SIDE: usize = 8;

/// The part of what is read before it and behind it that a side of a box is, at least: of boxes whose sides
/// are half of that, 125 times as much is read as they have.
const OF_SIDE: f64 = 2.0;

impl Budget {
    pub(super) fn new(
        scene: &Scene,
        image: &ImageDesc,
        (desc, backend): (&DividedDesc, &str),
    ) -> Result<Self, DividedError> {
        let &DividedDesc { memory_bytes, is_refined, .. } = desc;
        let listing = Listing::by(backend);
        let mut shared_bytes = shared_bytes(scene, image);
        let mut needed_bytes = shared_bytes + OF_THREAD;
        if is_refined {
            shared_bytes += OF_REFINED_PIXEL * image.n_pixels() as u64;
            // Overviews are drawn before the first box is.
            needed_bytes = shared_bytes + OF_THREAD + of_overviews(scene, listing);
        }
        if memory_bytes <= needed_bytes {
            return Err(NoRoom { memory_bytes, needed_bytes }.into());
        }
        let n_paid_for = (memory_bytes - shared_bytes) / OF_THREADS / OF_THREAD;
        let n_threads = rayon::current_num_threads().min(n_paid_for as usize).max(1);
        Ok(Self {
            memory_bytes,
            shared_bytes,
            n_threads,
            n_tiles: n_tiles(image),
            camera: scene.camera,
            is_refined,
            listing,
            grows: false,
        })
    }

    /// Of one of so many who share a scene, whose volumes are on those grids: as large as its part of them
    /// takes, or as the smallest boxes do.
    pub(super) fn of_share(
        scene: &Scene,
        image: &ImageDesc,
        (grids, n_shares): (&[Grid], usize),
        backend: &str,
    ) -> Self {
        let n_threads = rayon::current_num_threads();
        let shared_bytes = shared_bytes(scene, image);
        let of_volumes = scene.layers.iter().zip(grids);
        let of_volumes =
            of_volumes.map(|(layer, grid)| grid.n_voxels() as u64 * voxel_bytes(layer));
        let of_share = of_volumes.sum::<u64>() / n_shares as u64;
        let of_threads = OF_THREAD * n_threads as u64;
        let memory_bytes = shared_bytes + of_threads + (of_share * 13 / 10).max(OF_SHARE);
        Self {
            memory_bytes,
            shared_bytes,
            n_threads,
            n_tiles: n_tiles(image),
            camera: scene.camera,
            is_refined: false,
            listing: Listing::by(backend),
            grows: true,
        }
    }

    /// All that there is.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.memory_bytes
    }

    /// How many threads it pays for.
    pub(super) fn n_threads(&self) -> usize {
        self.n_threads
    }

    /// Whether there is room for pictures that are shown meanwhile.
    pub(super) fn is_refined(&self) -> bool {
        self.is_refined
    }

    /// What it takes to draw a box of a layer, all of whose voxels may be relevant.
    fn needed_bytes(&self, of: &LayerInBoxes<'_>, around: Around) -> u64 {
        let n_read = n_voxels(around.read);
        let of_lists = self.listing.needed_bytes(n_read, 0 < of.support.coarsest);
        let in_range = n_in_range(around.drawn);
        let on_tiles = in_range.min(of.n_on_tile) * self.n_threads.min(self.n_tiles) as u64;
        n_read * of.voxel_bytes
            + of_lists
            + in_range * OF_VOXEL_IN_RANGE
            + on_tiles * OF_VOXEL_ON_TILE
    }

    /// Cuts the largest grid into boxes for all shares, and the own one into boxes of which each fits, of all
    /// layers together. Also says what is left for chunks that several boxes meet: always some, if there are
    /// chunks. If the smallest boxes have no room, fewer threads draw.
    pub(super) fn boxes(
        &mut self,
        layers: &[LayerInBoxes<'_>],
        (shares, has_chunks): (&mut Shares, bool),
    ) -> Result<(PartTree, u64), DividedError> {
        loop {
            match self.boxes_by_threads(layers, (&mut *shares, has_chunks)) {
                Err(DividedError::NoRoom(_)) if 1 < self.n_threads => self.n_threads /= 2,
                Err(DividedError::NoRoom(of)) if self.grows => self.memory_bytes = of.needed_bytes,
                boxes => return boxes,
            }
        }
    }

    fn boxes_by_threads(
        &self,
        layers: &[LayerInBoxes<'_>],
        (shares, has_chunks): (&mut Shares, bool),
    ) -> Result<(PartTree, u64), DividedError> {
        let Some(largest) = layers.iter().max_by_key(|of| of.grid.n_voxels()) else {
            return Err(slabsplat_backend::PlanError::NoLayers.into());
        };
        let center = Grid::center_of_all(layers.iter().map(|of| of.grid));
        let fixed_bytes = self.shared_bytes + OF_THREAD * self.n_threads as u64;
        let all = self.memory_bytes - fixed_bytes;
        let room = if has_chunks { all - all / OF_CHUNKS } else { all };
        let widest = layers.iter().map(|of| of.voxel_bytes).max().unwrap_or(1);
        let of_widest = LayerInBoxes { voxel_bytes: widest, ..*largest };
        let least_sides = largest.least_sides();
        // Of the largest layer alone at first; where others are finer, boxes get smaller until all fit.
        let mut of_one = room;
        loop {
            let mut deal = shares.deal();
            let tree = PartTree::new(largest.grid, center, |voxels| {
                deal.cut(voxels, |voxels| {
                    let around = of_widest.around(voxels);
                    let ahead = n_voxels(around.read) * widest;
                    let needed = self.needed_bytes(&of_widest, around) + ahead;
                    if needed <= of_one {
                        None
                    } else {
                        cut(voxels, largest.support.coarsest, least_sides)
                    }
                })
            });
            let own = tree.seen_by(&self.camera).into_iter();
            let [mut most, mut ahead] = [0, 0];
            for of in own.filter(|of| shares.are_own(&of.voxels)) {
                let near = layers.iter().map(|layer| (layer, layer.near(&tree, of)));
                let needed = near.clone().map(|(layer, near)| self.needed_bytes(layer, near));
                most = most.max(needed.sum());
                let sample_bytes =
                    near.map(|(layer, near)| n_voxels(near.read) * layer.voxel_bytes);
                ahead = ahead.max(sample_bytes.sum());
            }
            // While a box is drawn the voxels of another one are read.
            let most = most + ahead;
            if most <= room {
                return Ok((tree, all - most));
            }
            if of_one <= room / 64 {
                let of_chunks = if has_chunks { most.div_ceil(OF_CHUNKS - 1) } else { 0 };
                let needed_bytes = fixed_bytes + most + of_chunks;
                return Err(NoRoom { memory_bytes: self.memory_bytes, needed_bytes }.into());
            }
            of_one = of_one / 8 * 7;
        }
    }
}

/// A layer that is drawn in boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerInBoxes<'a> {
    /// Of all.
    pub(super) grid: &'a Grid,
    /// What is read around a box.
    pub(super) support: PartSupport,
    /// Of what is read of a voxel.
    pub(super) voxel_bytes: u64,
    /// How many of its voxels in a range of depth may lie on a tile.
    pub(super) n_on_tile: u64,
}

/// How many voxels there are along each axis in a box and around it.
#[derive(Clone, Copy, Debug)]
struct Around {
    /// That are read: of bricks of cells all.
    read: [usize; 3],
    /// That may be drawn.
    drawn: [usize; 3],
}

impl LayerInBoxes<'_> {
    /// Of one of the boxes of a tree.
    fn near(&self, tree: &PartTree, of: &PartBox) -> Around {
        self.by_both(|support| tree.voxels_near(of, self.grid, support).map(|range| range.len()))
    }

    /// Of a box of its own voxels.
    fn around(&self, voxels: &[Range<usize>; 3]) -> Around {
        let dims = self.grid.dims();
        let along = |axis: usize, support: &PartSupport| {
            support.around(axis, &voxels[axis], dims[axis]).len()
        };
        self.by_both(|support| [0, 1, 2].map(|axis| along(axis, support)))
    }

    /// The shortest sides of a box, for which what is around it is not too much.
    fn least_sides(&self) -> [usize; 3] {
        let bricks =
            if 0 < self.support.coarsest { LEAST_SIDE << self.support.coarsest } else { 0 };
        let reach = self.support.steps.map(|steps| steps.max(bricks as f64));
        reach.map(|reach| ((reach / OF_SIDE) as usize).next_multiple_of(LEAST_SIDE).max(LEAST_SIDE))
    }

    fn by_both(&self, dims: impl Fn(&PartSupport) -> [usize; 3]) -> Around {
        Around { read: dims(&self.support), drawn: dims(&self.support.with_cells(0)) }
    }
}

/// How many voxels of a layer in a range of depth may lie on a tile, anywhere in the picture.
pub(super) fn n_on_tile(grid: &Grid, view: &View, support: &PartSupport) -> u64 {
    let from_index = view.from_index(grid);
    let farthest = from_index.depth_range(grid)[1].max(view.near_depth());
    let [right, up] = [0, 1].map(|axis| {
        let reach = DVec3::from_array(support.steps).dot(from_index.matrix.row(axis).abs());
        TILE_SIDE / view.pixels_per_world(farthest) + 2.0 * reach
    });
    let of_world = right * up * IN_RANGE as f64 * grid.unit();
    (of_world / from_index.matrix.determinant().abs()).ceil() as u64
}

/// How many tiles a picture has.
fn n_tiles(image: &ImageDesc) -> usize {
    let along = |n_pixels: u32| (f64::from(n_pixels) / TILE_SIDE).ceil() as usize;
    along(image.width) * along(image.height)
}

fn n_voxels(dims: [usize; 3]) -> u64 {
    dims.iter().map(|n| *n as u64).product()
}

/// What there is beside threads and the voxels of a box.
fn shared_bytes(scene: &Scene, image: &ImageDesc) -> u64 {
    let overviews = scene.layers.iter();
    let overviews =
        overviews.map(|layer| layer.volume.grid().n_voxels() as u64 * voxel_bytes(layer));
    let of_pixels = OF_PIXEL * image.n_pixels() as u64;
    OF_PROGRAM + of_pixels + overviews.sum::<u64>()
}

/// What it takes to draw all overviews at once by one thread, beside their samples.
fn of_overviews(scene: &Scene, listing: Listing) -> u64 {
    let of_layer = |layer: &Layer| {
        let dims = layer.volume.grid().dims();
        let of_lists = listing.needed_bytes(n_voxels(dims), false);
        of_lists + n_in_range(dims) * (OF_VOXEL_IN_RANGE + OF_VOXEL_ON_TILE)
    };
    scene.layers.iter().map(of_layer).sum()
}

/// Bytes of what is read of a voxel.
pub(super) fn voxel_bytes(layer: &Layer) -> u64 {
    let n_voxels = layer.volume.grid().n_voxels();
    let of_colors =
        layer.colors.as_ref().map_or(0, |colors| colors.samples().size_bytes() / n_voxels);
    let of_labels = layer.labels.as_ref().map_or(0, |_| size_of::<u16>());
    (layer.volume.sample_type().size_bytes() + of_colors + of_labels) as u64
}

impl Listing {
    fn by(backend: &str) -> Self {
        if backend == CPU { Self::BrickByBrick } else { Self::All }
    }

    /// What it takes to have the voxels of a box, of which all may be relevant.
    fn needed_bytes(self, n_voxels: u64, has_cells: bool) -> u64 {
        match (self, has_cells) {
            (Self::BrickByBrick, _) => n_voxels / PER_BYTE_OF_BRICKS,
            (Self::All, false) => n_voxels * OF_LISTED_VOXEL,
            (Self::All, true) => n_voxels * (OF_LISTED_VOXEL + OF_LISTED_CELLS),
        }
    }
}

/// How many voxels are in a range of depth of a box that has so many along each axis.
fn n_in_range(dims: [usize; 3]) -> u64 {
    let mut sides = dims.map(|n| n as u64);
    sides.sort_unstable();
    // It lies across the two longest sides: of a cube, at worst, in a hexagon of 1.3 of a side's area.
    let [_, y, x] = sides;
    (x * y * IN_RANGE * 13 / 10).min(n_voxels(dims))
}

/// Across the longest side that can be cut, between bricks, if it can be of the coarsest cells, as near to
/// its middle as that is.
fn cut(
    voxels: &[Range<usize>; 3],
    coarsest: u32,
    least_sides: [usize; 3],
) -> Option<(usize, usize)> {
    let cut_across = |axis: usize| {
        let Range { start, end } = voxels[axis].clone();
        let middle = start.midpoint(end);
        let at = (0..=coarsest).rev().map(|level| middle.next_multiple_of(LEAST_SIDE << level));
        let fits = |at: &usize| start + least_sides[axis] <= *at && at + least_sides[axis] <= end;
        at.into_iter().find(fits).map(|at| (axis, at))
    };
    let mut axes = [0, 1, 2];
    axes.sort_by_key(|axis| std::cmp::Reverse(voxels[*axis].len()));
    axes.into_iter().find_map(cut_across)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::Projection;

    fn needed_bytes(backend: &str, dims: [usize; 3], voxel_bytes: u64, coarsest: u32) -> u64 {
        let listing = Listing::by(backend);
        let projection = Projection::Orthographic { view_height: 1.0 };
        let camera = Camera::new(DVec3::ONE, DVec3::ZERO, DVec3::Y, projection).unwrap();
        let budget = Budget {
            memory_bytes: 1 << 30,
            shared_bytes: 0,
            n_threads: 2,
            n_tiles: 2,
            camera,
            is_refined: false,
            listing,
            grows: false,
        };
        let grid = Grid::with_spacing(dims, [1.0; 3]).unwrap();
        let support = PartSupport::of_voxels([3.0; 3]).with_cells(coarsest);
        let layer = LayerInBoxes { grid: &grid, support, voxel_bytes, n_on_tile: 1 << 15 };
        budget.needed_bytes(&layer, Around { read: dims, drawn: dims })
    }

    #[test]
    fn budget_counts_more_for_more() {
        for backend in [CPU, "wgpu"] {
            let small = needed_bytes(backend, [64, 64, 64], 1, 0);
            for dims in [[64, 65, 64], [65, 64, 64]] {
                assert!(small < needed_bytes(backend, dims, 1, 0));
            }
            assert!(small < needed_bytes(backend, [64; 3], 4, 0));
            let [deep, wide] = [[10, 20, 300], [300, 10, 20]];
            let [deep, wide] = [deep, wide].map(|dims| needed_bytes(backend, dims, 2, 0));
            assert_eq!(deep, wide);
        }
        let by_cells = [0, 1].map(|coarsest| needed_bytes("wgpu", [64; 3], 1, coarsest));
        assert!(by_cells[0] < by_cells[1], "{by_cells:?}");
        let large = [CPU, "wgpu"].map(|backend| needed_bytes(backend, [512; 3], 1, 1));
        assert!(2 * large[0] < large[1], "{large:?}");
    }

    #[test]
    fn budget_cuts_between_bricks() {
        let cut_of = |voxels: &[Range<usize>; 3], coarsest| cut(voxels, coarsest, [8; 3]);
        assert_eq!(cut_of(&[0..100, 0..30, 0..99], 0), Some((0, 56)));
        assert_eq!(cut_of(&[0..4, 8..16, 0..4], 3), None, "a brick is not cut");
        assert_eq!(cut_of(&[0..4, 8..25, 0..4], 0), Some((1, 16)));
        for (coarsest, at) in [(1, 64), (2, 64), (3, 64)] {
            assert_eq!(cut_of(&[0..100, 0..30, 0..99], coarsest), Some((0, at)));
        }
        assert_eq!(cut_of(&[0..60, 0..30, 0..20], 3), Some((0, 32)), "there is no larger brick");
        assert_eq!(cut(&[0..60, 0..50, 0..20], 0, [40, 16, 8]), Some((1, 32)), "not too short");
    }
}
