//! A frame as data: the passes that make a picture of the relevant voxels.

use crate::chunks::Chunks;
use crate::frame_memory::{FrameMemory, bands};
use crate::job::Job;
use crate::memory::{Buffer, Memory};
use crate::params::{COUNT_SPLATS, RECORD_BYTES, SPLAT_BYTES, Step, TILE_SIDE, flag};
use crate::pass_list::{MAX_STEPS, PassList, n_groups};
use crate::sums::{BLOCK, bits_for};
use crate::voxel_list::VoxelList;
use crate::{Device, DeviceInfo, Pass, Write};
use slabsplat_backend::BackendError;
use slabsplat_shaders::{DEPTH_KEY, TALLY, TILE_LIMITS, TILE_RANGES, TOSS_COUNT, TOSS_EMIT};

/// Rounds of splatting that a list has room for beside all other passes. On a device that is none but a
/// program, that is 16 million splats a tile.
pub(crate) fn max_rounds(n_bands: usize) -> u32 {
    (MAX_STEPS / 2 / n_bands as u64) as u32
}

const _: () = assert!(RECORD_BYTES == SPLAT_BYTES, "chunks of both have as many elements");

impl FrameMemory {
    /// The stages of a frame, from relevant voxels to pixels.
    pub(crate) fn passes<D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        job: &Job,
        lists: &[VoxelList],
        writes: &mut Vec<Write<'_>>,
    ) -> Result<Vec<Pass>, BackendError> {
        self.voxels.restart();
        self.tiles.restart();
        let mut passes = self.steps.list(memory, device)?;
        if !job.layers.is_empty() {
            passes.begin("project");
            self.push_limits(job, &mut passes);
            self.push_project(job, lists, &mut passes);
            passes.begin("sort");
            self.push_depth_sort(job, &lists[0].records, &mut passes);
            passes.begin("toss");
            self.push_toss(job, &mut passes);
        }
        passes.begin("splat");
        self.push_splat(job, device.info(), &mut passes);
        Ok(self.steps.finish(passes, writes))
    }

    /// What is left out of the tiles, if it was hidden in the frame before.
    fn push_limits(&self, job: &Job, passes: &mut PassList) {
        let n_tiles = job.n_tiles();
        let step = Step {
            n_elements: n_tiles,
            follows_last: flag(job.sheets_behind.is_some()),
            sheets_behind: job.sheets_behind.unwrap_or(0),
            ..Step::default()
        };
        let bindings = [self.frame.all(), self.work.all()];
        passes.push(&TILE_LIMITS, &bindings, step, n_groups(n_tiles.into(), 256));
    }

    /// A pass for each run of voxels of a layer whose records are in one chunk, and whose splats are.
    fn push_project(&self, job: &Job, lists: &[VoxelList], passes: &mut PassList) {
        let [frame, layers, rects, counts, tiles] =
            [&self.frame, &self.layers, &self.rects, &self.counts, &self.work].map(Buffer::all);
        let (keys, order, tables) = (self.voxels.keys(), self.voxels.values(), self.tables.all());
        for (idx, (layer, list)) in job.layers.iter().zip(lists).enumerate() {
            let first_voxel = u64::from(job.params[idx].first_voxel);
            for (first, n, records) in list.records.filled(layer.max_voxels) {
                let mut start = first;
                while start < first + n {
                    let (splats, n_in_chunk) = self.splats.chunk_of(first_voxel + start);
                    let n_elements = n_in_chunk.min(first + n - start);
                    let step = Step {
                        first: start as u32,
                        n_elements: n_elements as u32,
                        count_slot: list.count_slot,
                        chunk_bits: self.splats.bits,
                        layer: idx as u32,
                        ..Step::default()
                    };
                    let bindings =
                        [frame, layers, tables, records, splats, keys, order, rects, counts, tiles];
                    passes.push(layer.projected_by, &bindings, step, n_groups(n_elements, 256));
                    start += n_elements;
                }
            }
        }
    }

    /// Sorts the voxels by sheet, or, where there are no sheets, by depth and then by position.
    fn push_depth_sort(&mut self, job: &Job, records: &Chunks, passes: &mut PassList) {
        let (n_voxels, counts) = (job.max_voxels(), self.counts.all());
        let keys = (n_voxels, job.count_slot());
        let Some(depth_sort) = &job.depth_sort else {
            return self.voxels.sort(passes, counts, keys, bits_for(job.frame.n_sheets));
        };
        // The least important first: right, up, depth.
        for axis in 0..3 {
            for (word, n_bits) in
                [(0, depth_sort.n_bits.min(32)), (4, depth_sort.n_bits.saturating_sub(32))]
            {
                if n_bits == 0 {
                    continue;
                }
                let step = Step {
                    n_elements: n_voxels as u32,
                    shift: axis | word,
                    count_slot: job.count_slot(),
                    chunk_bits: records.bits,
                    ..Step::default()
                };
                let (order, keys_at) = (self.voxels.values(), self.voxels.keys());
                let mut bindings = vec![self.depth.all(), order, keys_at, counts];
                bindings.extend(records.all());
                passes.push(&DEPTH_KEY, &bindings, step, n_groups(n_voxels, 256));
                self.voxels.sort(passes, counts, keys, n_bits);
            }
        }
    }

    fn push_toss(&mut self, job: &Job, passes: &mut PassList) {
        let (n_voxels, counts) = (job.max_voxels(), self.counts.all());
        let n_blocks = n_groups(n_voxels, BLOCK);
        let (order, rects) = (self.voxels.values(), self.rects.all());
        let [sums, totals] = [&self.tossed.elements, &self.tossed.totals].map(Buffer::all);
        let (n_elements, count_slot) = (n_voxels as u32, job.count_slot());
        let step = Step { n_elements, count_slot, n_blocks, ..Step::default() };
        passes.push(&TOSS_COUNT, &[order, rects, sums, counts], step, n_blocks);
        self.tossed.scan(passes, counts, u64::from(n_blocks), COUNT_SPLATS);
        let step = Step { n_blocks: self.max_splats as u32, ..step };
        let (tiles, voxels) = (self.tiles.keys(), self.tiles.values());
        let bindings = [self.frame.all(), order, rects, sums, totals, tiles, voxels, counts];
        passes.push(&TOSS_EMIT, &bindings, step, n_blocks);
        let keys = (self.max_splats, COUNT_SPLATS);
        self.tiles.sort(passes, counts, keys, bits_for(job.n_tiles()));
    }

    fn push_splat(&self, job: &Job, info: &DeviceInfo, passes: &mut PassList) {
        let n_tiles = job.n_tiles();
        let step =
            Step { n_elements: n_tiles, n_blocks: self.max_splats as u32, ..Step::default() };
        let bindings = [self.tiles.keys(), self.work.all(), self.counts.all()];
        passes.push(&TILE_RANGES, &bindings, step, n_groups(n_tiles.into(), 256));
        let frame = &job.frame;
        let bands = bands(job, info);
        let n_rounds = self.n_rounds.min(max_rounds(bands.len()));
        let rounds = (0..n_rounds).flat_map(|_| bands.iter().zip(&self.bands));
        for (band, pixels) in rounds {
            let tile_rows = band.n_rows.div_ceil(TILE_SIDE);
            let n_tiles = tile_rows * frame.n_tiles[0];
            let step = Step {
                first: band.first_row / TILE_SIDE * frame.n_tiles[0],
                n_elements: n_tiles,
                chunk_bits: self.splats.bits,
                first_sample: band.first_row,
                first_surface: job.first_surface(),
                ..Step::default()
            };
            let [frame, layers, work] = [&self.frame, &self.layers, &self.work].map(Buffer::all);
            let (voxels, tables) = (self.tiles.values(), self.tables.all());
            let mut bindings = vec![frame, layers];
            if job.densities.is_some() {
                bindings.push(self.densities.all());
            }
            bindings.extend([voxels, tables, work, pixels.all()]);
            bindings.extend(self.splats.all());
            passes.push(job.splats_by, &bindings, step, n_tiles);
        }
        let step =
            Step { n_elements: n_tiles, n_blocks: self.max_splats as u32, ..Step::default() };
        passes.push(&TALLY, &[self.work.all(), self.counts.all()], step, 1);
    }
}
