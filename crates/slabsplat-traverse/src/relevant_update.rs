//! How the relevant list follows a change of iso-ranges, in place.
//!
//! ```text
//! count    by brick: voxels that stay, voxels that there will be          in parallel
//! drop     voxels that do not stay; close the gaps                        in parallel; one thread
//! add      room for what comes, at its final size; make gaps; fill them   one thread; in parallel
//! ```
//!
//! A brick in which old and new ranges hold the same values is not looked at, let alone its voxels; in
//! others a voxel that stays keeps its record. What one thread does is to move memory, and nothing
//! at all for a new list. There is never a second list, and hardly a number beside the records.
//!
//! Threads take chunks of bricks. Between dropping and adding a chunk's voxels lie at the end of the
//! slots that the chunk will fill, so that filling from the front never overtakes them.

use crate::bricks::N_ROWS;
use crate::gradient::{Normals, Real, RowNormals, is_narrow};
use crate::membership::{BrickMask, Membership};
use crate::order::Ordered;
use crate::voxel_rules::VoxelRules;
use crate::{BRICK_SIDE, Brick, BrickGrid, BrickRanges, ListChange, RelevantList, VoxelRecord};
use rayon::prelude::*;
use slabsplat_core::{Cancelled, FrameHandle, IsoRange, StageError, Volume};
use std::ops::Range;

/// Bricks to a task; few in tests, whose volumes are small, so that there are gaps to close and to make.
const CHUNK_BRICKS: usize = if cfg!(test) { 3 } else { 256 };

/// Voxels that room is made for between two looks at whether anyone still wants them: a millisecond.
const MADE_AT_ONCE: usize = 1 << 18;

/// What a list shall become, and for which frame.
pub(crate) struct Update<'a> {
    pub(crate) volume: &'a Volume,
    pub(crate) brick_ranges: &'a BrickRanges,
    pub(crate) ranges: &'a [IsoRange],
    pub(crate) rules: Option<&'a VoxelRules<'a>>,
    pub(crate) frame: &'a FrameHandle,
}

/// See [`RelevantList::update_for_frame`]; `samples` are those of the volume.
pub(crate) fn update<T: Ordered>(
    list: &mut RelevantList,
    samples: &[T],
    to: &Update<'_>,
) -> Result<ListChange, StageError> {
    let &Update { volume, ranges, rules, frame, .. } = to;
    let RelevantList { grid, bricks, records, ranges: old_ranges } = list;
    let membership = Membership::new(volume, samples, *grid, ranges, rules);
    let step = Step { grid: *grid, old_bricks: bricks, old_ranges, membership, to };
    let chunks = step.count(records);
    frame.check()?;
    let sum = |number: fn(&Chunk) -> usize| chunks.iter().map(number).sum();
    let change = ListChange { n_added: sum(Chunk::n_added), n_dropped: sum(Chunk::n_dropped) };
    let result = step.carry_out(change, &chunks, samples, records);
    if result.is_err() {
        list.clear();
        return result.map(|()| change);
    }
    if change != ListChange::default() {
        *bricks = joined(&chunks);
    }
    *old_ranges = ranges.to_vec();
    Ok(change)
}

/// One update: what there is, and what is wanted.
struct Step<'a, T> {
    grid: BrickGrid,
    old_bricks: &'a [Brick],
    old_ranges: &'a [IsoRange],
    membership: Membership<'a, T>,
    to: &'a Update<'a>,
}

/// What was and will be of a run of bricks.
struct Chunk {
    /// Its bricks in the old list.
    old_bricks: Range<usize>,
    n_old: usize,
    /// Bricks that will have voxels, and how many of these are there. Indices count from the chunk's first.
    bricks: Vec<(Brick, u16)>,
    n_kept: usize,
    n_new: usize,
}

impl Chunk {
    fn n_added(&self) -> usize {
        self.n_new - self.n_kept
    }

    fn n_dropped(&self) -> usize {
        self.n_old - self.n_kept
    }

    fn push(&mut self, brick_idx: u32, n_voxels: usize, n_kept: usize) {
        if 0 < n_voxels {
            let brick = Brick { brick_idx, first: self.n_new as u32, n_voxels: n_voxels as u16 };
            self.bricks.push((brick, n_kept as u16));
            self.n_new += n_voxels;
            self.n_kept += n_kept;
        }
    }
}

impl<T: Ordered> Step<'_, T> {
    /// Changes the records; if the frame is cancelled on the way they are of no meaning.
    fn carry_out(
        &self,
        change: ListChange,
        chunks: &[Chunk],
        samples: &[T],
        records: &mut Vec<VoxelRecord>,
    ) -> Result<(), StageError> {
        let &Update { volume, frame, .. } = self.to;
        if 0 < change.n_dropped {
            self.drop(chunks, records)?;
        }
        if 0 < change.n_added {
            make_room(chunks, records, frame)?;
            if is_narrow(volume) {
                self.add(chunks, &Normals::<T, f32>::new(volume, samples), records);
            } else {
                self.add(chunks, &Normals::<T, f64>::new(volume, samples), records);
            }
        }
        Ok(frame.check()?)
    }

    fn count(&self, records: &[VoxelRecord]) -> Vec<Chunk> {
        let n_bricks = self.to.brick_ranges.n_bricks();
        let chunk = |chunk_idx: usize| {
            let start = chunk_idx * CHUNK_BRICKS;
            let end = n_bricks.min(start + CHUNK_BRICKS);
            self.count_chunk(start as u32..end as u32, records)
        };
        (0..n_bricks.div_ceil(CHUNK_BRICKS)).into_par_iter().map(chunk).collect()
    }

    fn count_chunk(&self, brick_idxs: Range<u32>, records: &[VoxelRecord]) -> Chunk {
        let first_from = |idx| self.old_bricks.partition_point(|brick| brick.brick_idx < idx);
        let old_bricks = first_from(brick_idxs.start)..first_from(brick_idxs.end);
        let mut old = self.old_bricks[old_bricks.clone()].iter().peekable();
        let n_old = voxels_of(&self.old_bricks[old_bricks.clone()]).len();
        let mut chunk = Chunk { old_bricks, n_old, bricks: Vec::new(), n_kept: 0, n_new: 0 };
        for brick_idx in brick_idxs {
            if self.to.frame.is_cancelled() {
                break;
            }
            let old = old.next_if(|brick| brick.brick_idx == brick_idx);
            let old = old.map_or(&[][..], |brick| &records[brick.voxels()]);
            if self.is_touched(brick_idx) {
                let mask = self.mask(brick_idx);
                let n_kept = old.iter().filter(|record| mask.has(record.slot)).count();
                chunk.push(brick_idx, mask.count(), n_kept);
            } else {
                chunk.push(brick_idx, old.len(), old.len());
            }
        }
        chunk
    }

    fn drop(&self, chunks: &[Chunk], records: &mut Vec<VoxelRecord>) -> Result<(), Cancelled> {
        let tasks = split(chunks, |chunk| chunk.n_old, records);
        tasks.into_par_iter().for_each(|(chunk, records)| self.drop_in_chunk(chunk, records));
        let (mut old_start, mut start) = (0, 0);
        for chunk in chunks {
            self.to.frame.check()?;
            records.copy_within(old_start..old_start + chunk.n_kept, start);
            old_start += chunk.n_old;
            start += chunk.n_kept;
        }
        records.truncate(start);
        // Room is retained for ranges that go to and fro, but not much of it.
        if 4 * records.len() < 3 * records.capacity() {
            records.shrink_to_fit();
        }
        Ok(())
    }

    fn drop_in_chunk(&self, chunk: &Chunk, records: &mut [VoxelRecord]) {
        if chunk.n_dropped() == 0 || self.to.frame.is_cancelled() {
            return;
        }
        let (mut next, mut n_kept) = (0, 0);
        for brick in &self.old_bricks[chunk.old_bricks.clone()] {
            let is_touched = self.is_touched(brick.brick_idx);
            let mask = if is_touched { self.mask(brick.brick_idx) } else { BrickMask::ALL };
            for _ in 0..brick.n_voxels {
                let record = records[next];
                records[n_kept] = record;
                n_kept += usize::from(mask.has(record.slot));
                next += 1;
            }
        }
    }

    fn add<F: Real + Sync>(
        &self,
        chunks: &[Chunk],
        normals: &Normals<'_, T, F>,
        records: &mut [VoxelRecord],
    ) {
        let tasks = split(chunks, |chunk| chunk.n_new, records);
        tasks.into_par_iter().for_each(|(chunk, records)| {
            self.add_in_chunk(chunk, normals, records);
        });
    }

    fn add_in_chunk<F: Real>(
        &self,
        chunk: &Chunk,
        normals: &Normals<'_, T, F>,
        records: &mut [VoxelRecord],
    ) {
        if chunk.n_added() == 0 {
            return;
        }
        let mut kept_end = chunk.n_added();
        for &(brick, n_kept) in &chunk.bricks {
            if self.to.frame.is_cancelled() {
                return;
            }
            let kept_start = kept_end;
            kept_end += usize::from(n_kept);
            let start = brick.first as usize;
            if brick.n_voxels == n_kept {
                records.copy_within(kept_start..kept_end, start);
            } else {
                let mask = self.mask(brick.brick_idx);
                let origin = self.grid.origin(brick.brick_idx);
                let records = &mut records[start..kept_end];
                add_in_brick(&mask, origin, normals, kept_start - start, n_kept.into(), records);
            }
        }
    }

    /// Whether the brick holds values that only the old or only the new ranges have.
    fn is_touched(&self, brick_idx: u32) -> bool {
        let within = self.to.brick_ranges.of_brick(brick_idx as usize);
        let clipped = |range: &IsoRange| [range.lo.max(within.lo), range.hi.min(within.hi)];
        let [old, new] =
            [self.old_ranges, self.to.ranges].map(|ranges| &ranges[met(ranges, within)]);
        !old.iter().map(clipped).eq(new.iter().map(clipped))
    }

    fn mask(&self, brick_idx: u32) -> BrickMask {
        let within = self.to.brick_ranges.of_brick(brick_idx as usize);
        self.membership.of_brick(brick_idx, met(self.to.ranges, within))
    }
}

/// Which of `ranges` (disjoint, rising) have values in common with `within`.
pub(crate) fn met(ranges: &[IsoRange], within: IsoRange) -> Range<usize> {
    let start = ranges.partition_point(|range| range.hi < within.lo);
    start..ranges.partition_point(|range| range.lo <= within.hi).max(start)
}

/// The indices of the voxels of a run of bricks.
fn voxels_of(bricks: &[Brick]) -> Range<usize> {
    match (bricks.first(), bricks.last()) {
        (Some(first), Some(last)) => first.voxels().start..last.voxels().end,
        _ => 0..0,
    }
}

/// Each chunk with its part of `records`.
fn split<'a, 'r>(
    chunks: &'a [Chunk],
    n_voxels: impl Fn(&Chunk) -> usize,
    mut records: &'r mut [VoxelRecord],
) -> Vec<(&'a Chunk, &'r mut [VoxelRecord])> {
    let mut parts = Vec::with_capacity(chunks.len());
    for chunk in chunks {
        let (part, rest) = records.split_at_mut(n_voxels(chunk));
        parts.push((chunk, part));
        records = rest;
    }
    parts
}

/// Moves each chunk's voxels to the end of the slots that the chunk will fill.
fn make_room(
    chunks: &[Chunk],
    records: &mut Vec<VoxelRecord>,
    frame: &FrameHandle,
) -> Result<(), StageError> {
    let n_new = chunks.iter().map(|chunk| chunk.n_new).sum();
    let needed_bytes = (n_new * size_of::<VoxelRecord>()) as u64;
    let no_room = StageError::OutOfMemory { what: "the list of relevant voxels", needed_bytes };
    if records.is_empty() {
        // Zeroed by the system, page by page where threads first write.
        *records = bytemuck::try_zeroed_vec(n_new).map_err(|()| no_room)?;
        return Ok(());
    }
    let mut kept_end = records.len();
    records.try_reserve_exact(n_new - kept_end).map_err(|_| no_room)?;
    while records.len() < n_new {
        frame.check()?;
        records.resize(n_new.min(records.len() + MADE_AT_ONCE), VoxelRecord::default());
    }
    let mut end = n_new;
    for chunk in chunks.iter().rev() {
        frame.check()?;
        records.copy_within(kept_end - chunk.n_kept..kept_end, end - chunk.n_kept);
        kept_end -= chunk.n_kept;
        end -= chunk.n_new;
    }
    Ok(())
}

/// Fills the front of `records` with the voxels of `mask`: those that are there already, `n_kept` from
/// `kept_start`, and new ones with their normals.
pub(crate) fn add_in_brick<T: Ordered, F: Real>(
    mask: &BrickMask,
    [x, y, z]: [usize; 3],
    normals: &Normals<'_, T, F>,
    kept_start: usize,
    n_kept: usize,
    records: &mut [VoxelRecord],
) {
    let kept = BrickMask::of_records(&records[kept_start..kept_start + n_kept]);
    let (mut next_kept, mut n_written) = (kept_start, 0);
    for row in (0..N_ROWS).filter(|&row| mask.rows[row] != 0) {
        let row_normals: RowNormals = if mask.rows[row] == kept.rows[row] {
            [[0; BRICK_SIDE]; 3]
        } else {
            normals.of_row([x, y + row % BRICK_SIDE, z + row / BRICK_SIDE])
        };
        let mut left = mask.rows[row];
        while left != 0 {
            let x = left.trailing_zeros() as usize;
            records[n_written] = if kept.rows[row] >> x & 1 == 1 {
                next_kept += 1;
                records[next_kept - 1]
            } else {
                let normal = [row_normals[0][x], row_normals[1][x], row_normals[2][x]];
                VoxelRecord { slot: (row * BRICK_SIDE + x) as u16, normal }
            };
            n_written += 1;
            left &= left - 1;
        }
    }
}

fn joined(chunks: &[Chunk]) -> Vec<Brick> {
    let mut bricks = Vec::with_capacity(chunks.iter().map(|chunk| chunk.bricks.len()).sum());
    let mut start = 0;
    for chunk in chunks {
        let placed = |&(brick, _): &(Brick, u16)| Brick { first: start + brick.first, ..brick };
        bricks.extend(chunk.bricks.iter().map(placed));
        start += chunk.n_new as u32;
    }
    bricks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More bytes than there can be, for a new list and for one that grows.
    #[test]
    fn list_without_room_is_an_error() {
        let chunk =
            Chunk { old_bricks: 0..0, n_old: 0, bricks: Vec::new(), n_kept: 0, n_new: 1 << 60 };
        for mut records in [vec![], vec![VoxelRecord::default()]] {
            let before = records.clone();
            let made = make_room(std::slice::from_ref(&chunk), &mut records, &FrameHandle::new());
            let what = "the list of relevant voxels";
            assert_eq!(made, Err(StageError::OutOfMemory { what, needed_bytes: 1 << 63 }));
            assert_eq!(records, before);
        }
    }
}
