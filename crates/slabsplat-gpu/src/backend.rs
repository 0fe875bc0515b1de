//! The backend contract on any device: jobs go out as work, and come back as frames.
//!
//! How many splats a frame tosses is known only when the device has counted them. A frame is submitted with
//! room for as many as are likely, or as the last frames had. If that was too few, the counts that
//! come back say so, the room is made, and the job goes out again, before any later frame is handed out. So
//! it is with tiles that have more splats than a dispatch should take on: the job goes out again with more
//! rounds of splatting. And of a frame that left out what was hidden in the frame before: where that is seen,
//! it goes out again with everything.
//!
//! A picture that is left on the device goes there right behind the work that draws it, if the device finds
//! it whole. A job that goes out again leaves its picture again, unless a later frame has gone to the same
//! place: that one is newer.

use crate::device::LOOK_EVERY;
use crate::drawn_by::LastFits;
use crate::frame_memory::FrameMemory;
use crate::frame_params::SplatLayer;
use crate::frame_passes::max_rounds;
use crate::hidden::Hidden;
use crate::job::Job;
use crate::listing::Listing;
use crate::listings::Listings;
use crate::memory::{Memory, backend_error};
use crate::params::{Counts, MAX_LAYERS, MOST_DENSITY_LAYERS};
use crate::surfaces::LastSurfaces;
use crate::voxel_lists::VoxelLists;
use crate::{Destination, Device, DeviceKind, Done, Picture, Work, WorkId};
use slabsplat_backend::{
    Backend, BackendError, Caps, Frame, FrameCost, FramePlan, FrameStats, LayerPlan, Splats,
    StageTime,
};
use slabsplat_core::{Cancelled, FrameHandle, Image, ImageDesc, Method, over};
use std::collections::VecDeque;
use std::sync::Arc;
use std::task::{Poll, Waker};

/// Renders on a device.
#[derive(Debug)]
pub struct GpuBackend<D> {
    caps: Caps,
    device: D,
    memory: Memory,
    listings: Listings,
    lists: VoxelLists,
    surfaces: LastSurfaces,
    fits: LastFits,
    hidden: Hidden,
    frame: FrameMemory,
    /// In the order of submission.
    under_way: VecDeque<UnderWay<D>>,
    done: Vec<(FrameHandle, Result<Frame, BackendError>)>,
}

/// A job whose work was submitted.
#[derive(Debug)]
struct UnderWay<D> {
    /// Its own alone if nobody wants the frame any more.
    frame: FrameHandle,
    job: Job,
    /// Who takes its picture, if it is not read back.
    to: Option<Arc<dyn Destination<D>>>,
    /// Why its picture could not be left there again.
    failed: Option<BackendError>,
    work: WorkId,
    /// Splats that there was room for.
    max_splats: u64,
    /// How often each tile was continued.
    n_rounds: u32,
}

impl<D: Device> GpuBackend<D> {
    /// A backend called `name` (as flags and scene files say it) on `device`.
    pub fn new(name: &'static str, device: D) -> Self {
        let info = device.info();
        Self {
            caps: Caps::new(name, info.name.clone(), Method::ALL).with_cells().with_parts(),
            memory: Memory::default(),
            listings: Listings::default(),
            lists: VoxelLists::new(),
            surfaces: LastSurfaces::default(),
            fits: LastFits::default(),
            hidden: Hidden::default(),
            frame: FrameMemory::new(info),
            under_way: VecDeque::new(),
            done: Vec::new(),
            device,
        }
    }

    /// What executes the frames.
    pub fn device(&self) -> &D {
        &self.device
    }

    /// Begins a frame as [`Backend::submit`] does, whose picture `to` takes, on the device, and which is not
    /// read back: the image of the frame that is taken has no pixels, and `to` has had them before. Of frames
    /// that go to one place the last one stays there. One that is cancelled may still get there, whole, if
    /// the device has begun it.
    ///
    /// # Errors
    /// As those of [`Backend::submit`], and if `to` takes no such picture.
    pub fn submit_into(
        &mut self,
        plan: &FramePlan<'_>,
        frame: &FrameHandle,
        to: &Arc<dyn Destination<D>>,
    ) -> Result<(), BackendError> {
        let ImageDesc { width, height, .. } = plan.image;
        to.check_size([width, height]).map_err(|reason| self.unable(&reason))?;
        if plan.in_front.is_some() {
            return Err(self.unable("what lies in front of a picture is not on the device"));
        }
        let job = self.job_of(plan, frame)?;
        let (work, picture) = self.begin(&job, frame, false)?;
        let taken = to.take(&mut self.device, &picture);
        self.watch(job, frame, work, Some(to.clone()));
        taken.map_err(|error| {
            self.drop_frame(frame);
            backend_error(&self.device, "a picture", &error)
        })
    }

    /// What a plan asks for.
    fn job_of(&mut self, plan: &FramePlan<'_>, frame: &FrameHandle) -> Result<Job, BackendError> {
        check_layers(plan).map_err(|reason| self.unable(&reason))?;
        let (listings, surfaces) = (self.listings.of(plan, frame)?, self.surfaces.of(plan, frame)?);
        let (layers, listings) = levels_of(plan, listings);
        let drawn_by = self.fits.of(plan, &layers);
        let most_voxels = self.frame.splats.most();
        let mut job = Job::new(plan, (&layers, drawn_by), listings, surfaces, most_voxels);
        job.frame.max_visits = max_visits(self.device.info().kind);
        job.sheets_behind = self.hidden.sheets_behind(&job);
        // A list that was begun and not ended is none, so that this is the last chance to leave all as it is.
        frame.check()?;
        Ok(job)
    }

    /// Keeps an eye on a job that was sent out.
    fn watch(
        &mut self,
        job: Job,
        frame: &FrameHandle,
        work: WorkId,
        to: Option<Arc<dyn Destination<D>>>,
    ) {
        let FrameMemory { max_splats, n_rounds, .. } = self.frame;
        let (frame, failed) = (frame.clone(), None);
        self.under_way.push_back(UnderWay { frame, job, to, failed, work, max_splats, n_rounds });
    }

    /// Sends the job of a frame out, and says where its picture will be. Is it to be read back, too?
    fn begin(
        &mut self,
        job: &Job,
        handle: &FrameHandle,
        is_read: bool,
    ) -> Result<(WorkId, Picture), BackendError> {
        let begun = self.try_begin(job, handle, is_read);
        self.hidden.follow(begun.is_ok().then_some(job));
        if begun.is_err() {
            self.lists.forget(&mut self.memory, &mut self.device);
            self.frame.forget(&mut self.memory, &mut self.device);
        }
        begun
    }

    fn try_begin(
        &mut self,
        job: &Job,
        handle: &FrameHandle,
        is_read: bool,
    ) -> Result<(WorkId, Picture), BackendError> {
        let Self { device, memory, lists, frame, .. } = self;
        let mut writes = Vec::new();
        frame.grow_constant(memory, device)?;
        let counts = frame.counts.all();
        let mut passes = lists.passes((memory, device), (job, handle), counts, &mut writes)?;
        frame.prepare((memory, device), job, &mut writes)?;
        passes.extend(frame.passes((memory, device), job, &lists.lists, &mut writes)?);
        let picture = frame.picture(job, device.info());
        let pixels = picture.bands.iter().filter(|_| is_read).map(|band| band.pixels);
        let reads = std::iter::once(counts).chain(pixels).collect();
        let work = Work { writes, passes: passes.into(), reads };
        match device.submit(&work) {
            Ok(work) => Ok((work, picture)),
            Err(error) => Err(backend_error(device, "a frame's transfers", &error)),
        }
    }

    /// Moves what is done from the front of `under_way` to `done`.
    fn collect(&mut self) {
        self.lists.collect(&mut self.device);
        self.done.retain(|(frame, _)| !frame.is_abandoned());
        while let Some(mut first) = self.under_way.pop_front() {
            match self.finish(&mut first) {
                Ok(Poll::Pending) => return self.under_way.push_front(first),
                Ok(Poll::Ready(frame)) => self.done.push((first.frame, Ok(frame))),
                Err(error) => self.done.push((first.frame, Err(error))),
            }
        }
    }

    /// Makes sure that nobody is given a frame, though the device may still be at it.
    fn drop_frame(&mut self, frame: &FrameHandle) {
        self.done.retain(|(done, _)| done != frame);
        for job in self.under_way.iter_mut().filter(|job| job.frame == *frame) {
            job.frame = FrameHandle::new();
        }
    }

    fn knows(&self, frame: &FrameHandle) -> bool {
        self.under_way.iter().any(|job| job.frame == *frame)
            || self.done.iter().any(|(done, _)| done == frame)
    }

    /// The frame of a job, unless its work is not done, or has to be done again.
    fn finish(&mut self, job: &mut UnderWay<D>) -> Result<Poll<Frame>, BackendError> {
        let done = match self.device.poll(job.work) {
            Ok(Poll::Ready(done)) => done,
            Ok(Poll::Pending) => return Ok(Poll::Pending),
            Err(error) => return Err(backend_error(&self.device, "a frame", &error)),
        };
        if let Some(error) = job.failed.take() {
            return Err(error);
        }
        let counts: Counts =
            *bytemuck::from_bytes(&bytemuck::cast_slice(&done.reads[0])[..size_of::<Counts>()]);
        let is_cut = counts.n_cut_tiles != 0;
        if counts.n_faults != 0 || (is_cut && job.job.sheets_behind.is_none()) {
            let reason = "its driver ends loops before they are through, as Mesa's software driver does before \
                          version 23";
            return Err(self.unable(reason));
        }
        let has_room = u64::from(counts.n_tossed) <= job.max_splats;
        if job.frame.is_cancelled() || job.frame.is_abandoned() {
            return Err(Cancelled.into());
        }
        if has_room && counts.n_paused_tiles == 0 && !is_cut {
            if job.job.sheets_behind.is_some() {
                self.hidden.was_right();
            }
            job.frame.reach(1.0);
            return Ok(Poll::Ready(self.frame_of(job, done, &counts)));
        }
        let Self { device, memory, frame, hidden, .. } = self;
        if is_cut {
            hidden.was_wrong();
            job.job.sheets_behind = None;
        } else if has_room {
            let n_bands = frame.picture(&job.job, device.info()).bands.len();
            if max_rounds(n_bands) <= job.n_rounds {
                return Err(self.unable("a tile has more splats than it can take on"));
            }
            frame.n_rounds = frame.n_rounds.max(2 * job.n_rounds);
        } else {
            frame.make_room_for(memory, device, counts.n_tossed.into())?;
        }
        (job.max_splats, job.n_rounds) = (frame.max_splats, frame.n_rounds);
        let picture;
        (job.work, picture) = self.begin(&job.job, &job.frame, job.to.is_none())?;
        if let Some(to) = job.to.as_ref().filter(|to| !self.is_taken_by_later(to)) {
            let taken = to.take(&mut self.device, &picture);
            job.failed = taken.err().map(|e| backend_error(&self.device, "a picture", &e));
        }
        Ok(Poll::Pending)
    }

    /// Whether one of those after the frame that is being finished goes to the same place.
    fn is_taken_by_later(&self, place: &Arc<dyn Destination<D>>) -> bool {
        let is_later = |job: &UnderWay<D>| {
            job.to.as_ref().is_some_and(|to| Arc::ptr_eq(to, place))
                && !job.frame.is_cancelled()
                && !job.frame.is_abandoned()
        };
        self.under_way.iter().any(is_later)
    }

    fn unable(&self, reason: &str) -> BackendError {
        BackendError::Unable { device: self.caps.device.clone(), reason: reason.to_owned() }
    }

    fn frame_of(&self, job: &UnderWay<D>, mut done: Done, counts: &Counts) -> Frame {
        let [width, height] = if job.to.is_none() { job.job.frame.image_size } else { [0; 2] };
        let mut image = Image::from_pixels(width, height, pixels_of(done.reads.split_off(1)));
        if let Some(in_front) = &job.job.in_front {
            lay_behind(in_front, &mut image);
        }
        let wide = |[low, high]: [u32; 2]| u64::from(high) << 32 | u64::from(low);
        let mut stats = FrameStats::default();
        stats.n_voxels = u64::from(counts.n_voxels).saturating_add_signed(job.job.n_more_voxels());
        stats.n_splats = wide(counts.n_splatted);
        stats.n_culled = wide(counts.n_culled);
        stats.n_tiles = counts.n_tiles.into();
        stats.n_saturated_tiles = counts.n_saturated_tiles.into();
        let stages = done.stage_ms.iter().map(|&(name, ms)| StageTime::new(name, ms)).collect();
        let mut cost = FrameCost::new(stages, self.memory.resident_bytes());
        cost.n_hidden = wide(counts.n_hidden);
        Frame::new(image, stats, cost)
    }
}

/// Lays a picture behind another one of its size.
fn lay_behind(in_front: &Image, image: &mut Image) {
    for (pixel, front) in image.pixels_mut().iter_mut().zip(in_front.pixels()) {
        *pixel = over(*front, *pixel);
    }
}

/// The pixels of all bands. A picture of one band, as most are, is not copied.
fn pixels_of(mut bands: Vec<Vec<u32>>) -> Vec<[f32; 4]> {
    let words = if bands.len() == 1 { bands.remove(0) } else { bands.concat() };
    bytemuck::allocation::try_cast_vec(words)
        .unwrap_or_else(|(_, words)| bytemuck::pod_collect_to_vec(&words))
}

/// Splats after which a tile pauses: some tenths of a second at most. Mesa's software driver, before version
/// 23, silently ends all loops of a thread after 65535 turns.
fn max_visits(kind: DeviceKind) -> u32 {
    match kind {
        // A visit of a sheet that holds next to nothing takes a dozen turns of all loops together.
        DeviceKind::Software => 1 << 12,
        _ => 1 << 20,
    }
}

/// Why there are no shaders for a plan.
fn check_layers(plan: &FramePlan<'_>) -> Result<(), String> {
    let n_layers = plan.layers.len();
    let is_of_densities = |layer: &LayerPlan<'_>| matches!(layer.splats, Splats::Densities(_));
    if MOST_DENSITY_LAYERS < n_layers && plan.layers.iter().any(is_of_densities) {
        return Err(format!(
            "its shaders draw densities of {MOST_DENSITY_LAYERS} layers at a time, not of {n_layers}"
        ));
    }
    if (MAX_LAYERS as usize) < n_layers {
        return Err(format!("its shaders draw {MAX_LAYERS} layers at a time, not {n_layers}"));
    }
    Ok(())
}

/// The levels that are listed of a plan's layers, in their order, as layers of their own.
fn levels_of<'a>(
    plan: &'a FramePlan<'_>,
    listings: Vec<Vec<Listing>>,
) -> (Vec<SplatLayer<'a, 'a>>, Vec<Listing>) {
    let of_layer = |(layer, listings): (&'a LayerPlan<'_>, Vec<Listing>)| {
        listings.into_iter().filter_map(move |listing| {
            let plan = layer.levels().nth(listing.level())?;
            Some(((plan, &plan.splats), listing))
        })
    };
    plan.layers.iter().zip(listings).flat_map(of_layer).unzip()
}

impl<D: Device> Backend for GpuBackend<D> {
    fn caps(&self) -> &Caps {
        &self.caps
    }

    fn submit(&mut self, plan: &FramePlan<'_>, frame: &FrameHandle) -> Result<(), BackendError> {
        let job = self.job_of(plan, frame)?;
        let (work, _) = self.begin(&job, frame, true)?;
        self.watch(job, frame, work, None);
        Ok(())
    }

    fn poll_image(&mut self, frame: &FrameHandle) -> Result<Poll<Frame>, BackendError> {
        self.collect();
        if !self.knows(frame) {
            return Err(BackendError::UnknownFrame);
        }
        if frame.is_cancelled() {
            self.drop_frame(frame);
            return Err(Cancelled.into());
        }
        let idx = self.done.iter().position(|(done, _)| done == frame);
        let Some(idx) = idx else { return Ok(Poll::Pending) };
        self.done.swap_remove(idx).1.map(Poll::Ready)
    }

    fn wait_image(&mut self, frame: &FrameHandle) -> Result<Frame, BackendError> {
        loop {
            if let Poll::Ready(frame) = self.poll_image(frame)? {
                return Ok(frame);
            }
            if cfg!(target_family = "wasm") {
                return Err(BackendError::CannotWait);
            }
            if let Some(first) = self.under_way.front() {
                self.device.wait(first.work, LOOK_EVERY);
            }
        }
    }

    fn wake_when_done(&mut self, _: &FrameHandle, waker: &Waker) {
        // Frames are done in their order.
        match self.under_way.front() {
            Some(first) => self.device.wake_when_done(first.work, waker),
            None => waker.wake_by_ref(),
        }
    }
}

#[cfg(test)]
mod tests;
