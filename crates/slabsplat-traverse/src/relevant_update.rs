//! How the relevant list follows a change of iso-ranges.
//!
//! Twice over the bricks, in chunks: first voxels are counted, then, when it is known where each chunk's
//! go, they are written. So the list is the only large thing in memory, at its final size. Counting
//! takes a tenth of what writing does.
//!
//! A brick in which old and new ranges hold the same values is copied; in others a voxel that stays keeps
//! its record. An update needs room for the list before and the list after.

use crate::bricks::N_ROWS;
use crate::gradient::{Normals, Real, RowNormals, is_narrow};
use crate::membership::{BrickMask, Membership};
use crate::order::Ordered;
use crate::{BRICK_SIDE, Brick, BrickRanges, ListChange, RelevantList, VoxelRecord};
use rayon::prelude::*;
use slabsplat_core::{IsoRange, Volume};
use std::ops::Range;

/// Bricks to a task.
const CHUNK_BRICKS: usize = 256;

/// See [`RelevantList::update`]; `samples` are those of `volume`.
pub(crate) fn update<T: Ordered>(
    list: &mut RelevantList,
    volume: &Volume,
    samples: &[T],
    brick_ranges: &BrickRanges,
    ranges: &[IsoRange],
) -> ListChange {
    let step = Step {
        old: list,
        membership: Membership::new(volume, samples, list.grid, ranges),
        brick_ranges,
        ranges,
    };
    let counted = step.count();
    let change = counted.iter().fold(ListChange::default(), |sum, chunk| ListChange {
        n_added: sum.n_added + chunk.change.n_added,
        n_dropped: sum.n_dropped + chunk.change.n_dropped,
    });
    if change != ListChange::default() {
        let records = if is_narrow(volume) {
            step.write(&counted, &Normals::<T, f32>::new(volume, samples))
        } else {
            step.write(&counted, &Normals::<T, f64>::new(volume, samples))
        };
        list.bricks = joined(&counted, records.len());
        list.records = records;
    }
    list.ranges = ranges.to_vec();
    change
}

/// One update: what there is, and what is wanted.
struct Step<'a, T> {
    old: &'a RelevantList,
    membership: Membership<'a, T>,
    brick_ranges: &'a BrickRanges,
    ranges: &'a [IsoRange],
}

/// What will be of a chunk of bricks; places count from the chunk's first voxel.
struct Counted {
    bricks: Vec<Brick>,
    n_voxels: usize,
    change: ListChange,
}

impl<T: Ordered> Step<'_, T> {
    fn count(&self) -> Vec<Counted> {
        let n_bricks = self.brick_ranges.n_bricks();
        let n_chunks = n_bricks.div_ceil(CHUNK_BRICKS);
        let chunk = |chunk_idx: usize| {
            let start = chunk_idx * CHUNK_BRICKS;
            self.count_chunk(start as u32..n_bricks.min(start + CHUNK_BRICKS) as u32)
        };
        (0..n_chunks).into_par_iter().map(chunk).collect()
    }

    fn count_chunk(&self, brick_idxs: Range<u32>) -> Counted {
        let mut old = OldBricks::new(self.old, brick_idxs.start);
        let mut bricks = Vec::new();
        let (mut n_voxels, mut change) = (0, ListChange::default());
        for brick_idx in brick_idxs {
            let old = old.take(brick_idx);
            let n_in_brick = if self.is_touched(brick_idx) {
                let new = self.mask(brick_idx);
                let n_kept = new.and(&BrickMask::of_records(old)).count();
                change.n_added += new.count() - n_kept;
                change.n_dropped += old.len() - n_kept;
                new.count()
            } else {
                old.len()
            };
            if 0 < n_in_brick {
                bricks.push(Brick { brick_idx, first: n_voxels, n_voxels: n_in_brick as u16 });
                n_voxels += n_in_brick as u32;
            }
        }
        Counted { bricks, n_voxels: n_voxels as usize, change }
    }

    fn write<F: Real + Sync>(
        &self,
        counted: &[Counted],
        normals: &Normals<'_, T, F>,
    ) -> Vec<VoxelRecord> {
        let n_voxels = counted.iter().map(|chunk| chunk.n_voxels).sum();
        // Zeroed by the system, page by page where threads first write.
        let mut records = bytemuck::zeroed_vec(n_voxels);
        let mut rest = records.as_mut_slice();
        let mut tasks = Vec::with_capacity(counted.len());
        for chunk in counted {
            let (part, others) = rest.split_at_mut(chunk.n_voxels);
            tasks.push((&chunk.bricks, part));
            rest = others;
        }
        tasks.into_par_iter().for_each(|(bricks, records)| {
            self.write_chunk(bricks, normals, records);
        });
        records
    }

    fn write_chunk<F: Real>(
        &self,
        bricks: &[Brick],
        normals: &Normals<'_, T, F>,
        records: &mut [VoxelRecord],
    ) {
        let Some(first) = bricks.first() else { return };
        let mut old = OldBricks::new(self.old, first.brick_idx);
        for brick in bricks {
            let (old, records) = (old.take(brick.brick_idx), &mut records[brick.voxels()]);
            if self.is_touched(brick.brick_idx) {
                let origin = self.old.grid.origin(brick.brick_idx);
                write_brick(&self.mask(brick.brick_idx), origin, old, normals, records);
            } else {
                records.copy_from_slice(old);
            }
        }
    }

    /// Whether the brick holds values that only the old or only the new ranges have.
    fn is_touched(&self, brick_idx: u32) -> bool {
        let within = self.brick_ranges.of_brick(brick_idx as usize);
        let clipped = |range: &IsoRange| [range.lo.max(within.lo), range.hi.min(within.hi)];
        let [old, new] = [&self.old.ranges, self.ranges].map(|ranges| &ranges[met(ranges, within)]);
        !old.iter().map(clipped).eq(new.iter().map(clipped))
    }

    fn mask(&self, brick_idx: u32) -> BrickMask {
        let within = self.brick_ranges.of_brick(brick_idx as usize);
        self.membership.of_brick(brick_idx, met(self.ranges, within))
    }
}

/// Which of `ranges` (disjoint, rising) have values in common with `within`.
fn met(ranges: &[IsoRange], within: IsoRange) -> Range<usize> {
    let start = ranges.partition_point(|range| range.hi < within.lo);
    start..ranges.partition_point(|range| range.lo <= within.hi).max(start)
}

/// Walks along the old list.
struct OldBricks<'a> {
    list: &'a RelevantList,
    next: usize,
}

impl<'a> OldBricks<'a> {
    fn new(list: &'a RelevantList, first: u32) -> Self {
        Self { list, next: list.bricks.partition_point(|brick| brick.brick_idx < first) }
    }

    /// The old voxels of the brick, which must come after those asked for before.
    fn take(&mut self, brick_idx: u32) -> &'a [VoxelRecord] {
        let bricks = &self.list.bricks;
        while bricks.get(self.next).is_some_and(|brick| brick.brick_idx < brick_idx) {
            self.next += 1;
        }
        match bricks.get(self.next) {
            Some(brick) if brick.brick_idx == brick_idx => self.list.voxels_of(brick),
            _ => &[],
        }
    }
}

/// Writes the voxels of `mask`: those of the `old` ones that are in it, and new ones with their normals.
fn write_brick<T: Ordered, F: Real>(
    mask: &BrickMask,
    [x, y, z]: [usize; 3],
    old: &[VoxelRecord],
    normals: &Normals<'_, T, F>,
    records: &mut [VoxelRecord],
) {
    let added = mask.without(&BrickMask::of_records(old));
    let mut old = old.iter();
    let mut n_written = 0;
    for row in (0..N_ROWS).filter(|&row| mask.rows[row] != 0) {
        let row_normals: RowNormals = if added.rows[row] == 0 {
            [[0; BRICK_SIDE]; 3]
        } else {
            normals.of_row([x, y + row % BRICK_SIDE, z + row / BRICK_SIDE])
        };
        let mut left = mask.rows[row];
        while left != 0 {
            let x = left.trailing_zeros() as usize;
            let place = (row * BRICK_SIDE + x) as u16;
            let is_new = added.rows[row] >> x & 1 == 1;
            let kept = if is_new { None } else { old.find(|old| old.place == place) };
            let new = VoxelRecord { place, normal: row_normals.map(|component| component[x]) };
            records[n_written] = kept.copied().unwrap_or(new);
            n_written += 1;
            left &= left - 1;
        }
    }
}

fn joined(counted: &[Counted], n_voxels: usize) -> Vec<Brick> {
    let mut bricks = Vec::with_capacity(counted.iter().map(|chunk| chunk.bricks.len()).sum());
    let mut first = 0;
    for chunk in counted {
        bricks.extend(chunk.bricks.iter().map(|b| Brick { first: first + b.first, ..*b }));
        first += chunk.n_voxels as u32;
    }
    debug_assert_eq!(first as usize, n_voxels, "every voxel has its place");
    bricks
}
