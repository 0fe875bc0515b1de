//! Ranks that are processes of an MPI.

#[cfg(has_mpi)]
mod calls;
#[cfg(has_mpi)]
use calls::{MOST_BYTES, Mpi, Sending};

#[cfg(not(has_mpi))]
mod absent;
#[cfg(not(has_mpi))]
use absent::{MOST_BYTES, Mpi, Sending};

use crate::communicator::Traffic;
use crate::{Communicator, MpiError, Tag};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// All ranks of a program that `mpirun` started, or a launcher like it, seen from one of them.
///
/// It ends MPI when it is dropped, if it started it. If this thread panics, it ends all ranks.
#[derive(Debug)]
pub struct World {
    mpi: Mpi,
    sending: RefCell<Vec<Sending>>,
    /// Pieces of long messages whose rest is still to come.
    begun: RefCell<HashMap<(usize, Tag), Vec<u8>>>,
    time_limit: Duration,
    traffic: Cell<Traffic>,
    has_failed: Cell<bool>,
}

/// How long sent messages may take to get away when a rank ends.
const TO_END: Duration = Duration::from_secs(10);

impl World {
    /// Starts MPI, unless that is done, and waits until all ranks have. A rank that is then silent for longer
    /// than `time_limit` is an error.
    ///
    /// # Errors
    /// If there is no MPI.
    pub fn start(time_limit: Duration) -> Result<Self, MpiError> {
        Mpi::start().map(|mpi| Self::of(mpi, time_limit))
    }

    /// The ranks of a communicator, by the number that `MPI_Comm_c2f` gives. All of its ranks have to call
    /// this.
    ///
    /// # Errors
    /// If that is no communicator.
    pub fn of_communicator(comm: i32, time_limit: Duration) -> Result<Self, MpiError> {
        Mpi::of(comm).map(|mpi| Self::of(mpi, time_limit))
    }

    fn of(mpi: Mpi, time_limit: Duration) -> Self {
        Self {
            mpi,
            sending: RefCell::default(),
            begun: RefCell::default(),
            time_limit,
            traffic: Cell::default(),
            has_failed: Cell::new(false),
        }
    }

    /// Ends all ranks by force, this one too, after an error that is not
    /// [shared](MpiError::is_shared): the others do not know of it.
    pub fn abort(&self) -> ! {
        self.mpi.abort();
        std::process::exit(1)
    }

    /// Forgets messages that are sent.
    fn tidy(&self) -> Result<(), MpiError> {
        let mut still = Vec::new();
        for sending in self.sending.take() {
            still.extend(self.checked(self.mpi.sent(sending))?);
        }
        self.sending.replace(still);
        Ok(())
    }

    fn checked<T>(&self, result: Result<T, MpiError>) -> Result<T, MpiError> {
        self.has_failed.set(self.has_failed.get() || result.is_err());
        result
    }

    fn send_one(&self, to: usize, tag: Tag, bytes: Vec<u8>) -> Result<(), MpiError> {
        let mut traffic = self.traffic.get();
        traffic.count(tag, bytes.len());
        self.traffic.set(traffic);
        let sending = self.checked(self.mpi.send(bytes, to, tag as i32))?;
        self.sending.borrow_mut().push(sending);
        Ok(())
    }
}

impl Communicator for World {
    fn rank(&self) -> usize {
        self.mpi.rank
    }

    fn n_ranks(&self) -> usize {
        self.mpi.n_ranks
    }

    fn node(&self) -> String {
        self.mpi.node()
    }

    fn first_here(&self) -> usize {
        self.mpi.first_here
    }

    fn send(&self, to: usize, tag: Tag, mut bytes: Vec<u8>) -> Result<(), MpiError> {
        self.tidy()?;
        // One that is as long as can be is not the last.
        while MOST_BYTES <= bytes.len() {
            let rest = bytes.split_off(MOST_BYTES);
            self.send_one(to, tag, std::mem::replace(&mut bytes, rest))?;
        }
        self.send_one(to, tag, bytes)
    }

    fn try_receive(&self, from: usize, tag: Tag) -> Result<Option<Vec<u8>>, MpiError> {
        self.tidy()?;
        let Some(bytes) = self.checked(self.mpi.try_receive(from, tag as i32))? else {
            return Ok(None);
        };
        let is_last = bytes.len() < MOST_BYTES;
        let mut begun = self.begun.borrow_mut();
        let whole = match begun.remove(&(from, tag)) {
            None => bytes,
            Some(before) => [before, bytes].concat(),
        };
        if is_last {
            return Ok(Some(whole));
        }
        begun.insert((from, tag), whole);
        Ok(None)
    }

    fn time_limit(&self) -> Duration {
        self.time_limit
    }

    fn traffic(&self) -> Traffic {
        self.traffic.get()
    }
}

impl Drop for World {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.mpi.abort();
        }
        let started = Instant::now();
        while self.tidy().is_ok() && !self.sending.borrow().is_empty() && started.elapsed() < TO_END
        {
            std::thread::sleep(Duration::from_micros(200));
        }
        // What is still under way keeps its bytes, and MPI would wait for it for ever.
        let stuck = self.sending.take();
        if !stuck.is_empty() || self.has_failed.get() {
            stuck.into_iter().for_each(std::mem::forget);
            self.mpi.abort();
        }
    }
}
