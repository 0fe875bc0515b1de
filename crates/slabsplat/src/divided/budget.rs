//! How large boxes may be within a budget of memory.

use super::refine::MOST_GROUPS;
use super::shares::Shares;
use super::{DividedDesc, DividedError};
use slabsplat_core::{Camera, Grid, ImageDesc, Layer, PartBox, PartSupport, PartTree, Scene};
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
    /// What there is beside them.
    fixed_bytes: u64,
    n_threads: usize,
    camera: Camera,
    is_refined: bool,
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

/// Of a voxel that is read, beside its sample: its record, if it is relevant, and its brick's.
const OF_VOXEL: u64 = 9;

/// Of a voxel that may be drawn as part of a cell: its share of cells, also of such as may not stand for it.
const OF_CELLS: u64 = 3;

/// Of a voxel in the range of depth that is drawn: projected and shaded, and on its tiles.
const OF_VOXEL_IN_RANGE: u64 = 64;

/// How many voxel steps are in such a range, what waits for the next one included.
const IN_RANGE: u64 = 36;

/// The part of what is there for voxels that chunks have which several boxes meet: of a box of 264³ voxels a
/// side of chunks of 64³ is a fortieth.
const OF_CHUNKS: u64 = 8;

/// What a share has for voxels, at least.
const OF_SHARE: u64 = 64 << 20;

/// The least side of a box.
const LEAST_SIDE: usize = 8;

impl Budget {
    pub(super) fn new(
        scene: &Scene,
        image: &ImageDesc,
        desc: &DividedDesc,
    ) -> Result<Self, DividedError> {
        let &DividedDesc { memory_bytes, is_refined, .. } = desc;
        let mut shared_bytes = shared_bytes(scene, image);
        let mut needed_bytes = shared_bytes + OF_THREAD;
        if is_refined {
            shared_bytes += OF_REFINED_PIXEL * image.n_pixels() as u64;
            // Overviews are drawn before the first box is.
            needed_bytes = shared_bytes + OF_THREAD + of_overviews(scene);
        }
        if memory_bytes <= needed_bytes {
            return Err(NoRoom { memory_bytes, needed_bytes }.into());
        }
        let n_paid_for = (memory_bytes - shared_bytes) / OF_THREADS / OF_THREAD;
        let n_threads = rayon::current_num_threads().min(n_paid_for as usize).max(1);
        let fixed_bytes = shared_bytes + OF_THREAD * n_threads as u64;
        Ok(Self { memory_bytes, fixed_bytes, n_threads, camera: scene.camera, is_refined })
    }

    /// Of one of so many who share a scene, whose volumes are on those grids: it grows with its part of them.
    pub(super) fn of_share(
        scene: &Scene,
        image: &ImageDesc,
        grids: &[Grid],
        n_shares: usize,
    ) -> Self {
        let n_threads = rayon::current_num_threads();
        let fixed_bytes = shared_bytes(scene, image) + OF_THREAD * n_threads as u64;
        let of_volumes = scene.layers.iter().zip(grids);
        let of_volumes =
            of_volumes.map(|(layer, grid)| grid.n_voxels() as u64 * voxel_bytes(layer));
        let of_share = of_volumes.sum::<u64>() / n_shares as u64;
        let memory_bytes = fixed_bytes + (of_share * 13 / 10).max(OF_SHARE);
        let camera = scene.camera;
        Self { memory_bytes, fixed_bytes, n_threads, camera, is_refined: false }
    }

    /// All that there is.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.memory_bytes
    }

    /// How many threads it pays for.
    pub(super) fn n_threads(&self) -> usize {
        self.n_threads
    }

    /// Who sees them.
    pub(super) fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Whether there is room for pictures that are shown meanwhile.
    pub(super) fn is_refined(&self) -> bool {
        self.is_refined
    }

    /// Cuts the largest grid into boxes for all shares, and the own one into boxes of which each fits, of all
    /// layers together. Also says what is left for chunks that several boxes meet: always some, if there are
    /// chunks.
    pub(super) fn boxes(
        &self,
        layers: &[LayerInBoxes<'_>],
        (shares, has_chunks): (&mut Shares, bool),
    ) -> Result<(PartTree, u64), DividedError> {
        let Some(largest) = layers.iter().max_by_key(|of| of.grid.n_voxels()) else {
            return Err(slabsplat_backend::PlanError::NoLayers.into());
        };
        let center = Grid::center_of_all(layers.iter().map(|of| of.grid));
        let all = self.memory_bytes - self.fixed_bytes;
        let room = if has_chunks { all - all / OF_CHUNKS } else { all };
        let widest = layers.iter().map(|of| of.voxel_bytes).max().unwrap_or(1);
        let of_widest = LayerInBoxes { voxel_bytes: widest, ..*largest };
        // Of the largest layer alone at first; where others are finer, boxes get smaller until all fit.
        let mut of_one = room;
        loop {
            let mut deal = shares.deal();
            let tree = PartTree::new(largest.grid, center, |voxels| {
                deal.cut(voxels, |voxels| {
                    let near = of_widest.dims_around(voxels);
                    let needed = of_widest.needed_bytes(near) + of_widest.sample_bytes(near);
                    if needed <= of_one { None } else { cut(voxels, largest.support.coarsest) }
                })
            });
            let own = tree.seen_by(&self.camera).into_iter();
            let [mut most, mut ahead] = [0, 0];
            for of in own.filter(|of| shares.are_own(&of.voxels)) {
                let near = layers.iter().map(|layer| (layer, layer.dims_near(&tree, of)));
                most = most.max(near.clone().map(|(of, near)| of.needed_bytes(near)).sum());
                ahead = ahead.max(near.map(|(of, near)| of.sample_bytes(near)).sum());
            }
            // While a box is drawn the voxels of another one are read.
            let most = most + ahead;
            if most <= room {
                return Ok((tree, all - most));
            }
            if of_one < room / 64 {
                let needed_bytes = self.fixed_bytes + most;
                return Err(NoRoom { memory_bytes: self.memory_bytes, needed_bytes }.into());
            }
            of_one = of_one / 4 * 3;
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
}

impl LayerInBoxes<'_> {
    /// How many voxels are read along each axis for one of the boxes of a tree.
    pub(super) fn dims_near(&self, tree: &PartTree, of: &PartBox) -> [usize; 3] {
        tree.voxels_near(of, self.grid, &self.support).map(|range| range.len())
    }

    /// The same for a box of its own voxels.
    fn dims_around(&self, voxels: &[Range<usize>; 3]) -> [usize; 3] {
        let dims = self.grid.dims();
        [0, 1, 2].map(|axis| self.support.around(axis, &voxels[axis], dims[axis]).len())
    }

    /// What it takes to draw so many voxels along each axis, of which all may be relevant.
    fn needed_bytes(&self, dims: [usize; 3]) -> u64 {
        needed_bytes(dims, self.voxel_bytes, 0 < self.support.coarsest)
    }

    /// What the voxels of a box take that is not drawn yet.
    fn sample_bytes(&self, dims: [usize; 3]) -> u64 {
        dims.iter().map(|n| *n as u64).product::<u64>() * self.voxel_bytes
    }
}

/// What there is beside threads and the voxels of a box.
fn shared_bytes(scene: &Scene, image: &ImageDesc) -> u64 {
    let overviews = scene.layers.iter();
    let overviews =
        overviews.map(|layer| layer.volume.grid().n_voxels() as u64 * voxel_bytes(layer));
    let of_pixels = OF_PIXEL * image.n_pixels() as u64;
    OF_PROGRAM + of_pixels + overviews.sum::<u64>()
}

/// Bytes of what is read of a voxel.
pub(super) fn voxel_bytes(layer: &Layer) -> u64 {
    let n_voxels = layer.volume.grid().n_voxels();
    let of_colors =
        layer.colors.as_ref().map_or(0, |colors| colors.samples().size_bytes() / n_voxels);
    let of_labels = layer.labels.as_ref().map_or(0, |_| size_of::<u16>());
    (layer.volume.sample_type().size_bytes() + of_colors + of_labels) as u64
}

/// What it takes to draw all overviews at once, beside their samples.
fn of_overviews(scene: &Scene) -> u64 {
    scene.layers.iter().map(|layer| needed_bytes(layer.volume.grid().dims(), 0, false)).sum()
}

/// What it takes to draw a box that has so many voxels along each axis, of which all may be relevant.
fn needed_bytes(dims: [usize; 3], sample_bytes: u64, has_cells: bool) -> u64 {
    let [mut x, mut y, mut z] = dims.map(|n| n as u64);
    // A range lies across the two longest sides: of a cube, at worst, in a hexagon of 1.3 of a side's area.
    if x < z {
        (x, z) = (z, x);
    }
    if y < z {
        (y, z) = (z, y);
    }
    let n_voxels = x * y * z;
    let in_range = (x * y * IN_RANGE * 13 / 10).min(n_voxels);
    let of_cells = if has_cells { OF_CELLS } else { 0 };
    n_voxels * (sample_bytes + OF_VOXEL + of_cells) + in_range * OF_VOXEL_IN_RANGE
}

/// Across the longest side, between bricks, if it can be of the coarsest cells, as near to its middle as that
/// is.
fn cut(voxels: &[Range<usize>; 3], coarsest: u32) -> Option<(usize, usize)> {
    let axis = (0..3).max_by_key(|axis| voxels[*axis].len())?;
    let Range { start, end } = voxels[axis].clone();
    let at = |level: u32| start.midpoint(end).next_multiple_of(LEAST_SIDE << level);
    let at = (0..=coarsest).rev().map(at).find(|at| start < *at && *at < end)?;
    Some((axis, at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budget_counts_more_for_more() {
        let small = needed_bytes([64, 64, 64], 1, false);
        for more in [([64; 3], 4, false), ([64, 65, 64], 1, false), ([64; 3], 1, true)] {
            assert!(small < needed_bytes(more.0, more.1, more.2));
        }
        let [deep, wide] = [[10, 20, 300], [300, 10, 20]].map(|dims| needed_bytes(dims, 2, false));
        assert_eq!(deep, wide);
    }

    #[test]
    fn budget_cuts_between_bricks() {
        assert_eq!(cut(&[0..100, 0..30, 0..99], 0), Some((0, 56)));
        assert_eq!(cut(&[0..4, 8..16, 0..4], 3), None, "a brick is not cut");
        assert_eq!(cut(&[0..4, 8..17, 0..4], 0), Some((1, 16)));
        for (coarsest, at) in [(1, 64), (2, 64), (3, 64)] {
            assert_eq!(cut(&[0..100, 0..30, 0..99], coarsest), Some((0, at)));
        }
        assert_eq!(cut(&[0..60, 0..30, 0..20], 3), Some((0, 32)), "there is no larger brick");
    }
}
