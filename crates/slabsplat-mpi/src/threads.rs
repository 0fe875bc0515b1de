//! Ranks that are threads of one process: for tests, and for who wants to see what N ranks do without MPI.

use crate::communicator::Traffic;
use crate::{Communicator, MpiError, Tag};
use std::cell::Cell;
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// One of several ranks that are threads.
#[derive(Debug)]
pub struct ThreadRank {
    rank: usize,
    boxes: Arc<Vec<Mutex<Letters>>>,
    time_limit: Duration,
    traffic: Cell<Traffic>,
}

/// What waits for a rank, by who sent it.
type Letters = HashMap<(usize, Tag), VecDeque<Vec<u8>>>;

impl ThreadRank {
    /// Runs `work` as so many ranks, and returns what each made, in order.
    ///
    /// ```
    /// use slabsplat_mpi::{Communicator, ThreadRank};
    ///
    /// let ranks = ThreadRank::run(3, std::time::Duration::from_secs(9), |comm| comm.rank() * 10);
    /// assert_eq!(ranks, [0, 10, 20]);
    /// ```
    ///
    /// # Panics
    /// If one of them does.
    pub fn run<T: Send>(
        n_ranks: usize,
        time_limit: Duration,
        work: impl Fn(&Self) -> T + Sync,
    ) -> Vec<T> {
        let boxes: Arc<Vec<_>> = Arc::new((0..n_ranks).map(|_| Mutex::default()).collect());
        thread::scope(|scope| {
            let ranks = (0..n_ranks).map(|rank| {
                let (boxes, work) = (Arc::clone(&boxes), &work);
                scope.spawn(move || {
                    work(&Self { rank, boxes, time_limit, traffic: Cell::default() })
                })
            });
            let ranks: Vec<_> = ranks.collect();
            let join = |rank: thread::ScopedJoinHandle<'_, T>| match rank.join() {
                Ok(done) => done,
                Err(panic) => std::panic::resume_unwind(panic),
            };
            ranks.into_iter().map(join).collect()
        })
    }

    fn letters(&self, rank: usize) -> std::sync::MutexGuard<'_, Letters> {
        self.boxes[rank].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Communicator for ThreadRank {
    fn rank(&self) -> usize {
        self.rank
    }

    fn n_ranks(&self) -> usize {
        self.boxes.len()
    }

    fn node(&self) -> String {
        "here".to_owned()
    }

    fn first_here(&self) -> usize {
        0
    }

    fn send(&self, to: usize, tag: Tag, bytes: Vec<u8>) -> Result<(), MpiError> {
        let mut traffic = self.traffic.get();
        traffic.count(tag, bytes.len());
        self.traffic.set(traffic);
        self.letters(to).entry((self.rank, tag)).or_default().push_back(bytes);
        Ok(())
    }

    fn try_receive(&self, from: usize, tag: Tag) -> Result<Option<Vec<u8>>, MpiError> {
        Ok(self.letters(self.rank).get_mut(&(from, tag)).and_then(VecDeque::pop_front))
    }

    fn time_limit(&self) -> Duration {
        self.time_limit
    }

    fn traffic(&self) -> Traffic {
        self.traffic.get()
    }
}
