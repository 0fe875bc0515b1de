//! The paper's method (§3.2): kernel sections summed in slabs parallel to the image, slab by slab from
//! the eye.
//!
//! The depth of the volume is gone through in *ranges* of slabs, front to back. For each, the bricks whose first section
//! lies in it are *taken in* (`intake.rs`), but for what lies behind full parts of the image; then every tile
//! *advances* to the end of the range (`advance.rs`). So what is hidden is never looked at, buffers hold
//! one range instead of the volume, and what they hold is still in the caches when the tiles read it.
//!
//! A voxel waits with its tile in the bucket of the first slab that its kernel meets. A slab takes its sections from
//! that bucket and from those of the few slabs before it, as far as a kernel reaches; so the work is
//! linear in sections, and a voxel is stored once a tile instead of once a section.
//!
//! Reading order: `slab_shapes`, `span`, `occlusion`, `intake`, `prepare`, `sections`, `products`, `advance`.

mod advance;
mod intake;
mod occlusion;
mod prepare;
mod products;
mod sections;
mod slab_shapes;
mod span;

use crate::frame::Stage;
use crate::knots;
use crate::polynomials::Fits;
use crate::raster::{PixelShape, Raster};
use crate::stopwatch::Stopwatch;
use crate::tiles::Tiles;
use crate::workspace::Workspaces;
use intake::Intake;
use occlusion::Occlusion;
use products::AsProducts;
use rayon::prelude::*;
use slab_shapes::SlabShapes;
use slabsplat_core::{Compositing, SlabGrid};
use slabsplat_kernel::{SectionLevels, SectionProducts, SectionTable, chord_units_per_index};
use slabsplat_traverse::Brick;

pub(crate) use intake::Scratch;
pub(crate) use span::Span;

/// How thick a range of slabs is, in voxel steps: some three bricks. Thinner, and most voxels would wait for another
/// range; thicker, and more is taken in that turns out to be hidden.
const RANGE_THICKNESS: f64 = 32.0;

/// The part of the tolerance by which a section may be off that is drawn as a product.
const SHARE_OF_PRODUCTS: f64 = 1.0 / 8.0;

/// What is kept from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    shapes: SlabShapes,
    intake: Intake,
    occlusion: Occlusion,
    /// The range in which each brick is taken in, and its place in the list; sorted.
    bricks: Vec<(u32, u32)>,
}

/// The slabs of a frame and what they cut.
pub(crate) struct Slabs<'a> {
    grid: &'a SlabGrid,
    raster: &'a Raster,
    table: &'a SectionTable,
    polynomials: &'a Fits,
    fewer: Option<Fewer<'a>>,
    shapes: &'a SlabShapes,
    slabs_per_depth: f32,
    /// The number of the first slab, counted from the grid's centre.
    first_slab: f32,
    /// Half the thickness of a kernel along a ray, in index units: its radius, or more if slabs are tilted.
    reach_in_index: f32,
    /// `2/R²`.
    edge_per_disc: f32,
    /// Units of chords in an index unit.
    chord_units_per_index: f32,
    /// The first slab whose sections are drawn.
    first_drawn: usize,
    /// How many slabs before a slab the voxels may start whose sections it holds: a kernel that is k slabs
    /// thick meets up to ⌈k⌉ + 1 of them.
    n_before: usize,
    /// Whether sections are read from the table pixel by pixel: no polynomial is good enough, or slabs cut
    /// footprints at an offset that differs from pixel to pixel.
    reads_table: bool,
    /// Voxels of no more extinction may be drawn as products.
    most_of_products: f32,
    /// Sections of voxels of no more extinction are drawn by few powers.
    most_of_few: f32,
}

/// What is drawn, and how.
pub(crate) struct Job<'a> {
    pub(crate) stage: &'a Stage<'a>,
    pub(crate) slabs: &'a SlabGrid,
    pub(crate) table: &'a SectionTable,
    pub(crate) polynomials: &'a Fits,
    pub(crate) fewer: Option<Fewer<'a>>,
}

/// What is needed to draw fewer sections than there are.
#[derive(Clone, Copy)]
pub(crate) struct Fewer<'a> {
    pub(crate) tolerance: f64,
    pub(crate) levels: &'a SectionLevels,
    pub(crate) table: &'a SectionTable,
    pub(crate) polynomials: &'a Fits,
    pub(crate) products: Option<&'a SectionProducts>,
}

impl Job<'_> {
    /// The most extinction of a voxel whose sections few powers give well enough.
    fn most_of_few(&self, n_sections: usize) -> f32 {
        // Only where colours are weighted with it do errors shrink with the extinction.
        if self.stage.plan.compositing == Compositing::Separate {
            return f32::NEG_INFINITY;
        }
        let folded =
            self.fewer.map_or(f32::INFINITY, |fewer| fewer.polynomials.most_of_few(n_sections));
        self.polynomials.most_of_few(n_sections).min(folded)
    }
}

impl Fewer<'_> {
    /// The most extinction of a voxel whose sections may be drawn as products.
    fn most_of_products(&self) -> f32 {
        let Some(products) = self.products else { return f32::NEG_INFINITY };
        let peak = f64::from(products.whole()) * products.profile_at(0.0).powi(2);
        let error = products.error() + knots::WORST_ERROR * peak;
        (SHARE_OF_PRODUCTS * self.tolerance / error) as f32
    }
}

/// Renders into empty tiles; returns how many voxels were never tossed, being hidden.
pub(crate) fn render(
    job: &Job<'_>,
    tiles: &mut Tiles,
    buffers: &mut Buffers,
    workspaces: &mut Workspaces,
    watch: &mut Stopwatch,
) -> u64 {
    let Buffers { shapes, intake, occlusion, bricks } = buffers;
    let stage = job.stage;
    let products = job.fewer.and_then(|fewer| fewer.products);
    shapes.update(&stage.raster, &stage.plan.view, job.slabs, products);
    let slabs = Slabs::new(job, shapes);
    let slabs_per_range = slabs.per_range(stage.plan.volume.grid().unit());
    sort_bricks(stage, &slabs, slabs_per_range, bricks);
    watch.done("bricks");
    occlusion.start(stage.plan.view.image_size(), &tiles.tiles);
    let (mut n_hidden, mut start, mut rest) = (0, 0_usize, bricks.as_slice());
    let mut first_slabs = 0..0;
    while let Some(&(range, _)) = rest.first() {
        let (here, behind) = rest.split_at(rest.partition_point(|brick| brick.0 == range));
        let taken = intake.take(stage, &slabs, &tiles.grid, occlusion, here, workspaces);
        n_hidden += taken.n_hidden;
        // What still waits went to some slab before, no longer ago than it is drawn.
        let waiting = start.saturating_sub(slabs.n_before).min(first_slabs.end)..first_slabs.end;
        first_slabs = match taken.first_slabs {
            Some(new) if waiting.is_empty() => new,
            Some(new) => new.start.min(waiting.start)..new.end.max(waiting.end),
            None => waiting,
        };
        watch.done("intake");
        // The last range goes on until no voxel is left that was taken in.
        let end =
            behind.first().map_or(slabs.grid.n_slabs(), |next| next.0 as usize * slabs_per_range);
        advance::through(start..end, first_slabs.clone(), stage, &slabs, tiles, intake, workspaces);
        occlusion.note(&tiles.tiles);
        watch.done("splat");
        (start, rest) = (end, behind);
    }
    n_hidden
}

/// Sorts the bricks by the range of slabs in which their first section lies, and then by memory order.
fn sort_bricks(
    stage: &Stage<'_>,
    slabs: &Slabs<'_>,
    slabs_per_range: usize,
    bricks: &mut Vec<(u32, u32)>,
) {
    // Where slabs are thick, a whole voxel may go to one before all that its kernel meets. What rounding does at a face is
    // in the bounds.
    let n_met_before = (f64::from(slabs.raster.reach) / slabs.grid.thickness()) as usize;
    let most_before = slabs.fewer.map_or(0, |_| SectionLevels::MOST_SLABS_BEFORE);
    let n_early = most_before.saturating_sub(n_met_before);
    let range_of = |brick: &Brick| {
        let bounds = stage.bricks.bounds(brick);
        let first = slabs.meeting(bounds.center[2] - bounds.half_extents[2])[0];
        first.saturating_sub(n_early) / slabs_per_range
    };
    let listed = stage.list.bricks().par_iter().enumerate();
    listed.map(|(idx, brick)| (range_of(brick) as u32, idx as u32)).collect_into_vec(bricks);
    bricks.par_sort_unstable();
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.intake.resident_bytes()
            + self.occlusion.resident_bytes()
            + self.bricks.capacity() * size_of::<(u32, u32)>()
    }
}

impl<'a> Slabs<'a> {
    fn new(job: &'a Job<'_>, shapes: &'a SlabShapes) -> Self {
        let Job { stage, slabs: grid, table, polynomials, fewer } = *job;
        let (raster, view) = (&stage.raster, stage.plan.view);
        let thickness = f64::from(2.0 * raster.reach) / grid.thickness();
        let mut slabs = 0..grid.n_slabs();
        let is_exact = fewer.is_some() || polynomials.are_exact(stage.plan.compositing);
        Self {
            grid,
            raster,
            table,
            polynomials,
            fewer,
            shapes,
            slabs_per_depth: (1.0 / grid.thickness()) as f32,
            first_slab: (grid.front(0) / grid.thickness()).round() as f32,
            reach_in_index: raster.reach * raster.index_per_depth,
            edge_per_disc: 2.0 / (raster.radius * raster.radius),
            chord_units_per_index: chord_units_per_index(raster.radius.into()) as f32,
            first_drawn: slabs.find(|&slab| view.draws_slab(grid.faces(slab))).unwrap_or(slabs.end),
            n_before: (thickness.ceil() as usize).min(grid.n_slabs()),
            reads_table: raster.is_tilted || !is_exact,
            most_of_products: fewer.map_or(f32::NEG_INFINITY, |fewer| fewer.most_of_products()),
            most_of_few: job.most_of_few(thickness.ceil() as usize + 1),
        }
    }

    /// The sections of slabs, or of all that lies before or behind a face.
    #[inline(always)]
    fn tables(&self, is_folded: bool) -> (&'a SectionTable, &'a Fits) {
        match self.fewer {
            Some(fewer) if is_folded => (fewer.table, fewer.polynomials),
            _ => (self.table, self.polynomials),
        }
    }

    /// How sections in a slab are drawn as products, if they are.
    #[inline(always)]
    fn as_products(&self, slab: usize) -> Option<AsProducts<'a>> {
        let products = self.fewer?.products?;
        Some(AsProducts { products, spline: self.shapes.spline(slab)? })
    }

    fn per_range(&self, unit: f64) -> usize {
        ((RANGE_THICKNESS * unit / self.grid.thickness()) as usize).clamp(1, self.grid.n_slabs())
    }

    /// The first and the last slab that the kernel of a voxel at that depth meets.
    #[inline]
    fn meeting(&self, depth: f32) -> [usize; 2] {
        let reach = self.raster.reach;
        self.grid.meeting(f64::from(depth - reach), f64::from(depth + reach))
    }

    #[inline]
    fn shape(&self, slab: usize) -> PixelShape {
        self.shapes.of(self.raster, self.grid, slab)
    }
}
