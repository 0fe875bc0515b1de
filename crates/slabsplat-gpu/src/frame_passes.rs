//! A frame as data: the buffers that it uses, and the passes that make the picture of them.

use crate::chunks::Chunks;
use crate::job::{Job, Table};
use crate::memory::{Buffer, Memory, too_large};
use crate::params::{
    COUNT_SPLATS, COUNT_VOXELS, Counts, DepthParams, Frame, SPLAT_BYTES, Step, TILE_SIDE,
    TILE_WORK_BYTES,
};
use crate::pass_list::{PassList, StepBuffer, n_groups};
use crate::sums::{BLOCK, Sorter, Sums, bits_for};
use crate::{Device, DeviceInfo, Pass, Slice, Write};
use slabsplat_backend::BackendError;
use slabsplat_shaders::{DEPTH_KEY, PROJECT, SPLAT, TALLY, TILE_RANGES, TOSS_COUNT, TOSS_EMIT};

/// Everything that a frame uses beside the list of relevant voxels.
#[derive(Debug)]
pub(crate) struct FrameMemory {
    frame: Buffer,
    depth: Buffer,
    steps: StepBuffer,
    pub(crate) counts: Buffer,
    table: Buffer,
    table_of: Option<Table>,
    splats: Chunks,
    rects: Buffer,
    /// The voxels, front to back.
    voxels: Sorter,
    tossed: Sums,
    /// The splats by tile.
    tiles: Sorter,
    /// How many splats there is room for.
    pub(crate) max_splats: u64,
    work: Buffer,
    /// The picture, in bands of whole tiles.
    bands: Vec<Buffer>,
}

/// Rows of the picture in one buffer.
#[derive(Clone, Copy, Debug)]
struct Band {
    first_row: u32,
    n_rows: u32,
}

/// Bytes of a pixel.
const PIXEL_BYTES: u64 = 16;

impl FrameMemory {
    pub(crate) fn new(info: &DeviceInfo) -> Self {
        Self {
            frame: Buffer::new("frame parameters"),
            depth: Buffer::new("depth parameters"),
            steps: StepBuffer::new(),
            counts: Buffer::new("counts"),
            table: Buffer::new("section table"),
            table_of: None,
            splats: Chunks::new("projected voxels", SPLAT_BYTES, info),
            rects: Buffer::new("tiles touched by voxels"),
            voxels: Sorter::new(["voxel keys", "voxel order"]),
            tossed: Sums::new("tossed counts", "tossed totals"),
            tiles: Sorter::new(["tiles of splats", "voxels of splats"]),
            max_splats: 0,
            work: Buffer::new("tiles"),
            bands: Vec::new(),
        }
    }

    /// Makes the buffers that every frame has, whatever it shows.
    pub(crate) fn grow_constant<D: Device>(
        &mut self,
        memory: &mut Memory,
        device: &mut D,
    ) -> Result<(), BackendError> {
        memory.grow(device, &mut self.frame, size_of::<Frame>() as u64)?;
        memory.grow(device, &mut self.depth, size_of::<DepthParams>() as u64)?;
        memory.grow(device, &mut self.counts, size_of::<Counts>() as u64)
    }

    /// Sees to it that the job's buffers are large enough, and writes what is new.
    pub(crate) fn prepare<'a, D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        job: &'a Job,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<(), BackendError> {
        let n_voxels = job.max_voxels;
        self.splats.grow(memory, device, n_voxels)?;
        check_binding(device, "tiles touched by voxels", 8 * n_voxels)?;
        memory.grow(device, &mut self.rects, 8 * n_voxels)?;
        self.voxels.grow(memory, device, n_voxels)?;
        self.tossed.grow(memory, device, u64::from(n_groups(n_voxels, BLOCK)))?;
        self.make_room(memory, device, job.expected_splats())?;
        memory.grow(device, &mut self.work, TILE_WORK_BYTES * u64::from(job.n_tiles()))?;
        let bands = bands(&job.frame, device.info());
        self.bands.resize_with(self.bands.len().max(bands.len()), || Buffer::new("pixels"));
        for (band, buffer) in bands.iter().zip(&mut self.bands) {
            memory.grow(device, buffer, band.n_bytes(&job.frame))?;
        }
        self.write_table(memory, device, job, writes)?;
        let mut write = |buffer: &Buffer, bytes: &'a [u8]| {
            writes.push(Write { buffer: buffer.all().buffer, offset: 0, bytes: bytes.into() });
        };
        write(&self.frame, bytemuck::bytes_of(&job.frame));
        if let Some(sort) = &job.depth_sort {
            write(&self.depth, bytemuck::bytes_of(&sort.params));
        }
        Ok(())
    }

    /// Sees to it that `n_splats` can be tossed, or, if that is only a guess, as many as can be bound.
    fn make_room<D: Device>(
        &mut self,
        memory: &mut Memory,
        device: &mut D,
        n_splats: u64,
    ) -> Result<(), BackendError> {
        let n_splats = n_splats.clamp(u64::from(BLOCK), max_splats(device.info()));
        if n_splats <= self.max_splats {
            return Ok(());
        }
        self.max_splats = 0;
        self.tiles.free(memory, device);
        self.tiles.grow(memory, device, n_splats)?;
        self.max_splats = n_splats;
        Ok(())
    }

    /// Makes room for a number of splats that a frame was found to have.
    pub(crate) fn make_room_for<D: Device>(
        &mut self,
        memory: &mut Memory,
        device: &mut D,
        n_splats: u64,
    ) -> Result<(), BackendError> {
        check_binding(device, "splats on tiles", 4 * n_splats)?;
        self.make_room(memory, device, n_splats + n_splats / 4)
    }

    fn write_table<'a, D: Device>(
        &mut self,
        memory: &mut Memory,
        device: &mut D,
        job: &Job,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<(), BackendError> {
        if self.table_of.as_ref().is_some_and(|table| table.is(&job.table)) {
            return Ok(());
        }
        self.table_of = None;
        let (quads, _) = job.table.quads();
        let bytes: &[u8] = bytemuck::cast_slice(&quads);
        check_binding(device, "section table", bytes.len() as u64)?;
        memory.grow(device, &mut self.table, bytes.len() as u64)?;
        let buffer = self.table.all().buffer;
        writes.push(Write { buffer, offset: 0, bytes: bytes.to_vec().into() });
        self.table_of = Some(job.table.clone());
        Ok(())
    }

    /// What was promised did not happen: the next job begins anew.
    pub(crate) fn forget(&mut self) {
        self.table_of = None;
        self.steps.forget();
    }

    /// The stages of a frame, from relevant voxels to pixels.
    pub(crate) fn passes<D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        job: &Job,
        records: &Chunks,
        writes: &mut Vec<Write<'_>>,
    ) -> Result<Vec<Pass>, BackendError> {
        self.voxels.restart();
        self.tiles.restart();
        let mut passes = self.steps.list(memory, device)?;
        passes.begin("project");
        self.push_project(job, records, &mut passes);
        passes.begin("sort");
        self.push_depth_sort(job, records, &mut passes);
        passes.begin("toss");
        self.push_toss(job, &mut passes);
        passes.begin("splat");
        self.push_splat(job, device.info(), &mut passes);
        Ok(self.steps.finish(passes, writes))
    }

    fn push_project(&self, job: &Job, records: &Chunks, passes: &mut PassList) {
        let n_voxels = job.max_voxels;
        for ((first, n, records), (_, _, splats)) in
            records.filled(n_voxels).zip(self.splats.filled(n_voxels))
        {
            let (keys, order) = (self.voxels.keys(), self.voxels.values());
            let [frame, rects, counts] = [&self.frame, &self.rects, &self.counts].map(Buffer::all);
            let bindings = [frame, records, splats, keys, order, rects, counts];
            let step = Step { first: first as u32, n_elements: n as u32, ..Step::default() };
            passes.push(&PROJECT, &bindings, step, n_groups(n, 256));
        }
    }

    /// Sorts the voxels by sheet, or, where there are no sheets, by depth and then by place.
    fn push_depth_sort(&mut self, job: &Job, records: &Chunks, passes: &mut PassList) {
        let (n_voxels, counts) = (job.max_voxels, self.counts.all());
        let keys = (n_voxels, COUNT_VOXELS);
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
        let (n_voxels, counts) = (job.max_voxels, self.counts.all());
        let n_blocks = n_groups(n_voxels, BLOCK);
        let (order, rects) = (self.voxels.values(), self.rects.all());
        let [sums, totals] = [&self.tossed.elements, &self.tossed.totals].map(Buffer::all);
        let n_elements = n_voxels as u32;
        let step = Step { n_elements, n_blocks, ..Step::default() };
        passes.push(&TOSS_COUNT, &[order, rects, sums, counts], step, n_blocks);
        self.tossed.scan(passes, counts, u64::from(n_blocks), COUNT_SPLATS);
        let step = Step { n_elements, n_blocks: self.max_splats as u32, ..Step::default() };
        let (tiles, voxels) = (self.tiles.keys(), self.tiles.values());
        let bindings = [self.frame.all(), order, rects, sums, totals, tiles, voxels, counts];
        passes.push(&TOSS_EMIT, &bindings, step, n_blocks);
        let keys = (self.max_splats, COUNT_SPLATS);
        self.tiles.sort(passes, counts, keys, bits_for(job.n_tiles()));
        let step =
            Step { n_elements: job.n_tiles(), n_blocks: self.max_splats as u32, ..Step::default() };
        let bindings = [self.tiles.keys(), self.work.all(), counts];
        passes.push(&TILE_RANGES, &bindings, step, n_groups(job.n_tiles().into(), 256));
    }

    fn push_splat(&self, job: &Job, info: &DeviceInfo, passes: &mut PassList) {
        let frame = &job.frame;
        for (band, pixels) in bands(frame, info).iter().zip(&self.bands) {
            let tile_rows = band.n_rows.div_ceil(TILE_SIDE);
            let n_tiles = tile_rows * frame.n_tiles[0];
            let step = Step {
                first: band.first_row / TILE_SIDE * frame.n_tiles[0],
                n_elements: n_tiles,
                chunk_bits: self.splats.bits,
                first_sample: band.first_row,
                ..Step::default()
            };
            let (voxels, table, work) = (self.tiles.values(), self.table.all(), self.work.all());
            let mut bindings = vec![self.frame.all(), voxels, table, work, pixels.all()];
            bindings.extend(self.splats.all());
            passes.push(&SPLAT, &bindings, step, n_tiles);
        }
        let step = Step { n_elements: job.n_tiles(), ..Step::default() };
        passes.push(&TALLY, &[self.work.all(), self.counts.all()], step, 1);
    }

    /// What is read back: the counts, then the picture from the top.
    pub(crate) fn reads(&self, job: &Job, info: &DeviceInfo) -> Vec<Slice> {
        let counts = self.counts.all();
        let bands = bands(&job.frame, info);
        let band = |(band, buffer): (&Band, &Buffer)| Slice {
            size: band.n_bytes(&job.frame),
            ..buffer.all()
        };
        std::iter::once(counts).chain(bands.iter().zip(&self.bands).map(band)).collect()
    }
}

impl Band {
    fn n_bytes(&self, frame: &Frame) -> u64 {
        u64::from(self.n_rows) * u64::from(frame.image_size[0]) * PIXEL_BYTES
    }
}

/// The bands of a picture: as many rows of tiles as can be bound.
fn bands(frame: &Frame, info: &DeviceInfo) -> Vec<Band> {
    let [width, height] = frame.image_size;
    let most = info.max_binding_bytes.min(info.max_buffer_bytes);
    let tile_row_bytes = u64::from(width) * u64::from(TILE_SIDE) * PIXEL_BYTES;
    let n_tile_rows = (most / tile_row_bytes).clamp(1, u64::from(height.div_ceil(TILE_SIDE)));
    let n_rows = n_tile_rows as u32 * TILE_SIDE;
    let band = |first_row: u32| Band { first_row, n_rows: n_rows.min(height - first_row) };
    (0..height).step_by(n_rows as usize).map(band).collect()
}

/// Splats that can be bound, a word each.
fn max_splats(info: &DeviceInfo) -> u64 {
    let words = info.max_binding_bytes.min(info.max_buffer_bytes) / 4;
    // They are counted in 32 bits, and a sum of all ones says that there are too many.
    words.min(u64::from(u32::MAX - 1))
}

fn check_binding<D: Device>(device: &D, what: &'static str, size: u64) -> Result<(), BackendError> {
    let most = device.info().max_binding_bytes.min(device.info().max_buffer_bytes);
    if size <= most { Ok(()) } else { Err(too_large(device, what, size, most)) }
}
