//! What stands for ranks in a program without MPI.

use super::Drawn;
use anyhow::{Result, bail};
use std::marker::PhantomData;

/// There are none.
#[derive(Clone, Copy)]
pub(crate) enum Ranks {}

/// Nor is there a team of them.
pub(crate) struct Team<'a>(Ranks, PhantomData<&'a Ranks>);

impl Ranks {
    pub(crate) fn start(_: u64) -> Result<Self> {
        bail!(
            "this program was built without MPI: cargo install slabsplat-cli --features mpi, where mpicc is"
        )
    }

    pub(crate) fn is_first(&self) -> bool {
        match *self {}
    }

    pub(crate) fn all_can<T>(&self, _: Result<T>) -> Result<T> {
        match *self {}
    }

    pub(crate) fn ended<T>(self, _: Result<T>) -> Result<T> {
        match self {}
    }

    pub(crate) fn team(&self, _: u32) -> Team<'_> {
        match *self {}
    }

    pub(crate) fn draw_frames(&self, _: impl FnMut(u32) -> Result<Drawn> + Send) -> Result<()> {
        match *self {}
    }
}

impl Team<'_> {
    pub(crate) fn frame(
        &mut self,
        _: u32,
        _: impl FnOnce(u32) -> Result<Drawn> + Send,
    ) -> Result<Drawn> {
        match self.0 {}
    }

    pub(crate) fn end(self) -> Result<()> {
        match self.0 {}
    }
}
