//! What stands for MPI where there was none when this was built.

use crate::MpiError;
use std::ffi::c_int;

/// There is none.
#[derive(Debug)]
pub(super) struct Mpi {
    pub(super) rank: usize,
    pub(super) n_ranks: usize,
    pub(super) first_here: usize,
    never: Never,
}

/// There is no message on its way either.
#[derive(Debug)]
pub(super) struct Sending(Never);

#[derive(Clone, Copy, Debug)]
enum Never {}

pub(super) const MOST_BYTES: usize = 1 << 30;

impl Mpi {
    pub(super) fn start() -> Result<Self, MpiError> {
        Err(MpiError::NotBuilt)
    }

    pub(super) fn of(_: c_int) -> Result<Self, MpiError> {
        Err(MpiError::NotBuilt)
    }

    pub(super) fn send(&self, _: Vec<u8>, _: usize, _: c_int) -> Result<Sending, MpiError> {
        match self.never {}
    }

    pub(super) fn sent(&self, sending: Sending) -> Result<Option<Sending>, MpiError> {
        match sending.0 {}
    }

    pub(super) fn try_receive(&self, _: usize, _: c_int) -> Result<Option<Vec<u8>>, MpiError> {
        match self.never {}
    }

    pub(super) fn node(&self) -> String {
        match self.never {}
    }

    pub(super) fn abort(&self) {
        match self.never {}
    }
}
