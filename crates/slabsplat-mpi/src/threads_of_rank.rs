//! How many threads a rank works on.

use crate::collective::all_gather;
use crate::{Communicator, MpiError};
use std::num::NonZero;
use std::thread::available_parallelism;

/// As many threads as this rank's part of the cores that it may run on.
///
/// Launchers bind ranks to cores, or do not: those on one computer with the same cores share them. All ranks
/// have to call it.
///
/// # Errors
/// If the network fails, or a rank is silent for too long.
pub fn threads_of_rank(comm: &dyn Communicator) -> Result<usize, MpiError> {
    let own = [comm.node().into_bytes(), allowed_cores().into_bytes()].join(&0);
    let all = all_gather(comm, own.clone())?;
    let n_sharing = all.iter().filter(|other| **other == own).count().max(1);
    let n_cores = available_parallelism().map_or(1, NonZero::get);
    Ok((n_cores / n_sharing).max(1))
}

/// The cores that the system lets this process run on; nothing where it does not tell, as if ranks shared
/// all.
fn allowed_cores() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("Cpus_allowed_list:"));
    line.unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ThreadRank;
    use std::time::Duration;

    #[test]
    fn threads_are_shared_by_ranks_of_one_computer() {
        let n_cores = available_parallelism().map_or(1, NonZero::get);
        for n_ranks in [1, 2, 3, 2 * n_cores] {
            let threads = ThreadRank::run(n_ranks, Duration::from_secs(9), |c| threads_of_rank(c));
            assert!(threads.iter().all(|n| *n == Ok((n_cores / n_ranks).max(1))), "{threads:?}");
        }
    }
}
