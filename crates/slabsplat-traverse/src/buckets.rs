//! Items by bucket: the counting sort behind both levels of the toss (paper §7).
//!
//! It is linear, and stable: a bucket holds its items in the order in which they came.

use crate::in_pieces::resize_for_frame;
use slabsplat_core::{Cancelled, FrameHandle};
use std::ops::Range;

/// Items by bucket. Made to be used again: it keeps the memory of the fullest sort that it has done.
#[derive(Debug)]
pub struct Buckets<T> {
    /// Where the items of each bucket start, and where the last ones end.
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T> Default for Buckets<T> {
    fn default() -> Self {
        Self { starts: Vec::new(), items: Vec::new() }
    }
}

impl<T: Copy + Default> Buckets<T> {
    /// So many items may be read from any slot on that holds one: behind the last one there are others, of
    /// no meaning.
    pub const N_AT_ONCE: usize = 8;

    /// Sorts the entries of `runs` into `n_buckets` buckets, of which `bucket_of` returns one for each;
    /// `item_of` makes of an entry what is held. If the frame is cancelled on the way, they may be any of the
    /// items, or none.
    #[inline(always)]
    pub fn sort<'a, E: 'a>(
        &mut self,
        n_buckets: usize,
        runs: impl Iterator<Item = &'a [E]> + Clone,
        bucket_of: impl Fn(&E) -> usize,
        item_of: impl Fn(&E) -> T,
        frame: &FrameHandle,
    ) {
        // One entry more than counts need: while items are placed, `starts[bucket + 1]` is where the next one
        // of a bucket goes, and ends up as where the bucket after it starts.
        self.starts.clear();
        self.starts.resize(n_buckets + 2, 0);
        let starts = self.starts.as_mut_slice();
        // Whoever cancels between the two ways through them finds none on the second.
        let runs = runs.take_while(|_| !frame.is_cancelled());
        for run in runs.clone() {
            for entry in run {
                starts[bucket_of(entry) + 2] += 1;
            }
        }
        let mut sum = 0;
        for count in starts {
            sum += *count;
            *count = sum;
        }
        if self.make_room(sum as usize + Self::N_AT_ONCE, frame).is_err() {
            return self.starts.clear();
        }
        let (starts, items) = (self.starts.as_mut_slice(), self.items.as_mut_slice());
        for run in runs {
            for entry in run {
                let next = &mut starts[bucket_of(entry) + 1];
                let slot = *next as usize;
                *next += 1;
                items[slot] = item_of(entry);
            }
        }
    }

    /// There are many of these: twice as much as is needed would be felt.
    fn make_room(&mut self, n_items: usize, frame: &FrameHandle) -> Result<(), Cancelled> {
        if self.items.capacity() < n_items {
            // Without what they hold, which would only be copied.
            self.items = Vec::new();
            self.items.reserve_exact(n_items + n_items / 8);
        }
        let n_items = n_items.max(self.items.len());
        resize_for_frame(&mut self.items, n_items, frame)
    }
}

impl<T> Buckets<T> {
    /// Where the items of some buckets, one behind the other, lie in [`items`](Self::items); none before the
    /// first sort.
    #[inline]
    pub fn slots(&self, buckets: Range<usize>) -> Range<usize> {
        let [start, end] = [buckets.start, buckets.end]
            .map(|bucket| self.starts.get(bucket).map_or(0, |&s| s as usize));
        start..end.max(start)
    }

    /// The first and the last of some buckets that hold anything, unless all are empty or there was no sort.
    pub fn ends_held(&self, buckets: Range<usize>) -> Option<[usize; 2]> {
        let starts = self.starts.get(buckets.start..=buckets.end)?;
        let (first, end) = (*starts.first()?, *starts.last()?);
        let last_before = |n_before: usize| buckets.start + n_before - 1;
        (first < end).then(|| {
            let begins = starts.partition_point(|start| *start <= first);
            [last_before(begins), last_before(starts.partition_point(|start| *start < end))]
        })
    }

    /// The items of some buckets, one behind the other.
    #[inline]
    pub fn items_of(&self, buckets: Range<usize>) -> &[T] {
        &self.items[self.slots(buckets)]
    }

    /// All items, by bucket, and behind them some of no meaning.
    #[inline(always)]
    pub fn items(&self) -> &[T] {
        &self.items
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        self.starts.capacity() * size_of::<u32>() + self.items.capacity() * size_of::<T>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    /// Most frames have a few items more than the last; they fit beside.
    #[test]
    fn buckets_have_room_for_an_eighth_more() {
        let mut sorted = Buckets::default();
        let sort = |sorted: &mut Buckets<u32>, n_items: usize| {
            let entries = vec![0_u32; n_items];
            let (runs, frame) = ([entries.as_slice()].into_iter(), FrameHandle::new());
            sorted.sort(1, runs, |_| 0, |&entry| entry, &frame);
            sorted.items.capacity()
        };
        let capacity = sort(&mut sorted, 8000);
        assert_eq!([8001, 8500, 8990].map(|n_items| sort(&mut sorted, n_items)), [capacity; 3]);
        assert!(capacity < sort(&mut sorted, 9500));
    }

    #[test]
    fn buckets_are_a_stable_sort() {
        for_each_seed(1, |mut rng| {
            let mut sorted = Buckets::default();
            assert!(sorted.items_of(0..3).is_empty(), "nothing before the first sort");
            assert_eq!(sorted.ends_held(0..3), None);
            let frame = FrameHandle::new();
            sorted.sort(1, [&[8, 9][..]].into_iter(), |_| 0, |&entry| entry, &frame);
            assert_eq!(sorted.items_of(0..1), [8, 9]);
            for n_items in [0, 1, 7, 500, 20] {
                let entries: Vec<(usize, u32)> =
                    (0..n_items).map(|idx| (rng.usize(0..9), idx)).collect();
                sorted.sort(9, entries.chunks(7), |entry| entry.0, |entry| entry.1, &frame);
                for first in 0..9 {
                    for end in first..10 {
                        let mut expected: Vec<_> =
                            entries.iter().filter(|e| (first..end).contains(&e.0)).collect();
                        expected.sort_by_key(|entry| entry.0);
                        let expected: Vec<u32> = expected.iter().map(|entry| entry.1).collect();
                        assert_eq!(sorted.items_of(first..end), expected, "{first}..{end}");
                        let readable = sorted.slots(first..end).end + Buckets::<u32>::N_AT_ONCE;
                        assert!(readable <= sorted.items().len());
                        let held =
                            || entries.iter().map(|e| e.0).filter(|b| (first..end).contains(b));
                        let ends = held().min().zip(held().max()).map(|(a, b)| [a, b]);
                        assert_eq!(sorted.ends_held(first..end), ends);
                    }
                }
            }
        });
    }

    #[test]
    fn buckets_of_a_cancelled_frame_can_be_read() {
        let frame = FrameHandle::new();
        let mut sorted = Buckets::default();
        let entries: Vec<usize> = (0..1000).collect();
        for is_cancelled in [false, true] {
            if is_cancelled {
                frame.cancel();
            }
            let runs = entries.chunks(100);
            sorted.sort(10, runs, |&idx| idx % 10, |&idx| idx as u32, &frame);
            let n_held: usize =
                (0..10).map(|bucket| sorted.items_of(bucket..bucket + 1).len()).sum();
            assert_eq!(n_held, if is_cancelled { 0 } else { 1000 });
        }
    }

    #[test]
    fn buckets_take_hardly_more_than_they_need() {
        let mut sorted = Buckets::default();
        for n_items in [1000, 3000, 10_000] {
            let entries: Vec<usize> = (0..n_items).collect();
            let (runs, frame) = ([&entries[..]].into_iter(), FrameHandle::new());
            sorted.sort(1000, runs, |&idx| idx % 1000, |&idx| idx as u32, &frame);
            let needed = (1000 + n_items) * size_of::<u32>();
            let bytes = sorted.resident_bytes();
            assert!((needed..needed + needed / 8).contains(&bytes), "{bytes} of {needed}");
        }
    }
}
