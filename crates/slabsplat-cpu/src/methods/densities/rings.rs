//! The last sheets of all layers, as a tile retains them.

use super::passed::Passed;
use super::sheets::{Limits, Ring};
use crate::pixels::sheet::Sheet;
use fearless_simd::Simd;

/// What a tile retains from slab to slab: of each layer that has begun, its sheets.
#[derive(Debug, Default)]
pub(super) struct Rings {
    of_layers: Vec<Option<Box<Ring>>>,
}

/// What a thread needs beside.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Rings that no tile has.
    spare: Vec<Box<Ring>>,
    /// Surfaces that rays pass between two sheets.
    pub(super) passed: Vec<Passed>,
}

impl Rings {
    /// Takes the sums of a slab and the next of a layer, once it has begun, and empties their sheet.
    #[inline(always)]
    pub(super) fn take<S: Simd>(
        &mut self,
        simd: S,
        (slab, layer): (usize, usize),
        sums: &mut Sheet,
        limits: &Limits,
        scratch: &mut Scratch,
    ) {
        if sums.touched.is_empty() && self.of(layer).is_none() {
            return;
        }
        if self.of_layers.len() <= layer {
            self.of_layers.resize_with(layer + 1, || None);
        }
        let ring =
            self.of_layers[layer].get_or_insert_with(|| scratch.spare.pop().unwrap_or_default());
        ring.push(simd, slab, sums, limits);
    }

    /// The sheets of a layer, if it has begun.
    #[inline(always)]
    pub(super) fn of(&self, layer: usize) -> Option<&Ring> {
        self.of_layers.get(layer)?.as_deref()
    }

    /// Whether none has begun.
    #[inline(always)]
    pub(super) fn are_none(&self) -> bool {
        self.of_layers.iter().all(Option::is_none)
    }

    /// Hands all of them on.
    pub(super) fn release(&mut self, scratch: &mut Scratch) {
        for mut ring in self.of_layers.iter_mut().filter_map(Option::take) {
            ring.clear();
            scratch.spare.push(ring);
        }
    }
}

impl Scratch {
    pub(super) fn resident_bytes(&self) -> usize {
        self.spare.len() * Ring::BYTES + self.passed.capacity() * size_of::<Passed>()
    }
}
