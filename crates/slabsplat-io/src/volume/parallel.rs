//! Parts of a volume that are packed each for itself, unpacked on all threads and taken in their order.

use rayon::prelude::*;

/// One of so many parts is in memory for each worker, twice: as it is read, and unpacked.
const PARTS_PER_WORKER: usize = 8;

/// How many parts are unpacked at once, of so many.
pub(super) fn n_workers(n_parts: usize) -> usize {
    rayon::current_num_threads().min(n_parts / PARTS_PER_WORKER).max(1)
}

/// Unpacks `parts`, one on each worker at a time, and hands them to `take` one after the other. The first
/// error by their order is the one that counts.
pub(super) fn in_order<W: Send, P: Sync, T: Send, E: Send>(
    workers: &mut [W],
    parts: &[P],
    unpack: impl Fn(&mut W, &P) -> Result<T, E> + Sync,
    mut take: impl FnMut(&P, T) -> Result<(), E>,
) -> Result<(), E> {
    if let [worker] = workers {
        return parts.iter().try_for_each(|part| take(part, unpack(worker, part)?));
    }
    for batch in parts.chunks(workers.len()) {
        let pairs = workers.par_iter_mut().zip(batch);
        let unpacked: Vec<Result<T, E>> =
            pairs.map(|(worker, part)| unpack(worker, part)).collect();
        batch.iter().zip(unpacked).try_for_each(|(part, unpacked)| take(part, unpacked?))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_come_in_their_order() {
        let parts: Vec<u32> = (0..100).collect();
        for n_workers in [1, 3, 8] {
            let mut taken = Vec::new();
            let mut workers = vec![(); n_workers];
            let done: Result<(), String> = in_order(
                &mut workers,
                &parts,
                |(), part| if *part == 77 { Err("broken".to_owned()) } else { Ok(part * part) },
                |part, square| {
                    assert_eq!(square, part * part);
                    taken.push(*part);
                    Ok(())
                },
            );
            assert_eq!(done, Err("broken".to_owned()));
            assert_eq!(taken, parts[..77], "{n_workers} workers");
        }
        assert_eq!((n_workers(0), n_workers(15)), (1, 1));
    }
}
