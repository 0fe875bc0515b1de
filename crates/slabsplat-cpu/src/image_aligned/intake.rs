//! Voxels into tiles, a range of depth at a time: cull, project, shade, toss.
//!
//! Bricks are taken in the order of the first slab that any of their kernels meets. A brick that lies behind full
//! blocks is not looked at, nor is a voxel: neither is projected, shaded or tossed (the culling of Mueller et al.
//! 1999). All buffers are as large as one range needs, and are used again.

use crate::by_sheet::N_AT_ONCE;
use crate::frame::Stage;
use crate::image_aligned::occlusion::{Occlusion, Seen};
use crate::image_aligned::{Slabs, Span};
use crate::voxel::Voxel;
use crate::workspace::Workspaces;
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;
use slabsplat_traverse::{Brick, BrickBounds, Throw, TileGrid, TileToss, VoxelRecord};
use std::ops::Range;

/// Bricks that one task takes in. It depends on nothing, or the order of sums would.
const BRICKS_PER_TASK: usize = 32;

/// The voxels of a range, by tile.
#[derive(Debug, Default)]
pub(crate) struct Intake {
    tasks: Vec<TileToss<Voxel>>,
    n_tasks: usize,
}

/// What came of a range.
pub(crate) struct Taken {
    /// Voxels that were left out, as nothing of them is to be seen.
    pub(crate) n_hidden: u64,
    /// The slabs to which the others go first, if there are any.
    pub(crate) first_slabs: Option<Range<usize>>,
}

/// What a thread needs to take bricks in.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// Of one task.
    voxels: Vec<Voxel>,
    throws: Vec<Throw>,
    /// The least and the largest, in bits.
    spans: [u32; 2],
    /// Of one brick.
    points: Vec<[f32; 3]>,
    records: Vec<VoxelRecord>,
    colors: Vec<[f32; 4]>,
}

impl Intake {
    /// Takes in the voxels of `bricks`, whose second numbers are their places in the list.
    pub(crate) fn take(
        &mut self,
        stage: &Stage<'_>,
        slabs: &Slabs<'_>,
        tiles: &TileGrid,
        occlusion: &Occlusion,
        bricks: &[(u32, u32)],
        workspaces: &mut Workspaces,
    ) -> Taken {
        self.n_tasks = bricks.len().div_ceil(BRICKS_PER_TASK);
        if self.tasks.len() < self.n_tasks {
            self.tasks.resize_with(self.n_tasks, TileToss::default);
        }
        let workspaces = workspaces.for_all_threads();
        let tasks = self.tasks[..self.n_tasks].par_iter_mut();
        let work = tasks.zip(bricks.par_chunks(BRICKS_PER_TASK));
        let taken = work.map(|(toss, bricks)| {
            let mut workspace = workspaces.of_this_thread();
            let scratch = &mut workspace.scratch;
            scratch.clear();
            let mut n_hidden = 0;
            dispatch!(stage.level, simd => {
                for &(_, place) in bricks {
                    let brick = &stage.list.bricks()[place as usize];
                    n_hidden += scratch.take_brick(simd, stage, slabs, tiles, occlusion, brick);
                }
            });
            toss.toss(tiles, &scratch.throws, |voxel| scratch.voxels[voxel as usize]);
            (n_hidden, scratch.spans)
        });
        let both = |(n, [a, b]): (u64, [u32; 2]), (m, [c, d]): (u64, [u32; 2])| {
            (n + m, [a.min(c), b.max(d)])
        };
        let (n_hidden, spans) = taken.reduce(|| (0, NO_SPANS), both);
        let [first, last] = spans.map(|bits| Span::from_bits(bits).first());
        Taken { n_hidden, first_slabs: (spans != NO_SPANS).then_some(first..last + 1) }
    }

    /// The voxels on a tile, in runs, in the order of the list.
    pub(crate) fn on_tile(&self, tile_idx: usize) -> impl Iterator<Item = &[Voxel]> + Clone {
        self.tasks[..self.n_tasks].iter().map(move |toss| toss.on_tile(tile_idx))
    }

    pub(crate) fn resident_bytes(&self) -> usize {
        self.tasks.iter().map(TileToss::resident_bytes).sum()
    }
}

/// The least and the largest of no span at all.
const NO_SPANS: [u32; 2] = [u32::MAX, 0];

impl Scratch {
    /// Makes it ready for another task.
    fn clear(&mut self) {
        self.voxels.clear();
        self.throws.clear();
        self.spans = NO_SPANS;
    }

    /// Adds a brick's voxels, projected and shaded; returns how many were left out.
    #[inline(always)]
    fn take_brick<S: Simd>(
        &mut self,
        simd: S,
        stage: &Stage<'_>,
        slabs: &Slabs<'_>,
        tiles: &TileGrid,
        occlusion: &Occlusion,
        brick: &Brick,
    ) -> u64 {
        let records = stage.list.voxels_of(brick);
        let bounds = slabs.bounds_of_brick(&stage.bricks.bounds(brick));
        let pixels = bounds.and_then(|[min, max]| tiles.pixels_within(min, max));
        let seen = pixels.map_or(Seen::Not, |pixels| occlusion.shows(&pixels));
        if seen == Seen::Not {
            return records.len() as u64;
        }
        self.points.resize(records.len(), [0.0; 3]);
        stage.bricks.project_brick(brick, records, &mut self.points);
        self.records.clear();
        let first = self.voxels.len();
        for (record, &point) in records.iter().zip(&self.points) {
            let Some([min, max]) = slabs.bounds_of_voxel(point) else { continue };
            let Some(pixels) = tiles.pixels_within(min, max) else { continue };
            if seen == Seen::Partly && occlusion.shows(&pixels) == Seen::Not {
                continue;
            }
            tiles.push(tiles.tiles_of(&pixels), self.voxels.len() as u32, &mut self.throws);
            self.records.push(*record);
            self.voxels.push(Voxel { point, ..Voxel::default() });
        }
        self.colors.resize(self.records.len(), [0.0; 4]);
        stage.shader.shade_brick(brick, &self.records, &mut self.colors);
        let new = self.voxels[first..].chunks_mut(N_AT_ONCE);
        for (voxels, colors) in new.zip(self.colors.chunks(N_AT_ONCE)) {
            let (mut depths, mut extinctions) = ([0.0; N_AT_ONCE], [0.0; N_AT_ONCE]);
            for (idx, (voxel, color)) in voxels.iter_mut().zip(colors).enumerate() {
                voxel.color = *color;
                (depths[idx], extinctions[idx]) = (voxel.point[2], color[3]);
            }
            let spans = slabs.spans(simd, &depths, &extinctions);
            for (voxel, span) in voxels.iter_mut().zip(spans) {
                voxel.sheets = span;
                let [least, largest] = self.spans;
                self.spans = [span.min(least), span.max(largest)];
            }
        }
        (records.len() - self.records.len()) as u64
    }

    pub(crate) fn resident_bytes(&self) -> usize {
        self.voxels.capacity() * size_of::<Voxel>() + self.throws.capacity() * size_of::<Throw>()
    }
}

impl Slabs<'_> {
    /// The pixels that sections of a brick's voxels may touch: the least and the largest corner; `None` if none of
    /// them is drawn.
    fn bounds_of_brick(&self, bounds: &BrickBounds) -> Option<[[f32; 2]; 2]> {
        let BrickBounds { center, half_extents } = *bounds;
        let ends = [center[2] - half_extents[2], center[2] + half_extents[2]];
        let first = self.meeting(ends[0])[0].max(self.first_drawn);
        let last = self.meeting(ends[1])[1];
        if last < first {
            return None;
        }
        let corner = |sign: f32| [0, 1, 2].map(|axis| center[axis] + sign * half_extents[axis]);
        let shapes = [first, last].map(|slab| self.shape(slab));
        let all = shapes.iter().flat_map(|shape| {
            [corner(-1.0), corner(1.0)].map(|point| self.raster.bounds(shape, point))
        });
        all.reduce(|[min, max], [a, b]| {
            [[0, 1].map(|axis| a[axis].min(min[axis])), [0, 1].map(|axis| b[axis].max(max[axis]))]
        })
    }

    /// The pixels that a voxel's sections may touch. Their place and size change monotonically with their slabs'
    /// depth, so that the first and the last one bound all of them.
    #[inline(always)]
    fn bounds_of_voxel(&self, point: [f32; 3]) -> Option<[[f32; 2]; 2]> {
        if let (Some(only), 0) = (self.shapes.only(), self.first_drawn) {
            return Some(self.raster.bounds(only, point));
        }
        let [first, last] = self.meeting(point[2]);
        let first = first.max(self.first_drawn);
        if last < first {
            return None;
        }
        let near = self.raster.bounds(&self.shape(first), point);
        let far = self.raster.bounds(&self.shape(last), point);
        Some([
            [0, 1].map(|axis| near[0][axis].min(far[0][axis])),
            [0, 1].map(|axis| near[1][axis].max(far[1][axis])),
        ])
    }
}
