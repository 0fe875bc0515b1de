//! Through the slabs of a frame, from the eye: what `image-aligned` and `post-classified` share.
//!
//! ```text
//! for each range of slabs, from the eye:
//!     for each layer:
//!         take in the bricks whose first section lies in it, but for what is occluded (intake.rs):
//!             project, colour, toss their voxels onto tiles
//!     for each tile, in parallel (advance.rs):
//!         toss its voxels by slab
//!         for each slab of the range:
//!             for each layer:
//!                 splat its sections onto the sheet (sections/splat.rs, separable/sections.rs)
//!                 hand the sheet to the method
//!             let the method composite what it has
//!     note which blocks of pixels are saturated (occlusion.rs)
//! ```
//!
//! So what is occluded is never looked at, buffers hold one range instead of the volume, and what they hold
//! is still in the caches when the tiles read it.
//!
//! A voxel waits with its tile in the bucket of the first slab that its kernel meets. A slab takes its
//! sections from that bucket and from those of the few slabs before it, as many as a kernel is thick; so the
//! work is linear in sections, and a voxel is stored once a tile instead of once a section.
//!
//! What a voxel's *colour* is, four numbers that a sheet sums, or two for each of two slabs that are summed
//! at once, and what becomes of a sheet, a method says: [`Voxels`] and [`Sheets`].
//!
//! Reading order: `stage`; `slab_shapes`, `slab_view`, `span_finder`, `classes`, `beyond`, `setup`,
//! `occlusion`, `intake`, `pass`; `regions`, `sheets`, `advance`.

mod advance;
mod beyond;
mod classes;
mod intake;
mod occlusion;
mod pass;
mod regions;
mod setup;
mod sheets;
mod slab_shapes;
mod slab_view;
mod span_finder;
mod stage;

use crate::pixels::tiles::Tiles;
use crate::progress::Progress;
use crate::stopwatch::Stopwatch;
use advance::{OfTile, Workspace};
use intake::{Intake, Scratch};
use occlusion::Occlusion;
use pass::Pass;
use regions::Regions;
pub(super) use setup::SectionsInSlabs;
use setup::{Prepared, Setup};
pub(super) use sheets::{Sheets, SlabOnTile, SlabSums};
use slabsplat_core::Cancelled;
use slabsplat_traverse::Workspaces;
pub(super) use stage::{BrickVoxels, ReadRoom, Stage, Voxels};
use std::{iter, slice};

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Buffers<R, S> {
    of_layers: Vec<OfLayer>,
    of_all: OfAll<R, S>,
}

/// What is cached of all layers together.
#[derive(Debug, Default)]
struct OfAll<R, S> {
    regions: Regions,
    scratches: Workspaces<Scratch>,
    occlusion: Occlusion,
    /// Of each tile, the voxels whose last sections are yet to come, and what the method retains.
    of_tiles: Vec<OfTile<R>>,
    workspaces: Workspaces<Workspace<S>>,
}

/// What is cached of a layer.
#[derive(Debug, Default)]
struct OfLayer {
    prepared: Prepared,
    /// The range in which each brick is taken in, and its index in the list; sorted.
    bricks: Vec<(u32, u32)>,
    intake: Intake,
}

/// Renders layers into empty tiles; returns how many voxels were never tossed, being occluded.
pub(super) fn render<'a, H: Sheets>(
    layers: impl Iterator<Item = (Stage<'a>, SectionsInSlabs<'a>)> + Clone,
    sheets: &H,
    tiles: &mut Tiles,
    buffers: &mut Buffers<H::Retained, H::Scratch>,
    watch: &mut Stopwatch<'_>,
) -> Result<u64, Cancelled> {
    let Buffers { of_layers, of_all } = buffers;
    of_layers.resize_with(layers.clone().count(), OfLayer::default);
    let progress = Progress::of_all(watch.frame());
    render_with(layers, sheets, tiles, (of_layers, of_all), (progress, watch))
}

/// The same with one of so many layers, each of which has its turn.
pub(super) fn render_one<'a, H: Sheets>(
    layer: (Stage<'a>, SectionsInSlabs<'a>),
    (layer_idx, n_layers): (usize, usize),
    sheets: &H,
    tiles: &mut Tiles,
    buffers: &mut Buffers<H::Retained, H::Scratch>,
    watch: &mut Stopwatch<'_>,
) -> Result<u64, Cancelled> {
    let Buffers { of_layers, of_all } = buffers;
    of_layers.resize_with(n_layers, OfLayer::default);
    let progress = Progress::of_all(watch.frame()).part(layer_idx, n_layers);
    let of_layer = slice::from_mut(&mut of_layers[layer_idx]);
    render_with(iter::once(layer), sheets, tiles, (of_layer, of_all), (progress, watch))
}

fn render_with<'a, H: Sheets>(
    layers: impl Iterator<Item = (Stage<'a>, SectionsInSlabs<'a>)> + Clone,
    sheets: &H,
    tiles: &mut Tiles,
    (of_layers, of_all): (&mut [OfLayer], &mut OfAll<H::Retained, H::Scratch>),
    (progress, watch): (Progress<'_>, &mut Stopwatch<'_>),
) -> Result<u64, Cancelled> {
    let OfAll { regions, scratches, occlusion, of_tiles, workspaces } = of_all;
    let n_layers = of_layers.len();
    let plans = layers.clone().map(|(stage, _)| stage.layer);
    if let Some((stage, _)) = layers.clone().next() {
        regions.update(stage.plan, plans, sheets.splits_slabs(), tiles);
    }
    let mut passes = Vec::with_capacity(n_layers);
    for ((stage, sections), of_layer) in layers.zip(of_layers) {
        let OfLayer { prepared, bricks, intake } = of_layer;
        let setup = Setup::new(&stage, &sections, prepared, H::AT_ONCE)?;
        passes.push(Pass::new(stage, setup, bricks, intake));
    }
    watch.done("bricks")?;
    if let Some(range) = first_range(&passes) {
        let first = range as usize * passes[0].setup.slabs.n_per_range;
        tiles.end_rays_before(sheets.front(first), passes[0].stage.plan.opacity_cutoff);
    }
    occlusion.start(&tiles.grid, &tiles.tiles);
    of_tiles.resize_with(tiles.tiles.len(), OfTile::default);
    of_tiles.iter_mut().for_each(|of_tile| of_tile.clear(n_layers));
    let (mut n_taken, mut start) = (0, 0_usize);
    while let Some(range) = first_range(&passes) {
        for idx in 0..passes.len() {
            let taken = passes[idx].take_in(range, start, &tiles.grid, occlusion, scratches);
            n_taken += taken.n_voxels;
            for key in taken.refused {
                let [coarse, fine] = &mut passes[idx..idx + 2] else {
                    unreachable!("voxels come last, which refuse nothing")
                };
                fine.add_late(coarse.stage.voxels.finer(key), range);
            }
        }
        watch.done("intake")?;
        // The last range continues until no voxel is left that was taken in.
        let slabs = &passes[0].setup.slabs;
        let n_slabs = slabs.grid.n_slabs() + H::N_BEHIND;
        let end = first_range(&passes).map_or(n_slabs, |next| next as usize * slabs.n_per_range);
        let how = (sheets, &*regions, progress.between(start, end, n_slabs));
        advance::through(start..end, &passes, how, (tiles, of_tiles), workspaces);
        occlusion.note(&tiles.tiles);
        watch.done("splat")?;
        start = end;
    }
    let n_voxels: u64 = passes.iter().map(|pass| pass.stage.voxels.n_voxels()).sum();
    Ok(n_voxels.saturating_sub(n_taken))
}

/// The range whose bricks come next.
fn first_range(passes: &[Pass<'_>]) -> Option<u32> {
    passes.iter().filter_map(Pass::next_range).min()
}

impl<R, S: Default> Buffers<R, S> {
    pub(super) fn resident_bytes<H: Sheets<Retained = R, Scratch = S>>(&self) -> usize {
        let Self { of_layers, of_all } = self;
        let of_layer = |of_layer: &OfLayer| {
            of_layer.intake.resident_bytes() + of_layer.bricks.capacity() * size_of::<(u32, u32)>()
        };
        of_layers.iter().map(of_layer).sum::<usize>()
            + of_all.scratches.sum_of(Scratch::resident_bytes)
            + of_all.occlusion.resident_bytes()
            + of_all.regions.resident_bytes()
            + of_all.of_tiles.iter().map(OfTile::resident_bytes).sum::<usize>()
            + of_all.workspaces.sum_of(Workspace::resident_bytes::<H>)
    }
}
