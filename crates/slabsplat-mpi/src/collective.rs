//! What all ranks do together: agree that all is well, collect, and hand out. Every rank calls each of these,
//! in the same order.

use crate::communicator::receive;
use crate::{Communicator, MpiError, Tag};

/// Whether all ranks succeeded; if not, all get the same error, which names the first that failed.
///
/// Rank 0 hears each, and tells all. That is 2(n − 1) messages of some bytes, and waits for who works
/// longest.
///
/// # Errors
/// If any rank's `own` is an error, or the network fails.
pub fn agree<T, E: std::fmt::Display>(
    comm: &dyn Communicator,
    own: Result<T, E>,
) -> Result<T, MpiError> {
    let own = own.map_err(|error| error.to_string());
    let status = own.as_ref().err().map(String::as_bytes);
    let verdict = if comm.rank() == 0 {
        let verdict = judge(&statuses(comm, status)?);
        (1..comm.n_ranks()).try_for_each(|to| comm.send(to, Tag::Verdict, verdict.clone()))?;
        verdict
    } else {
        comm.send(0, Tag::Status, encode_status(status))?;
        receive(comm, 0, Tag::Verdict)?
    };
    match (read_verdict(&verdict)?, own) {
        (None, Ok(own)) => Ok(own),
        (Some(error), _) => Err(error),
        (None, Err(_)) => Err(malformed(0)),
    }
}

/// Rank 0 hears all ranks: the causes of those that failed.
fn statuses(comm: &dyn Communicator, own: Option<&[u8]>) -> Result<Vec<Option<String>>, MpiError> {
    let of_all = (0..comm.n_ranks()).map(|rank| {
        let bytes = if rank == 0 { encode_status(own) } else { receive(comm, rank, Tag::Status)? };
        match bytes.split_first() {
            Some((0, [])) => Ok(None),
            Some((1, cause)) => Ok(Some(String::from_utf8_lossy(cause).into_owned())),
            _ => Err(malformed(rank)),
        }
    });
    of_all.collect()
}

fn encode_status(cause: Option<&[u8]>) -> Vec<u8> {
    cause.map_or_else(|| vec![0], |cause| [&[1], cause].concat())
}

/// Nothing if all is well; else who failed, where all may have by one cause, and why.
fn judge(statuses: &[Option<String>]) -> Vec<u8> {
    let Some((rank, cause)) =
        statuses.iter().enumerate().find_map(|(rank, cause)| Some((rank, cause.as_ref()?)))
    else {
        return Vec::new();
    };
    let is_of_all = statuses.iter().all(|other| other.as_ref() == Some(cause));
    let rank = if is_of_all { u32::MAX } else { rank as u32 };
    [&rank.to_le_bytes(), cause.as_bytes()].concat()
}

fn read_verdict(bytes: &[u8]) -> Result<Option<MpiError>, MpiError> {
    if bytes.is_empty() {
        return Ok(None);
    }
    let (rank, cause) = bytes.split_first_chunk().ok_or(malformed(0))?;
    let cause = String::from_utf8_lossy(cause).into_owned();
    Ok(Some(match u32::from_le_bytes(*rank) {
        u32::MAX => MpiError::All(cause),
        rank => MpiError::Rank { rank: rank as usize, cause },
    }))
}

fn malformed(rank: usize) -> MpiError {
    MpiError::Malformed { rank, what: "status" }
}

/// What each rank has, on rank 0; nothing on others. All have to be about to call it, as after [`agree`].
pub(crate) fn gather(
    comm: &dyn Communicator,
    own: Vec<u8>,
) -> Result<Option<Vec<Vec<u8>>>, MpiError> {
    if comm.rank() != 0 {
        comm.send(0, Tag::Gather, own)?;
        return Ok(None);
    }
    let others = (1..comm.n_ranks()).map(|from| receive(comm, from, Tag::Gather));
    let all = std::iter::once(Ok(own)).chain(others);
    all.collect::<Result<Vec<_>, _>>().map(Some)
}

/// What rank 0 has, on all ranks: a binomial tree, so that no rank sends it more than log₂ n times.
pub(crate) fn broadcast(
    comm: &dyn Communicator,
    own: Option<Vec<u8>>,
) -> Result<Vec<u8>, MpiError> {
    let (rank, n_ranks) = (comm.rank(), comm.n_ranks());
    let bytes = match own {
        Some(own) if rank == 0 => own,
        // The parent is without the lowest bit.
        _ => receive(comm, rank & rank.wrapping_sub(1), Tag::Broadcast)?,
    };
    let own_bit = if rank == 0 { n_ranks.next_power_of_two() } else { rank & rank.wrapping_neg() };
    let mut bit = own_bit / 2;
    while 0 < bit {
        if rank + bit < n_ranks {
            comm.send(rank + bit, Tag::Broadcast, bytes.clone())?;
        }
        bit /= 2;
    }
    Ok(bytes)
}

/// What each rank has, on all ranks.
pub(crate) fn all_gather(comm: &dyn Communicator, own: Vec<u8>) -> Result<Vec<Vec<u8>>, MpiError> {
    let all = gather(comm, own)?.map(|all| {
        let with_length =
            |bytes: Vec<u8>| [&(bytes.len() as u64).to_le_bytes()[..], &bytes].concat();
        all.into_iter().flat_map(with_length).collect::<Vec<u8>>()
    });
    let joined = broadcast(comm, all)?;
    let malformed = MpiError::Malformed { rank: 0, what: "list of what all have" };
    parted(&joined).filter(|all| all.len() == comm.n_ranks()).ok_or(malformed)
}

fn parted(mut joined: &[u8]) -> Option<Vec<Vec<u8>>> {
    let mut parts = Vec::new();
    while !joined.is_empty() {
        let (length, rest) = joined.split_first_chunk()?;
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        let (part, rest) = rest.split_at_checked(length)?;
        parts.push(part.to_vec());
        joined = rest;
    }
    Some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ThreadRank;
    use std::time::Duration;

    const LIMIT: Duration = Duration::from_secs(20);

    #[test]
    fn agree_names_the_first_that_failed() {
        for n_ranks in [1, 2, 5, 8] {
            let all_well = ThreadRank::run(n_ranks, LIMIT, |comm| agree(comm, Ok::<_, String>(7)));
            assert!(all_well.iter().all(|own| *own == Ok(7)));
            let failed = ThreadRank::run(n_ranks, LIMIT, |comm| match comm.rank() {
                rank if rank % 3 == 1 => agree(comm, Err::<(), _>(format!("no file on {rank}"))),
                _ => agree(comm, Ok::<_, String>(())),
            });
            if 1 < n_ranks {
                let expected = MpiError::Rank { rank: 1, cause: "no file on 1".to_owned() };
                assert!(failed.iter().all(|own| *own == Err(expected.clone())), "{failed:?}");
            }
            let all =
                ThreadRank::run(n_ranks, LIMIT, |comm| agree(comm, Err::<(), _>("bad scene")));
            assert!(all.iter().all(|own| *own == Err(MpiError::All("bad scene".to_owned()))));
        }
    }

    #[test]
    fn all_gather_has_what_each_has() {
        for n_ranks in 1..=9 {
            let own = |rank: usize| vec![rank as u8; rank * 3 % 7];
            let all = ThreadRank::run(n_ranks, LIMIT, |comm| all_gather(comm, own(comm.rank())));
            let expected: Vec<Vec<u8>> = (0..n_ranks).map(own).collect();
            assert!(all.iter().all(|of_all| of_all.as_ref() == Ok(&expected)), "{all:?}");
        }
    }

    #[test]
    fn silence_is_noticed_by_rank_0_first() {
        let limit = Duration::from_millis(300);
        let ranks = ThreadRank::run(3, limit, |comm| match comm.rank() {
            2 => {
                std::thread::sleep(Duration::from_secs(1));
                Ok(())
            }
            _ => agree(comm, Ok::<_, String>(())),
        });
        assert!(matches!(ranks[0], Err(MpiError::Silent { rank: 2, .. })), "{ranks:?}");
        assert!(matches!(ranks[1], Err(MpiError::Silent { rank: 0, .. })), "{ranks:?}");
    }

    #[test]
    fn who_works_for_long_is_waited_for() {
        let ranks = ThreadRank::run(3, Duration::from_millis(1500), |comm| {
            let slow = comm.rank() == 1;
            let work = move || {
                if slow {
                    std::thread::sleep(Duration::from_secs(4));
                }
            };
            let done = crate::communicator::while_beating(comm, work);
            agree(comm, done)
        });
        assert!(ranks.iter().all(Result::is_ok), "{ranks:?}");
    }

    #[test]
    fn hostile_lists_are_refused() {
        assert_eq!(parted(&[1, 0, 0]), None);
        assert_eq!(parted(&u64::MAX.to_le_bytes()), None);
        assert_eq!(parted(&[&2_u64.to_le_bytes()[..], &[7]].concat()), None);
        assert_eq!(parted(&[&1_u64.to_le_bytes()[..], &[7]].concat()), Some(vec![vec![7]]));
    }
}
