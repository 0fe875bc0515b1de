//! All ranks that `mpirun` started, of which this process is one: what `--distributed` asks for.

#[cfg(feature = "mpi")]
mod there;
#[cfg(feature = "mpi")]
pub(crate) use there::{Ranks, Team};

#[cfg(not(feature = "mpi"))]
mod absent;
#[cfg(not(feature = "mpi"))]
pub(crate) use absent::{Ranks, Team};

use anyhow::Result;
use clap::Args;
use slabsplat::Image;

/// Flags of what several ranks draw.
#[derive(Args)]
#[command(next_help_heading = "Ranks")]
pub(crate) struct RankFlags {
    /// Draw on all ranks that mpirun starts: of a picture each draws a box of the volumes, of a film whole
    /// frames. It takes a program that was built with the feature mpi
    #[arg(long)]
    distributed: bool,

    /// Seconds for which a rank may be silent before all end
    #[arg(
        long, value_name = "SECONDS", default_value = "120", requires = "distributed",
        value_parser = clap::value_parser!(u64).range(1..=86400)
    )]
    patience: u64,
}

impl RankFlags {
    /// The ranks, if flags ask for them.
    pub(crate) fn start(&self) -> Result<Option<Ranks>> {
        self.distributed.then(|| Ranks::start(self.patience)).transpose()
    }
}

/// A frame of a film, whoever drew it.
pub(crate) struct Drawn {
    pub(crate) image: Image,
    /// Why it shows nothing, if it does not.
    pub(crate) why_blank: Option<String>,
    pub(crate) notes: Vec<String>,
}

/// What all ranks can do, or none; without ranks it is what it is.
pub(crate) fn all_can<T>(ranks: Option<&Ranks>, own: Result<T>) -> Result<T> {
    match ranks {
        Some(ranks) => ranks.all_can(own),
        None => own,
    }
}

/// How all ranks end: one of them reports an error, unless they are at odds.
pub(crate) fn ended<T>(ranks: Option<Ranks>, done: Result<T>) -> Result<T> {
    match ranks {
        Some(ranks) => ranks.ended(done),
        None => done,
    }
}
