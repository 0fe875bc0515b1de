//! Ranks that are processes of an MPI.

use super::Drawn;
use crate::terminal::{self, Loudness, Unsaid};
use anyhow::Result;
use slabsplat_mpi::{
    Communicator, DrawnFrame, FrameTeam, MpiError, World, agree, draw_frames, threads_of_rank,
};
use std::time::Duration;

/// For what a line takes from a rank to the terminal.
const TO_HEAR: Duration = Duration::from_millis(300);

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
        done.map_err(|error| {
            let of_ranks = error.downcast_ref::<MpiError>();
            if let Some(error) = of_ranks.filter(|error| !error.is_shared()) {
                // The others do not know of it.
                terminal::report(format_args!("error: {error}"));
                self.world.abort()
            }
            if self.is_first() {
                terminal::report(format_args!("error: {}", terminal::one_line(&error)));
            }
            if of_ranks.is_some() {
                self.leave_after_the_first();
            }
            Unsaid.into()
        })
    }

    /// `mpirun` ends all ranks as soon as one has failed, and forgets what it has not yet heard of them: so
    /// nobody leaves before the first has spoken.
    fn leave_after_the_first(&self) {
        drop(agree(&self.world, Ok::<(), MpiError>(())));
        if !self.is_first() {
            std::thread::sleep(TO_HEAR);
        }
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
