//! The last sheets of all layers, as a tile retains them, and what becomes of them.

use super::passed::Passed;
use super::sheets::{AT_ONCE, Limits, N_BESIDE, Ring};
use crate::methods::slabs::{Sheets, SlabOnTile, SlabSums};
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use fearless_simd::Simd;

/// What a tile retains from slab to slab: of each layer that has begun, its sheets.
#[derive(Debug, Default)]
pub(in crate::methods) struct Rings {
    of_layers: Vec<Option<Box<Ring>>>,
}

/// What a thread needs beside.
#[derive(Debug, Default)]
pub(in crate::methods) struct Scratch {
    /// Rings that no tile has.
    spare: Vec<Box<Ring>>,
    /// Surfaces that rays pass between two sheets.
    pub(super) passed: Vec<Passed>,
}

/// What becomes of sheets that those around them are needed for.
pub(super) trait RetainedSheets: Sync {
    /// What sums of a layer are worth.
    fn limits(&self, layer: usize) -> &Limits;

    /// As that of [`Sheets`].
    fn front(&self, slab: usize) -> f32;

    /// As that of [`Sheets`].
    fn splits_slabs(&self) -> bool;

    /// Shows what there is at the first of the two sheets in the middle, or between them, if `last` is the
    /// slab of the last one. At least one layer has begun; both sheets of sums are empty, and are left so.
    fn show_middle<S: Simd>(
        &self,
        simd: S,
        last: SlabOnTile<'_>,
        sums: SlabSums<'_>,
        tile: &mut Tile,
        rings: &Rings,
        scratch: &mut Scratch,
    );
}

impl<T: RetainedSheets> Sheets for T {
    type Retained = Rings;
    type Scratch = Scratch;

    const AT_ONCE: usize = AT_ONCE;
    const N_BEHIND: usize = N_BESIDE + 1;

    fn front(&self, slab: usize) -> f32 {
        RetainedSheets::front(self, slab)
    }

    fn splits_slabs(&self) -> bool {
        RetainedSheets::splits_slabs(self)
    }

    #[inline(always)]
    fn take<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab, .. }: SlabOnTile<'_>,
        layer: usize,
        SlabSums { of_layer, .. }: SlabSums<'_>,
        rings: &mut Rings,
        scratch: &mut Scratch,
    ) {
        rings.take(simd, (slab, layer), of_layer, self.limits(layer), scratch);
    }

    #[inline(always)]
    fn show<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab, regions }: SlabOnTile<'_>,
        SlabSums { of_layer, joined }: SlabSums<'_>,
        tile: &mut Tile,
        rings: &mut Rings,
        scratch: &mut Scratch,
    ) {
        if rings.are_none() {
            return;
        }
        for slab in slab..slab + AT_ONCE {
            let sums = SlabSums { of_layer: &mut *of_layer, joined: &mut *joined };
            self.show_middle(simd, SlabOnTile { slab, regions }, sums, tile, rings, scratch);
        }
    }

    fn release(&self, rings: &mut Rings, scratch: &mut Scratch) {
        rings.release(scratch);
    }

    fn scratch_bytes(scratch: &Scratch) -> usize {
        scratch.resident_bytes()
    }
}

impl Rings {
    /// Takes the sums of a slab and the next of a layer, once it has begun, and empties their sheet.
    #[inline(always)]
    fn take<S: Simd>(
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
    fn are_none(&self) -> bool {
        self.of_layers.iter().all(Option::is_none)
    }

    /// Hands all of them on.
    fn release(&mut self, scratch: &mut Scratch) {
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
