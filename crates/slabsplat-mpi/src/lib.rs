//! Volumes that several computers draw together.
//!
//! Each **rank**, a process of an MPI, reads and draws one box of the volumes; the pictures of all are laid
//! over each other as the eye has them (model §17), and rank 0 has the picture.
//!
//! A scene's files are drawn by a [`DistributedScene`]; a simulation hands over what it has in memory to an
//! [`InSitu`], from C too (`include/slabsplat_mpi.h`).
//!
//! Without the feature `mpi` ranks are threads ([`ThreadRank`]), for tests.
//!
//! # Features
//!
//! - `mpi`: ranks that are processes of an MPI. It is found by `mpicc` when this is built; where there is
//!   none it builds all the same, and says so when it is asked for ranks.
//!
//! # Reading order
//!
//! `communicator`, `collective`, `threads`, `world`; `piece`, `compositing`; `distributed`, `report`,
//! `threads_of_rank`; `frames`; `in_situ`.

#![deny(clippy::exhaustive_enums, clippy::exhaustive_structs)]

mod collective;
mod communicator;
mod compositing;
mod distributed;
mod error;
mod frames;
mod in_situ;
mod piece;
mod report;
mod samples;
mod threads;
mod threads_of_rank;
pub mod time_model;
#[cfg(feature = "mpi")]
mod world;

pub use collective::agree;
pub use communicator::{Communicator, Tag, Traffic, receive};
pub use compositing::composite;
pub use distributed::{DistributedPicture, DistributedScene};
pub use error::MpiError;
pub use frames::{DrawnFrame, FrameTeam, draw_frames};
#[cfg(feature = "mpi")]
pub use in_situ::c;
pub use in_situ::{BoxError, Field, FieldError, InSitu, InSituError, SceneText, Values, VoxelBox};
pub use report::RankReport;
pub use threads::ThreadRank;
pub use threads_of_rank::threads_of_rank;
#[cfg(feature = "mpi")]
pub use world::World;
