//! Why ranks cannot go on together.

use thiserror::Error;

/// Why a picture cannot be drawn by several ranks.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum MpiError {
    /// All ranks failed by the same cause.
    #[error("{0}")]
    All(String),
    /// One failed, or several, of which it is the first.
    #[error("rank {rank}: {cause}")]
    Rank {
        /// Which.
        rank: usize,
        /// Why.
        cause: String,
    },
    /// Nothing was heard of a rank for longer than ranks are waited for.
    #[error("rank {rank} has been silent for {seconds} s: it hangs, or its computer does")]
    Silent {
        /// Which.
        rank: usize,
        /// For how long.
        seconds: u64,
    },
    /// A message is not what it should be, as those of other programs are.
    #[error("rank {rank} sent what is no {what}: not all ranks run the same program")]
    Malformed {
        /// Who sent it.
        rank: usize,
        /// What it should have been.
        what: &'static str,
    },
    /// MPI itself failed.
    #[error("MPI cannot {what}: {cause}")]
    Library {
        /// What it was told to do.
        what: &'static str,
        /// What it said.
        cause: String,
    },
    /// There is no MPI in this program.
    #[error(
        "this program was built without MPI: build it with the feature `mpi`, where mpicc is (on Debian by \
         libopenmpi-dev)"
    )]
    NotBuilt,
}

impl MpiError {
    /// Whether every rank has the same error, so that each can end by itself, and one of them says why. After
    /// any other the ranks are at odds, and all have to be ended by force.
    pub fn is_shared(&self) -> bool {
        matches!(self, Self::All(_) | Self::Rank { .. } | Self::NotBuilt)
    }
}
