//! Ranks that are processes of an MPI.

use super::Drawn;
use crate::terminal::{self, Loudness, Unsaid};
use anyhow::Result;
use slabsplat_mpi::{
    Communicator, DrawnFrame, FrameTeam, MpiError, World, agree, draw_frames, threads_of_rank,
};
use std::time::Duration;

/// All ranks, seen from one of them.
pub(crate) struct Ranks {
    pub(crate) world: World,
}

/// Those that draw a film, as the first has them.
pub(crate) struct Team<'a>(FrameTeam<'a>);

impl Ranks {
    /// Joins the others. From now on the first alone speaks, and each has its part of the threads, unless a
    /// flag says how many.
    pub(crate) fn start(patience_secs: u64) -> Result<Self> {
        let world = World::start(Duration::from_secs(patience_secs))?;
        if world.rank() != 0 {
            terminal::set_loudness(Loudness::Quiet);
        }
        // Who says how many there are to be has started them already.
        let threads = rayon::ThreadPoolBuilder::new().num_threads(threads_of_rank(&world)?);
        let _ = threads.build_global();
        Ok(Self { world })
    }

    /// Whether this one speaks and writes.
    pub(crate) fn is_first(&self) -> bool {
        self.world.rank() == 0
    }

    /// What all ranks can do, or none.
    pub(crate) fn all_can<T>(&self, own: Result<T>) -> Result<T> {
        // What all know already is not told again.
        let is_known = |error: &anyhow::Error| error.is::<MpiError>();
        match own {
            Err(error) if is_known(&error) => Err(error),
            own => Ok(agree(&self.world, own.map_err(|error| terminal::one_line(&error)))?),
        }
    }

    /// Ends this rank as all end: the first reports the error that all have.
    pub(crate) fn ended<T>(self, done: Result<T>) -> Result<T> {
        done.map_err(|error| match error.downcast_ref::<MpiError>() {
            // The others do not know of it.
            Some(error) if !error.is_shared() => {
                terminal::report(format_args!("error: {error}"));
                self.world.abort()
            }
            _ if self.is_first() => error,
            _ => Unsaid.into(),
        })
    }

    /// All ranks for the frames of a film.
    pub(crate) fn team(&self, n_frames: u32) -> Team<'_> {
        Team(FrameTeam::new(&self.world, n_frames))
    }

    /// Draws what the first asks for, until there is no more.
    pub(crate) fn draw_frames(
        &self,
        mut draw: impl FnMut(u32) -> Result<Drawn> + Send,
    ) -> Result<()> {
        Ok(draw_frames(&self.world, |frame_idx| sent(draw(frame_idx)))?)
    }
}

impl Team<'_> {
    /// A frame, by whoever draws it; this rank by `draw`.
    pub(crate) fn frame(
        &mut self,
        frame_idx: u32,
        draw: impl FnOnce(u32) -> Result<Drawn> + Send,
    ) -> Result<Drawn> {
        let DrawnFrame { image, why_blank, notes } =
            self.0.frame(frame_idx, |frame_idx| sent(draw(frame_idx)))?;
        Ok(Drawn { image, why_blank, notes })
    }

    /// Tells all that there is no more to draw.
    pub(crate) fn end(self) -> Result<()> {
        Ok(self.0.end()?)
    }
}

/// A frame as ranks send it.
fn sent(drawn: Result<Drawn>) -> Result<DrawnFrame, String> {
    let Drawn { image, why_blank, notes } = drawn.map_err(|error| terminal::one_line(&error))?;
    Ok(DrawnFrame { image, why_blank, notes })
}
