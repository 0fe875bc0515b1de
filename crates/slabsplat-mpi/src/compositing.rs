//! Pictures of all ranks become one, by direct send: each rank owns some rows, is sent what others have of
//! them, and lays it over each other as the eye has it; rank 0 collects the rows.
//!
//! ```text
//! all tell each other in which rectangle they have pixels that are not empty
//! rows are dealt out such that each rank has as many of those pixels to lay over each other
//! each sends to each owner what it has of its rows (`piece`), if it has anything
//! each lays the pieces of its rows over each other, the nearest first
//! each sends its rows to rank 0
//! ```
//!
//! Every pixel is laid over by one rank in one order, so that the picture has the same bits for any division
//! of its rows. Binary swap sends fewer messages, more bytes, and joins neighbours first: other sums. Both
//! were measured, under "Direct send or binary swap" of the project's page on scaling.

use crate::collective::{all_gather, gather};
use crate::communicator::receive;
use crate::piece::{Extent, decode, encode};
use crate::{Communicator, MpiError, Tag};
use slabsplat::{Image, over};
use std::ops::Range;

/// Composites what ranks have drawn before nothing. `order` has the ranks from the eye. The picture is on
/// rank 0; others get nothing. All have to be about to call it, as after [`agree`](crate::agree).
///
/// # Errors
/// If the network fails, or a rank is silent for too long.
///
/// # Panics
/// If `order` names a rank that there is not.
pub fn composite(
    comm: &dyn Communicator,
    own: &Image,
    order: &[usize],
) -> Result<Option<Image>, MpiError> {
    let size = [own.width(), own.height()];
    let extent = Extent::of(own);
    let extents = all_gather(comm, extent.to_bytes())?.into_iter().enumerate().map(|(rank, of)| {
        let malformed = MpiError::Malformed { rank, what: "rectangle" };
        Extent::from_bytes(&of, size).ok_or(malformed)
    });
    let extents = extents.collect::<Result<Vec<_>, _>>()?;
    let bands = bands(&extents, size[1]);
    // Not all begin with the same one, who would then be the last to get anything.
    for owner in (0..bands.len()).map(|idx| (comm.rank() + idx) % bands.len()) {
        if owner != comm.rank() && extent.meets(&bands[owner]) {
            comm.send(owner, Tag::Piece, encode(own, &extent, &bands[owner]))?;
        }
    }
    let band = &bands[comm.rank()];
    let done = lay_over(comm, own, order, (&extents, band))?;
    collect(comm, done, &bands, size)
}

/// The rows of a band of the picture.
fn lay_over(
    comm: &dyn Communicator,
    own: &Image,
    order: &[usize],
    (extents, band): (&[Extent], &Range<u32>),
) -> Result<Image, MpiError> {
    let width = own.width();
    // A picture has a row at least.
    let mut rows = Image::filled(width, (band.end - band.start).max(1), [0.0; 4]);
    for &rank in order.iter().filter(|rank| extents[**rank].meets(band)) {
        let extent = &extents[rank];
        let piece = if rank == comm.rank() {
            encode(own, extent, band)
        } else {
            receive(comm, rank, Tag::Piece)?
        };
        let laid = decode(&piece, extent, band, |[x, y], run| {
            let start = ((y - band.start) * width + x) as usize;
            let front = &mut rows.pixels_mut()[start..start + run.len()];
            front.iter_mut().zip(run).for_each(|(front, behind)| *front = over(*front, *behind));
        });
        laid.ok_or(MpiError::Malformed { rank, what: "piece of a picture" })?;
    }
    Ok(rows)
}

/// Which rows belong to whom, by their pixels that are not empty, as far as extents tell.
fn bands(extents: &[Extent], height: u32) -> Vec<Range<u32>> {
    let n_ranks = extents.len() as u64;
    let mut weights = vec![0_u64; height as usize];
    for extent in extents {
        let rows = extent.rows.start as usize..extent.rows.end as usize;
        weights[rows].iter_mut().for_each(|weight| *weight += extent.columns.len() as u64);
    }
    let total: u64 = weights.iter().sum();
    let mut start = 0;
    let (mut sum, mut rows) = (0, weights.iter());
    let bands = (1..=n_ranks).map(|nth| {
        let mut end = start;
        while sum * n_ranks < total * nth
            && let Some(weight) = rows.next()
        {
            (sum, end) = (sum + weight, end + 1);
        }
        let band = start..end;
        start = end;
        band
    });
    bands.collect()
}

/// All bands on rank 0; rows that nobody owns are empty.
fn collect(
    comm: &dyn Communicator,
    rows: Image,
    bands: &[Range<u32>],
    [width, height]: [u32; 2],
) -> Result<Option<Image>, MpiError> {
    let extent = Extent::of(&rows);
    let all = 0..rows.height();
    let bytes = [extent.to_bytes(), encode(&rows, &extent, &all)].concat();
    drop(rows);
    let Some(of_all) = gather(comm, bytes)? else { return Ok(None) };
    let mut image = Image::filled(width, height, [0.0; 4]);
    for (rank, (bytes, band)) in of_all.into_iter().zip(bands).enumerate() {
        let n_rows = (band.end - band.start).max(1);
        let laid = bytes.split_at_checked(16).and_then(|(extent, piece)| {
            let extent = Extent::from_bytes(extent, [width, n_rows])?;
            decode(piece, &extent, &(0..n_rows), |[x, y], run| {
                let start = ((band.start + y) * width + x) as usize;
                image.pixels_mut()[start..start + run.len()].copy_from_slice(run);
            })
        });
        laid.ok_or(MpiError::Malformed { rank, what: "band of a picture" })?;
    }
    Ok(Some(image))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ThreadRank;
    use crate::piece::tests::random_image;
    use slabsplat_seeds::for_each_seed;
    use std::time::Duration;

    /// To the bit, for any number of ranks, pictures and orders.
    #[test]
    fn composite_is_over_in_order() {
        for_each_seed(40, |mut rng| {
            let size = [rng.u32(1..60), rng.u32(1..40)];
            for n_ranks in [1, 2, 3, 4, 5, 8, 13] {
                let images: Vec<_> = (0..n_ranks).map(|_| random_image(&mut rng, size)).collect();
                let mut order: Vec<usize> = (0..n_ranks).collect();
                rng.shuffle(&mut order);
                // Some have no box.
                order.truncate(rng.usize(1..=n_ranks));
                let mut expected = Image::filled(size[0], size[1], [0.0; 4]);
                for rank in &order {
                    let pixels = expected.pixels_mut().iter_mut().zip(images[*rank].pixels());
                    pixels.for_each(|(front, behind)| *front = over(*front, *behind));
                }
                let limit = Duration::from_secs(20);
                let ranks = ThreadRank::run(n_ranks, limit, |comm| {
                    let empty = Image::filled(size[0], size[1], [0.0; 4]);
                    let has_box = order.contains(&comm.rank());
                    let own = if has_box { &images[comm.rank()] } else { &empty };
                    composite(comm, own, &order)
                });
                let mut ranks = ranks.into_iter();
                assert!(ranks.next() == Some(Ok(Some(expected))), "{n_ranks} ranks, {size:?}");
                assert!(ranks.all(|other| other == Ok(None)));
            }
        });
    }

    #[test]
    fn bands_are_all_rows_that_have_anything() {
        for_each_seed(100, |mut rng| {
            let size = [rng.u32(1..60), rng.u32(1..40)];
            let n_ranks = rng.usize(1..20);
            let extents: Vec<_> =
                (0..n_ranks).map(|_| Extent::of(&random_image(&mut rng, size))).collect();
            let bands = bands(&extents, size[1]);
            assert_eq!(bands.len(), n_ranks);
            assert!(bands.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert_eq!(bands[0].start, 0);
            let last = extents.iter().map(|extent| extent.rows.end).max();
            assert!(last <= Some(bands[n_ranks - 1].end), "{bands:?}");
        });
    }
}
