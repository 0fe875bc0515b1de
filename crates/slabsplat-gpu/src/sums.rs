//! Prefix sums and sorting on the device, as passes.

use crate::memory::{Buffer, Memory};
use crate::params::{NO_COUNT, Step};
use crate::pass_list::{PassList, n_groups};
use crate::{Device, Slice};
use slabsplat_backend::BackendError;
use slabsplat_shaders::{SCAN_BLOCKS, SCAN_TOTALS, SORT_COUNT, SORT_SCATTER};

/// Elements that a workgroup sums up or sorts.
pub(crate) const BLOCK: u32 = 2048;

/// Most bits of a digit, and digits that these make: as many as a workgroup has threads.
const MAX_DIGIT_BITS: u32 = 8;
const MAX_DIGITS: u64 = 1 << MAX_DIGIT_BITS;

/// Counts, and their prefix sums in place.
#[derive(Debug)]
pub(crate) struct Sums {
    pub(crate) elements: Buffer,
    pub(crate) totals: Buffer,
}

impl Sums {
    pub(crate) fn new(elements: &'static str, totals: &'static str) -> Self {
        Self { elements: Buffer::new(elements), totals: Buffer::new(totals) }
    }

    pub(crate) fn grow<D: Device>(
        &mut self,
        memory: &mut Memory,
        device: &mut D,
        n_elements: u64,
    ) -> Result<(), BackendError> {
        memory.grow(device, &mut self.elements, 4 * n_elements)?;
        memory.grow(device, &mut self.totals, 4 * u64::from(n_groups(n_elements, BLOCK)))
    }

    pub(crate) fn buffers(&mut self) -> impl Iterator<Item = &mut Buffer> {
        [&mut self.elements, &mut self.totals].into_iter()
    }

    /// Makes the first `n_elements` their exclusive prefix sums; the sum of all goes to a slot of the counts.
    /// An element's sum is then its own plus the total of its block.
    pub(crate) fn scan(&self, passes: &mut PassList, counts: Slice, n_elements: u64, slot: u32) {
        let step = Step { n_elements: n_elements as u32, ..Step::default() };
        let n_blocks = n_groups(n_elements, BLOCK);
        passes.push(&SCAN_BLOCKS, &[self.elements.all(), self.totals.all()], step, n_blocks);
        let step = Step { n_elements: n_blocks, count_slot: slot, ..Step::default() };
        passes.push(&SCAN_TOTALS, &[self.totals.all(), counts], step, 1);
    }
}

/// Keys and values that are sorted together, from one pair of buffers to another and back.
#[derive(Debug)]
pub(crate) struct Sorter {
    /// Keys and values, twice.
    sides: [[Buffer; 2]; 2],
    /// The side on which the list is now.
    side: usize,
    digits: Sums,
}

impl Sorter {
    pub(crate) fn new(labels: [&'static str; 2]) -> Self {
        let side = || labels.map(Buffer::new);
        Self { sides: [side(), side()], side: 0, digits: Sums::new("digits", "digit totals") }
    }

    pub(crate) fn grow<D: Device>(
        &mut self,
        memory: &mut Memory,
        device: &mut D,
        n_keys: u64,
    ) -> Result<(), BackendError> {
        for buffer in self.sides.iter_mut().flatten() {
            memory.grow(device, buffer, 4 * n_keys)?;
        }
        let n_blocks = u64::from(n_groups(n_keys, BLOCK));
        self.digits.grow(memory, device, MAX_DIGITS * n_blocks)
    }

    pub(crate) fn buffers(&mut self) -> impl Iterator<Item = &mut Buffer> {
        self.sides.iter_mut().flatten().chain(self.digits.buffers())
    }

    /// Begins a new list, always on the same side, so that a frame's passes are those of the last.
    pub(crate) fn restart(&mut self) {
        self.side = 0;
    }

    pub(crate) fn keys(&self) -> Slice {
        self.sides[self.side][0].all()
    }

    pub(crate) fn values(&self) -> Slice {
        self.sides[self.side][1].all()
    }

    /// Sorts by the lower `n_bits` of the keys; equal keys stay in their order. There are at most `max_keys`;
    /// a slot of the counts says how many.
    pub(crate) fn sort(
        &mut self,
        passes: &mut PassList,
        counts: Slice,
        (max_keys, count_slot): (u64, u32),
        n_bits: u32,
    ) {
        let n_blocks = n_groups(max_keys, BLOCK);
        for Digit { shift, digit_bits } in digits(n_bits) {
            let n_elements = max_keys as u32;
            let step =
                Step { n_elements, count_slot, shift, digit_bits, n_blocks, ..Step::default() };
            let digits = self.digits.elements.all();
            passes.push(&SORT_COUNT, &[self.keys(), digits, counts], step, n_blocks);
            self.digits.scan(passes, counts, u64::from(n_blocks) << digit_bits, NO_COUNT);
            let totals = self.digits.totals.all();
            let (keys, values) = (self.keys(), self.values());
            self.side = 1 - self.side;
            let moved = [keys, values, digits, totals, self.keys(), self.values(), counts];
            passes.push(&SORT_SCATTER, &moved, step, n_blocks);
        }
    }
}

/// A part of a key: its lowest bit, and how many it has.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Digit {
    shift: u32,
    digit_bits: u32,
}

/// The digits of keys of so many bits, the lowest first: as few as there can be, and of one length, give or
/// take a bit.
fn digits(n_bits: u32) -> impl Iterator<Item = Digit> {
    let n_digits = n_bits.div_ceil(MAX_DIGIT_BITS);
    let begin = move |digit: u32| n_bits * digit / n_digits;
    (0..n_digits).map(move |digit| Digit {
        shift: begin(digit),
        digit_bits: begin(digit + 1) - begin(digit),
    })
}

/// Bits that tell `n` numbers apart, from 0 on.
pub(crate) fn bits_for(n: u32) -> u32 {
    n.saturating_sub(1).checked_ilog2().map_or(0, |highest| highest + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_few_and_cover_keys() {
        let of = |n_bits| digits(n_bits).map(|digit| digit.digit_bits).collect::<Vec<_>>();
        assert_eq!(of(0), [0; 0]);
        assert_eq!((of(1), of(8), of(9)), (vec![1], vec![8], vec![4, 5]));
        assert_eq!((of(12), of(17), of(32)), (vec![6, 6], vec![5, 6, 6], vec![8; 4]));
        for n_bits in 0..=32 {
            let mut covered = 0;
            for Digit { shift, digit_bits } in digits(n_bits) {
                assert_eq!(shift, covered, "{n_bits} bits");
                covered += digit_bits;
            }
            assert_eq!(covered, n_bits);
        }
    }
}
