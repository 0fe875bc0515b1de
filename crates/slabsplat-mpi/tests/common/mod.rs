//! Pictures of one process and of ranks that are threads, which may be those of several computers.

use slabsplat::io::SceneFile;
use slabsplat::{FrameHandle, Image, OpenScene, Renderer, SharedDesc, backend_named};
use slabsplat_mpi::{Communicator, DistributedScene, MpiError, Tag, ThreadRank, Traffic};
use std::time::Duration;

/// What a picture may differ by of which each part is rounded on its own.
pub(crate) const ROUNDED_TWICE: f32 = 1e-5;

pub(crate) const LIMIT: Duration = Duration::from_secs(60);

/// All of it in memory.
pub(crate) fn whole(file: &SceneFile) -> Image {
    let OpenScene { scene, .. } = OpenScene::open(file).unwrap();
    Renderer::new(backend_named("cpu").unwrap()).render(&scene).unwrap().image
}

/// By so many ranks, of which so many each are on one computer.
pub(crate) fn by_ranks(file: &SceneFile, desc: &SharedDesc, ranks: [usize; 2]) -> Image {
    let [n_ranks, n_each] = ranks;
    let ranks = ThreadRank::run(n_ranks, LIMIT, |of| {
        let comm = &OfComputer { of, n_each };
        let scene = DistributedScene::open(comm, file, desc)?;
        let picture = scene.picture(comm, &FrameHandle::new())?;
        assert_eq!(picture.is_some(), comm.rank() == 0);
        Ok::<_, MpiError>(picture)
    });
    let mut ranks = ranks.into_iter().map(Result::unwrap);
    let picture = ranks.next().flatten().expect("rank 0 has it");
    assert_eq!(picture.ranks.len(), n_ranks);
    picture.picture.frame.image
}

/// A rank of one of several computers, each of which has so many.
#[derive(Debug)]
pub(crate) struct OfComputer<'a> {
    pub(crate) of: &'a ThreadRank,
    pub(crate) n_each: usize,
}

impl Communicator for OfComputer<'_> {
    fn rank(&self) -> usize {
        self.of.rank()
    }

    fn n_ranks(&self) -> usize {
        self.of.n_ranks()
    }

    fn node(&self) -> String {
        format!("computer {}", self.first_here())
    }

    fn first_here(&self) -> usize {
        self.rank() / self.n_each * self.n_each
    }

    fn send(&self, to: usize, tag: Tag, bytes: Vec<u8>) -> Result<(), MpiError> {
        self.of.send(to, tag, bytes)
    }

    fn try_receive(&self, from: usize, tag: Tag) -> Result<Option<Vec<u8>>, MpiError> {
        self.of.try_receive(from, tag)
    }

    fn time_limit(&self) -> Duration {
        self.of.time_limit()
    }

    fn traffic(&self) -> Traffic {
        self.of.traffic()
    }
}
