//! The buffers of a frame: what is in them, how large they are, what is written and read back.

use crate::chunks::Chunks;
use crate::job::Job;
use crate::memory::{Buffer, Memory, too_large};
use crate::params::{
    COUNT_IS_WHOLE, COUNTS_BYTES, Counts, Densities, DepthParams, Frame, Layer, MAX_LAYERS,
    MOST_DENSITY_LAYERS, SPLAT_BYTES, TILE_SIDE, TILE_WORK_BYTES,
};
use crate::pass_list::{StepBuffer, n_groups};
use crate::sums::{BLOCK, Sorter, Sums};
use crate::tables::TablesBuffer;
use crate::{Device, DeviceInfo, Picture, PictureBand, Slice, Write};
use slabsplat_backend::BackendError;

/// Everything that a frame uses beside the list of relevant voxels.
#[derive(Debug)]
pub(crate) struct FrameMemory {
    pub(crate) frame: Buffer,
    pub(crate) layers: Buffer,
    pub(crate) depth: Buffer,
    pub(crate) densities: Buffer,
    pub(crate) steps: StepBuffer,
    pub(crate) counts: Buffer,
    pub(crate) tables: TablesBuffer,
    pub(crate) splats: Chunks,
    pub(crate) rects: Buffer,
    /// The voxels, front to back.
    pub(crate) voxels: Sorter,
    pub(crate) tossed: Sums,
    /// The splats by tile.
    pub(crate) tiles: Sorter,
    /// How many splats there is room for.
    pub(crate) max_splats: u64,
    pub(crate) work: Buffer,
    /// How often each tile is continued.
    pub(crate) n_rounds: u32,
    /// The picture, in bands of whole tiles.
    pub(crate) bands: Vec<Buffer>,
}

/// Rows of the picture in one buffer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    pub(crate) first_row: u32,
    pub(crate) n_rows: u32,
}

/// Bytes of a pixel.
const PIXEL_BYTES: u64 = 16;

impl FrameMemory {
    pub(crate) fn new(info: &DeviceInfo) -> Self {
        Self {
            frame: Buffer::new("frame parameters"),
            layers: Buffer::new("layer parameters"),
            depth: Buffer::new("depth parameters"),
            densities: Buffer::new("density parameters"),
            steps: StepBuffer::new(),
            counts: Buffer::new("counts"),
            tables: TablesBuffer::new(),
            splats: Chunks::new("projected voxels", SPLAT_BYTES, info),
            rects: Buffer::new("tiles touched by voxels"),
            voxels: Sorter::new(["voxel keys", "voxel order"]),
            tossed: Sums::new("tossed counts", "tossed totals"),
            tiles: Sorter::new(["tiles of splats", "voxels of splats"]),
            max_splats: 0,
            work: Buffer::new("tiles"),
            n_rounds: 1,
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
        memory.grow(device, &mut self.layers, u64::from(MAX_LAYERS) * size_of::<Layer>() as u64)?;
        memory.grow(device, &mut self.counts, COUNTS_BYTES)
    }

    /// Sees to it that the job's buffers are large enough, and writes what is new.
    pub(crate) fn prepare<'a, D: Device>(
        &mut self,
        (memory, device): (&mut Memory, &mut D),
        job: &'a Job,
        writes: &mut Vec<Write<'a>>,
    ) -> Result<(), BackendError> {
        let n_voxels = job.max_voxels();
        self.splats.grow(memory, device, n_voxels)?;
        check_binding(device, "tiles touched by voxels", 8 * n_voxels)?;
        memory.grow(device, &mut self.rects, 8 * n_voxels)?;
        self.voxels.grow(memory, device, n_voxels)?;
        self.tossed.grow(memory, device, u64::from(n_groups(n_voxels, BLOCK)))?;
        self.make_room(memory, device, job.expected_splats())?;
        let work_bytes = TILE_WORK_BYTES * u64::from(job.n_tiles());
        check_binding(device, "tiles", work_bytes)?;
        memory.grow(device, &mut self.work, work_bytes)?;
        let bands = bands(job, device.info());
        self.bands.resize_with(self.bands.len().max(bands.len()), || Buffer::new("pixels"));
        for (band, buffer) in bands.iter().zip(&mut self.bands) {
            memory.grow(device, buffer, job.n_held() * band.n_bytes(&job.frame))?;
        }
        self.tables.write((memory, device), job, writes)?;
        if job.densities.is_some() {
            let size = MOST_DENSITY_LAYERS * size_of::<Densities>();
            memory.grow(device, &mut self.densities, size as u64)?;
        }
        let mut write = |buffer: &Buffer, bytes: &'a [u8]| {
            writes.push(Write { buffer: buffer.all().buffer, offset: 0, bytes: bytes.into() });
        };
        write(&self.frame, job.frame.bytes_in_use());
        if job.layers.is_empty() {
            // No voxel counts them.
            write(&self.counts, &[0; size_of::<Counts>()]);
        } else {
            write(&self.layers, bytemuck::cast_slice(&job.params));
        }
        if let Some(densities) = &job.densities {
            write(&self.densities, bytemuck::cast_slice(&densities.params));
        }
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
        memory.free_all(device, self.tiles.buffers());
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

    /// Gives everything back. What was promised did not happen, so the next job begins anew.
    pub(crate) fn forget<D: Device>(&mut self, memory: &mut Memory, device: &mut D) {
        self.max_splats = 0;
        self.n_rounds = 1;
        memory.free_all(device, self.splats.buffers().chain(self.tossed.buffers()));
        memory.free_all(device, self.voxels.buffers().chain(self.tiles.buffers()));
        memory.free_all(device, self.bands.iter_mut());
        let others = [
            &mut self.frame,
            &mut self.layers,
            &mut self.depth,
            &mut self.densities,
            self.steps.emptied(),
            &mut self.counts,
            self.tables.emptied(),
            &mut self.rects,
            &mut self.work,
        ];
        memory.free_all(device, others.into_iter());
    }

    /// The picture of a job, where its passes leave it.
    pub(crate) fn picture(&self, job: &Job, info: &DeviceInfo) -> Picture {
        let band = |(band, buffer): (Band, &Buffer)| PictureBand {
            rows: band.first_row..band.first_row + band.n_rows,
            pixels: Slice { size: band.n_bytes(&job.frame), ..buffer.all() },
        };
        Picture {
            size: job.frame.image_size,
            bands: bands(job, info).into_iter().zip(&self.bands).map(band).collect(),
            counts: self.counts.all(),
            is_whole_at: COUNT_IS_WHOLE,
        }
    }
}

impl Band {
    fn n_bytes(&self, frame: &Frame) -> u64 {
        u64::from(self.n_rows) * u64::from(frame.image_size[0]) * PIXEL_BYTES
    }
}

/// The bands of a picture: as many rows of tiles as can be bound, with all that their pixels hold.
pub(crate) fn bands(job: &Job, info: &DeviceInfo) -> Vec<Band> {
    let [width, height] = job.frame.image_size;
    let most = info.max_binding_bytes.min(info.max_buffer_bytes);
    let tile_row_bytes = u64::from(width) * u64::from(TILE_SIDE) * PIXEL_BYTES * job.n_held();
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
