//! What ranks talk by: messages from one to another, in order, and how long one waits for them.

use crate::MpiError;
use std::thread;
use std::time::{Duration, Instant};

/// Ranks that send each other messages, seen from one of them.
///
/// Messages with one tag from one rank to another arrive in the order in which they were sent. Nothing
/// blocks, and whoever waits does so by [`receive`], which ends.
pub trait Communicator: std::fmt::Debug {
    /// Which rank this is, from 0.
    fn rank(&self) -> usize;

    /// How many there are.
    fn n_ranks(&self) -> usize;

    /// The name of the computer.
    fn node(&self) -> String;

    /// The first rank of this one's computer.
    fn first_here(&self) -> usize;

    /// Sends bytes, and does not wait until they are there.
    ///
    /// # Errors
    /// If the network fails.
    fn send(&self, to: usize, tag: Tag, bytes: Vec<u8>) -> Result<(), MpiError>;

    /// The next message of a rank, if it is there.
    ///
    /// # Errors
    /// If the network fails.
    fn try_receive(&self, from: usize, tag: Tag) -> Result<Option<Vec<u8>>, MpiError>;

    /// For how long a rank may be silent.
    fn time_limit(&self) -> Duration;

    /// What was sent so far, without beats.
    fn traffic(&self) -> Traffic;
}

/// What a message is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Tag {
    /// That a rank lives.
    Beat,
    /// How a rank fared, to rank 0.
    Status,
    /// How all fared, of rank 0.
    Verdict,
    /// What rank 0 collects.
    Gather,
    /// What it hands out.
    Broadcast,
    /// A piece of a picture, to who owns those rows.
    Piece,
    /// Rows that are done, to rank 0.
    Band,
    /// Voxels of a simulation that neighbours need.
    Ghosts,
    /// Which frame of a film a rank is to draw.
    FrameAsked,
    /// A frame of a film.
    Frame,
    /// What the program sends that has the ranks.
    Program,
}

/// What a rank has sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Traffic {
    /// Messages.
    pub n_messages: u64,
    /// Bytes in them.
    pub n_bytes: u64,
}

impl Traffic {
    /// Counts a message.
    pub(crate) fn count(&mut self, tag: Tag, n_bytes: usize) {
        if tag != Tag::Beat {
            self.n_messages += 1;
            self.n_bytes += n_bytes as u64;
        }
    }

    /// What was sent since then.
    #[must_use]
    pub fn since(self, then: Self) -> Self {
        Self { n_messages: self.n_messages - then.n_messages, n_bytes: self.n_bytes - then.n_bytes }
    }
}

/// How often a rank says that it lives.
const BETWEEN_BEATS: Duration = Duration::from_millis(500);

/// Waits for a message.
///
/// # Errors
/// If the network fails, or the rank has been silent for too long.
pub fn receive(comm: &dyn Communicator, from: usize, tag: Tag) -> Result<Vec<u8>, MpiError> {
    let mut wait = Wait::new(comm);
    loop {
        if let Some(bytes) = comm.try_receive(from, tag)? {
            return Ok(bytes);
        }
        wait.pause(from)?;
    }
}

/// Somebody who waits, and says so.
///
/// Ranks that work for long are waited for by rank 0, and all others wait for that one: so a rank beats to
/// rank 0, and rank 0 to all. Where any other waits for another, both have just heard that all are well.
struct Wait<'a> {
    comm: &'a dyn Communicator,
    heard: Instant,
    beaten: Option<Instant>,
    n_pauses: u32,
}

impl<'a> Wait<'a> {
    fn new(comm: &'a dyn Communicator) -> Self {
        Self { comm, heard: Instant::now(), beaten: None, n_pauses: 0 }
    }

    /// Sleeps for a moment.
    fn pause(&mut self, from: usize) -> Result<(), MpiError> {
        self.beat(from)?;
        if limit(self.comm) < self.heard.elapsed() {
            return Err(MpiError::Silent { rank: from, seconds: self.heard.elapsed().as_secs() });
        }
        self.sleep();
        Ok(())
    }

    /// A rank that spun would take the core of one that works.
    fn sleep(&mut self) {
        self.n_pauses += 1;
        thread::sleep(Duration::from_micros(u64::from(self.n_pauses.min(100)) * 10));
    }

    /// Says that this rank lives, if it is time to, and listens to those who say so.
    fn beat(&mut self, awaited: usize) -> Result<(), MpiError> {
        if self.beaten.is_some_and(|beaten| beaten.elapsed() < BETWEEN_BEATS) {
            return Ok(());
        }
        self.beaten = Some(Instant::now());
        let comm = self.comm;
        for peer in peers(comm) {
            comm.send(peer, Tag::Beat, Vec::new())?;
            if hear_beats(comm, peer)? && peer == awaited {
                self.heard = Instant::now();
            }
        }
        Ok(())
    }
}

/// Who beats to this rank, and hears it.
fn peers(comm: &dyn Communicator) -> std::ops::Range<usize> {
    if comm.rank() == 0 { 1..comm.n_ranks() } else { 0..1 }
}

/// Takes in the beats of a rank; whether there were any.
fn hear_beats(comm: &dyn Communicator, peer: usize) -> Result<bool, MpiError> {
    let mut has_any = false;
    while comm.try_receive(peer, Tag::Beat)?.is_some() {
        has_any = true;
    }
    Ok(has_any)
}

/// Others wait a little longer than rank 0, and each its own time, so that one of them speaks.
fn limit(comm: &dyn Communicator) -> Duration {
    let base = comm.time_limit();
    match comm.rank() as u32 {
        0 => base,
        rank => base + base / 4 + Duration::from_millis(1000 + 200 * u64::from(rank.min(50))),
    }
}

/// Works on a thread of its own, while this one says that it lives.
///
/// # Errors
/// If the network fails meanwhile; the work is done all the same.
pub(crate) fn while_beating<T: Send>(
    comm: &dyn Communicator,
    work: impl FnOnce() -> T + Send,
) -> Result<T, MpiError> {
    thread::scope(|scope| {
        let worker = scope.spawn(work);
        let mut wait = Wait::new(comm);
        let mut beaten = Ok(());
        while !worker.is_finished() {
            beaten = beaten.and_then(|()| wait.beat(comm.rank()));
            wait.sleep();
        }
        match worker.join() {
            Ok(done) => beaten.map(|()| done),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}
