//! Prefix sums and sorting on the device, as passes.

use crate::memory::{Buffer, Memory};
use crate::params::{NO_COUNT, Step};
use crate::pass_list::{PassList, n_groups};
use crate::{Device, Slice};
use slabsplat_backend::BackendError;
use slabsplat_shaders::{SCAN_BLOCKS, SCAN_TOTALS, SORT_COUNT, SORT_SCATTER};

/// Elements that a workgroup sums up or sorts.
pub(crate) const BLOCK: u32 = 2048;

/// Bits of a digit, and digits that these make.
const DIGIT_BITS: u32 = 4;
const N_DIGITS: u64 = 1 << DIGIT_BITS;

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
        self.digits.grow(memory, device, N_DIGITS * n_blocks)
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
        for shift in (0..n_bits).step_by(DIGIT_BITS as usize) {
            let n_elements = max_keys as u32;
            let step = Step { n_elements, count_slot, shift, n_blocks, ..Step::default() };
            let digits = self.digits.elements.all();
            passes.push(&SORT_COUNT, &[self.keys(), digits, counts], step, n_blocks);
            self.digits.scan(passes, counts, N_DIGITS * u64::from(n_blocks), NO_COUNT);
            let totals = self.digits.totals.all();
            let (keys, values) = (self.keys(), self.values());
            self.side = 1 - self.side;
            let moved = [keys, values, digits, totals, self.keys(), self.values(), counts];
            passes.push(&SORT_SCATTER, &moved, step, n_blocks);
        }
    }
}

/// Bits that tell `n` numbers apart, from 0 on.
pub(crate) fn bits_for(n: u32) -> u32 {
    n.saturating_sub(1).checked_ilog2().map_or(0, |highest| highest + 1)
}
