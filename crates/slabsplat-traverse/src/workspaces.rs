//! What threads work with, retained from tile to tile and from frame to frame.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// One for every thread, so that no lock is ever waited for.
#[derive(Debug)]
pub struct Workspaces<W>(Vec<Mutex<W>>);

impl<W> Default for Workspaces<W> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<W: Default> Workspaces<W> {
    /// Makes sure that there is one for every thread.
    pub fn for_all_threads(&mut self) -> &Self {
        self.0.resize_with(rayon::current_num_threads(), Mutex::default);
        self
    }

    /// The workspace of the thread that asks.
    pub fn of_this_thread(&self) -> MutexGuard<'_, W> {
        let thread = rayon::current_thread_index().unwrap_or(0);
        self.0[thread].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The sum of what `number_of` returns of each.
    pub fn sum_of(&self, number_of: impl Fn(&W) -> usize) -> usize {
        let locked = |workspace: &Mutex<W>| workspace.lock().map_or(0, |w| number_of(&w));
        self.0.iter().map(locked).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workspaces_are_one_a_thread_and_sum_up() {
        let mut workspaces = Workspaces::<usize>::default();
        let n_threads = workspaces.for_all_threads().0.len();
        assert_eq!(n_threads, rayon::current_num_threads());
        *workspaces.of_this_thread() = 7;
        assert_eq!(workspaces.sum_of(|&held| held), 7);
        assert_eq!(workspaces.sum_of(|_| 2), 2 * n_threads);
    }
}
