//! A picture of a scene's files by all ranks.
//!
//! ```text
//! one rank of each computer unpacks what cannot be read in boxes, and all there read what it unpacked
//! each rank looks at a part of the volumes and reads some planes of an overview, and has those of all
//! all cut the same k-d tree, a box for each rank, of as many relevant voxels as far as the overview tells
//! each rank reads its box and draws it before nothing, box by box within its memory
//! all lay their pictures over each other (`compositing`); rank 0 puts the background behind
//! ```
//!
//! After each of these steps all ranks agree that all is well.

use crate::collective::{agree, all_gather, gather};
use crate::communicator::while_beating;
use crate::{Communicator, MpiError, RankReport, composite, samples};
use slabsplat::io::{IoError, SceneFile};
use slabsplat::{
    DividedError, Exchange, FrameHandle, FrameStats, Picture, Samples, SharedDesc, SharedScene,
};
use std::time::Instant;

/// A scene of files that all ranks draw together.
#[derive(Debug)]
pub struct DistributedScene {
    shared: SharedScene,
}

/// A picture, and what it took.
#[derive(Debug)]
#[non_exhaustive]
pub struct DistributedPicture {
    /// Finished as any picture is.
    pub picture: Picture,
    /// Of each rank.
    pub ranks: Vec<RankReport>,
}

impl DistributedScene {
    /// Opens a scene on all ranks, each as `desc` says.
    ///
    /// # Errors
    /// If any rank cannot, on all.
    pub fn open(
        comm: &dyn Communicator,
        file: &SceneFile,
        desc: &SharedDesc,
    ) -> Result<Self, MpiError> {
        let opened = SharedScene::open(file, desc, &mut Ranks(comm));
        Ok(Self { shared: agreed(comm, opened)? })
    }

    /// What this rank has of it.
    pub fn shared(&self) -> &SharedScene {
        &self.shared
    }

    /// Draws and composites it: the picture is on rank 0, others get nothing.
    ///
    /// # Errors
    /// If any rank cannot, or the frame is cancelled on any, on all.
    pub fn picture(
        &self,
        comm: &dyn Communicator,
        frame: &FrameHandle,
    ) -> Result<Option<DistributedPicture>, MpiError> {
        let before = comm.traffic();
        let mut report = self.report(comm);
        let started = Instant::now();
        let drawn = while_beating(comm, || self.shared.frame(frame))?;
        report.drawing_secs = started.elapsed().as_secs_f64();
        let (drawn, cost) = agreed(comm, drawn)?;
        report.waiting_secs = started.elapsed().as_secs_f64() - report.drawing_secs;
        report.add_drawn(&drawn.stats, &cost);
        report.n_pixels = drawn.image.pixels().iter().filter(|p| **p != [0.0; 4]).count() as u64;
        let started = Instant::now();
        let image = composite(comm, &drawn.image, &self.shared.order())?;
        report.compositing_secs = started.elapsed().as_secs_f64();
        report.add_sent(comm.traffic().since(before));
        let ranks = reports(comm, &report)?;
        let stats = all_stats(comm, &drawn.stats)?;
        let picture = image.map(|image| self.shared.finished(image, stats)).transpose();
        let picture = agreed(comm, picture)?;
        Ok(picture.map(|picture| DistributedPicture { picture, ranks }))
    }

    fn report(&self, comm: &dyn Communicator) -> RankReport {
        let own = self.shared.box_of(comm.rank());
        let n_voxels_in_box =
            own.map_or(0, |of| of.iter().map(|range| range.len() as u64).product());
        RankReport {
            node: comm.node(),
            n_threads: rayon::current_num_threads() as u64,
            n_voxels_in_box,
            memory_bytes: self.shared.scene().memory_bytes(),
            ..RankReport::default()
        }
    }
}

/// Those of all ranks, on rank 0.
fn reports(comm: &dyn Communicator, own: &RankReport) -> Result<Vec<RankReport>, MpiError> {
    let of_all = gather(comm, own.to_bytes())?.unwrap_or_default().into_iter().enumerate();
    let read = of_all.map(|(rank, bytes)| {
        RankReport::from_bytes(&bytes).ok_or(MpiError::Malformed { rank, what: "report" })
    });
    read.collect()
}

/// What all ranks drew, on rank 0.
fn all_stats(comm: &dyn Communicator, own: &FrameStats) -> Result<FrameStats, MpiError> {
    let FrameStats { n_voxels, n_occluded, n_splats, n_culled, n_tiles, n_saturated_tiles, .. } =
        *own;
    let counts = [n_voxels, n_occluded, n_splats, n_culled, n_tiles, n_saturated_tiles];
    let bytes = counts.iter().flat_map(|count| count.to_le_bytes()).collect();
    let mut sums = [0_u64; 6];
    for (rank, bytes) in gather(comm, bytes)?.unwrap_or_default().into_iter().enumerate() {
        let (counts, []) = bytes.as_chunks() else {
            return Err(MpiError::Malformed { rank, what: "counts" });
        };
        sums.iter_mut().zip(counts).for_each(|(sum, of)| *sum += u64::from_le_bytes(*of));
    }
    let mut stats = FrameStats::default();
    [
        stats.n_voxels,
        stats.n_occluded,
        stats.n_splats,
        stats.n_culled,
        stats.n_tiles,
        stats.n_saturated_tiles,
    ] = sums;
    Ok(stats)
}

/// The same on all ranks, if it is not already.
fn agreed<T>(comm: &dyn Communicator, own: Result<T, DividedError>) -> Result<T, MpiError> {
    match own {
        Err(DividedError::Elsewhere(error)) => Err(error
            .downcast_ref::<MpiError>()
            .cloned()
            .unwrap_or_else(|| MpiError::Rank { rank: comm.rank(), cause: error.to_string() })),
        own => agree(comm, own),
    }
}

/// Ranks hand each other what they have looked at.
struct Ranks<'a>(&'a dyn Communicator);

impl Exchange for Ranks<'_> {
    fn n_shares(&self) -> usize {
        self.0.n_ranks()
    }

    fn share_idx(&self) -> usize {
        self.0.rank()
    }

    fn first_here(&self) -> usize {
        self.0.first_here()
    }

    fn at_work(&mut self, work: &mut (dyn FnMut() + Send)) -> Result<(), DividedError> {
        while_beating(self.0, work).map_err(|error| DividedError::Elsewhere(Box::new(error)))
    }

    fn all(&mut self, own: Result<Samples, IoError>) -> Result<Vec<Samples>, DividedError> {
        let exchange = || {
            let own = agree(self.0, own)?;
            let all = all_gather(self.0, samples::to_bytes(&own))?;
            let read = all.iter().enumerate().map(|(rank, bytes)| {
                samples::from_bytes(bytes).ok_or(MpiError::Malformed { rank, what: "samples" })
            });
            read.collect::<Result<Vec<_>, _>>()
        };
        exchange().map_err(|error| DividedError::Elsewhere(Box::new(error)))
    }
}
