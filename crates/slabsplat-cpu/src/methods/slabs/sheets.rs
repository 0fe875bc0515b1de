//! What a method says of the sheets of a frame that goes through slabs: what becomes of the sums of each
//! layer in a slab, and of the slab.

use super::regions::RegionsOnTile;
use crate::pixels::blocks::Blocks;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use fearless_simd::Simd;

/// What becomes of the sheets of a tile.
pub(in crate::methods) trait Sheets: Sync {
    /// What a tile retains from slab to slab.
    type Retained: Default + Send;
    /// What a thread needs beside.
    type Scratch: Default + Send;

    /// The slabs that a sheet has the sums of: one, or two that follow each other, with two channels each.
    const AT_ONCE: usize;

    /// For how many slabs behind one its sheet is needed.
    const N_BEHIND: usize;

    /// The depth before which nothing is left to be composited, once all slabs before one were taken.
    fn front(&self, slab: usize) -> f32;

    /// Whether a slab has a part in a region; if not, it is in it or not by its middle.
    fn splits_slabs(&self) -> bool;

    /// The blocks in which the sums of a layer matter, be they of those that are needed at all.
    fn needed(&self, _: SlabOnTile<'_>, _layer: usize) -> Blocks {
        Blocks::ALL
    }

    /// Takes what the sections of a layer in a slab, or in it and the next, sum to; or leaves it to
    /// [`show`](Self::show).
    #[inline(always)]
    fn take<S: Simd>(
        &self,
        _simd: S,
        _slab: SlabOnTile<'_>,
        _layer: usize,
        _sums: SlabSums<'_>,
        _retained: &mut Self::Retained,
        _scratch: &mut Self::Scratch,
    ) {
    }

    /// Composites what can be, once the sums of all layers were taken, and leaves both sheets empty.
    fn show<S: Simd>(
        &self,
        simd: S,
        slab: SlabOnTile<'_>,
        sums: SlabSums<'_>,
        tile: &mut Tile,
        retained: &mut Self::Retained,
        scratch: &mut Self::Scratch,
    );

    /// Frees what a tile retains, if it needs it no more.
    fn release(&self, _retained: &mut Self::Retained, _scratch: &mut Self::Scratch) {}

    /// Bytes that a thread's scratch holds.
    fn scratch_bytes(scratch: &Self::Scratch) -> usize;
}

/// A slab of a tile, or the first of two.
#[derive(Clone, Copy)]
pub(in crate::methods) struct SlabOnTile<'a> {
    pub(in crate::methods) slab: usize,
    pub(in crate::methods) regions: RegionsOnTile<'a>,
}

/// The sheets of a slab; both are empty between slabs.
pub(in crate::methods) struct SlabSums<'a> {
    /// Of a layer, and of those before it as long as nobody takes them.
    pub(in crate::methods) of_layer: &'a mut Sheet,
    /// Room for the sum of all.
    pub(in crate::methods) joined: &'a mut Sheet,
}
