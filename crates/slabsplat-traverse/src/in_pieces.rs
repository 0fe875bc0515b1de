//! Work on much memory, in pieces between which a frame may be cancelled.

use rayon::prelude::*;
use slabsplat_core::{Cancelled, FrameHandle};

/// Bytes that are filled between two looks at whether anyone still wants them: half a millisecond.
const BYTES_AT_ONCE: usize = 1 << 21;

/// Items that are sorted at once: half a millisecond.
const SORTED_AT_ONCE: usize = 1 << 13;

/// Items that a thread goes through between two looks.
const PASSED_AT_ONCE: usize = 1 << 12;

/// Makes a vector as long as `n_items`, as [`Vec::resize`] does with default values, for a frame: a new page
/// of memory takes its time when it is first touched.
///
/// # Errors
/// If the frame is cancelled; the vector may then have any length up to that.
pub fn resize_for_frame<T: Clone + Default>(
    items: &mut Vec<T>,
    n_items: usize,
    frame: &FrameHandle,
) -> Result<(), Cancelled> {
    items.truncate(n_items);
    items.reserve(n_items - items.len());
    let at_once = BYTES_AT_ONCE / size_of::<T>().max(1);
    while items.len() < n_items {
        frame.check()?;
        items.resize(n_items.min(items.len() + at_once), T::default());
    }
    Ok(())
}

/// Sorts items of which no two are equal, in parallel, for a frame; if that is cancelled they end in any
/// order.
///
/// A sort by comparison cannot be left on the way. So items are parted about a pivot, as in any quicksort,
/// until there are so few that the library sorts them at once.
pub(crate) fn sort_for_frame<T: Ord + Copy + Send>(items: &mut [T], frame: &FrameHandle) {
    if items.len() <= SORTED_AT_ONCE {
        if !frame.is_cancelled() {
            items.sort_unstable();
        }
        return;
    }
    let pivot = pivot(items);
    let Ok(n_below) = part(items, pivot, frame) else { return };
    let (below, others) = items.split_at_mut(n_below);
    rayon::join(|| sort_for_frame(below, frame), || sort_for_frame(others, frame));
}

/// The middle of some items from all over; not the least, as none is equal to it.
fn pivot<T: Ord + Copy>(items: &[T]) -> T {
    // Evenly spread ones might all be of one row of voxels, by its length.
    let spread = |idx: usize| idx.wrapping_mul(0x9e37_79b9) % items.len();
    let mut some: [T; N_TRIED] = std::array::from_fn(|idx| items[spread(idx)]);
    some.sort_unstable();
    some[N_TRIED / 2]
}

const N_TRIED: usize = 63;

/// Moves the items less than the pivot to the front; returns how many they are.
fn part<T: Ord + Copy>(items: &mut [T], pivot: T, frame: &FrameHandle) -> Result<usize, Cancelled> {
    let mut n_below = 0;
    for start in (0..items.len()).step_by(PASSED_AT_ONCE) {
        frame.check()?;
        for idx in start..items.len().min(start + PASSED_AT_ONCE) {
            // Without a branch, as nobody can guess.
            let is_below = items[idx] < pivot;
            items.swap(idx, n_below);
            n_below += usize::from(is_below);
        }
    }
    Ok(n_below)
}

/// What `of` makes of each item, in parallel and in the order of items, for a frame. Each thread has a room
/// of its own; none should take more than half a millisecond for an item.
///
/// # Errors
/// If the frame is cancelled.
pub fn map_for_frame<T: Sync, Room: Default, U: Send>(
    items: &[T],
    frame: &FrameHandle,
    of: impl Fn(&mut Room, &T) -> U + Sync,
) -> Result<Vec<U>, Cancelled> {
    let of_item = |room: &mut Room, item: &T| frame.check().map(|()| of(room, item));
    items.par_iter().map_init(Room::default, of_item).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn sort_for_frame_sorts() {
        for_each_seed(1, |mut rng| {
            for n_items in [0, 1, 1000, SORTED_AT_ONCE + 1, 9 * SORTED_AT_ONCE] {
                let orders: [fn(&mut fastrand::Rng, u32) -> u32; 3] =
                    [|_, idx| idx, |_, idx| u32::MAX - idx, |rng, _| rng.u32(..100)];
                for order in orders {
                    let mut items: Vec<[u32; 2]> =
                        (0..n_items as u32).map(|idx| [order(&mut rng, idx), idx]).collect();
                    let mut expected = items.clone();
                    expected.sort_unstable();
                    sort_for_frame(&mut items, &FrameHandle::new());
                    assert!(items == expected, "{n_items}");
                }
            }
        });
    }

    #[test]
    fn in_pieces_stops_when_cancelled() {
        let frame = FrameHandle::new();
        let mut items: Vec<u64> = vec![7; 3];
        assert_eq!(resize_for_frame(&mut items, 1 << 20, &frame), Ok(()));
        assert_eq!(
            (items.len(), &items[..4], items[(1 << 20) - 1]),
            (1 << 20, &[7, 7, 7, 0][..], 0)
        );
        assert_eq!(resize_for_frame(&mut items, 2, &frame), Ok(()));
        assert_eq!(items, [7, 7]);
        frame.cancel();
        assert_eq!(resize_for_frame(&mut items, 3, &frame), Err(Cancelled));
        let mut falling: Vec<usize> = (0..2 * SORTED_AT_ONCE).rev().collect();
        sort_for_frame(&mut falling, &frame);
        assert!(falling.is_sorted_by(|a, b| b < a), "left as it was");
    }

    #[test]
    fn map_for_frame_keeps_the_order_and_ends_when_nobody_waits() {
        let items: Vec<u32> = (0..5000).collect();
        let twice = |seen: &mut u32, item: &u32| {
            *seen += 1;
            2 * item
        };
        let frame = FrameHandle::new();
        let expected: Vec<u32> = items.iter().map(|item| 2 * item).collect();
        assert_eq!(map_for_frame(&items, &frame, twice), Ok(expected));
        frame.cancel();
        assert_eq!(map_for_frame(&items, &frame, twice), Err(Cancelled));
    }
}
