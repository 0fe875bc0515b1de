//! The paper's method (§3.2): kernel sections summed in slabs parallel to the image, slab by slab from
//! the eye.
//!
//! A voxel waits in the bucket of the first slab that its kernel meets. A slab takes its sections from
//! that bucket and from those of the few slabs before it, as far as a kernel reaches; so the work is
//! linear in sections, and a voxel is stored once a tile instead of once a section.

use crate::composite::Composite;
use crate::frame::Stage;
use crate::open_pixels::OpenPixels;
use crate::raster::PixelShape;
use crate::sheet::Sheet;
use crate::splat::{Footprint, splat};
use crate::tile::{Scratch, Tile, TileStats};
use slabsplat_core::SlabGrid;
use slabsplat_kernel::{SectionTable, lerp_radial};
use slabsplat_traverse::{TileBuckets, TileRect};

/// Tosses every voxel onto the tiles that any of its sections touches.
pub(crate) fn toss(stage: &Stage<'_>, slabs: &SlabGrid) -> TileBuckets {
    TileBuckets::toss(&stage.tiles, stage.points.len(), |voxel| touched(stage, slabs, voxel))
}

/// A section's place and size change monotonically with its slab's depth, so that the first and the
/// last section bound all of them.
fn touched(stage: &Stage<'_>, slabs: &SlabGrid, voxel: usize) -> Option<TileRect> {
    let point = stage.points[voxel];
    let [first, last] = slabs_of(stage, slabs, point[2]);
    let first = (first..=last).find(|&slab| is_drawn(stage, slabs, slab))?;
    let [near, far] = [first, last]
        .map(|slab| stage.raster.bounds(&stage.raster.shape_at(slabs.middle(slab)), point));
    let min = [0, 1].map(|axis| near[0][axis].min(far[0][axis]));
    let max = [0, 1].map(|axis| near[1][axis].max(far[1][axis]));
    stage.tiles.touched(min, max)
}

/// The first and the last slab that the kernel of a voxel at that depth meets.
#[inline]
fn slabs_of(stage: &Stage<'_>, slabs: &SlabGrid, depth: f32) -> [usize; 2] {
    let reach = stage.raster.reach;
    slabs.meeting(f64::from(depth - reach), f64::from(depth + reach))
}

fn is_drawn(stage: &Stage<'_>, slabs: &SlabGrid, slab: usize) -> bool {
    stage.plan.view.draws_slab(slabs.faces(slab))
}

/// Splats and composites the tile's sheets, front to back, until the tile is full.
pub(crate) fn render_tile<C: Composite>(
    stage: &Stage<'_>,
    slabs: &SlabGrid,
    table: &SectionTable,
    tile: &mut Tile,
    scratch: &mut Scratch,
) -> TileStats {
    let Scratch { splats, buckets, sheet, row } = scratch;
    let mut stats = TileStats::default();
    buckets.toss(splats, |voxel| slabs_of(stage, slabs, stage.points[voxel as usize][2])[0]);
    let Some([first, last]) = buckets.slab_range() else { return stats };
    sheet.resize(tile.side);
    row.resize(table.row_len(), 0.0);
    // A kernel that is k slabs thick meets up to ⌈k⌉ + 1 of them.
    let thickness = slabs.thickness();
    let n_slabs_before = (2.0 * f64::from(stage.raster.reach) / thickness).ceil() as usize;
    let last = (last + n_slabs_before).min(slabs.n_slabs() - 1);
    for slab in first..=last {
        if !is_drawn(stage, slabs, slab) {
            continue;
        }
        let shape = stage.raster.shape_at(slabs.middle(slab));
        let faces = slabs.faces(slab).map(|face| face as f32);
        let section = SectionSplatter { stage, table, shape, faces, origin: tile.origin };
        for &voxel in buckets.starting_in(slab.saturating_sub(n_slabs_before), slab) {
            match section.splat(voxel as usize, &tile.open, sheet, row) {
                Splatted::Yes => stats.n_splats += 1,
                Splatted::Hidden => stats.n_culled += 1,
                Splatted::NotCut => {}
            }
        }
        tile.put_behind::<C>(sheet);
        stats.is_full = tile.close(stage.plan.opacity_cutoff);
        if stats.is_full {
            let hidden = buckets.starting_in(slab.saturating_sub(n_slabs_before), last);
            stats.n_culled += n_sections_behind(stage, slabs, slab, hidden);
            break;
        }
    }
    stats
}

/// How many sections the voxels have in the slabs behind one.
fn n_sections_behind(stage: &Stage<'_>, slabs: &SlabGrid, slab: usize, voxels: &[u32]) -> u64 {
    let n_behind = |&voxel: &u32| {
        let [first, last] = slabs_of(stage, slabs, stage.points[voxel as usize][2]);
        (last + 1).saturating_sub(first.max(slab + 1)) as u64
    };
    voxels.iter().map(n_behind).sum()
}

/// What became of a section.
enum Splatted {
    Yes,
    /// All pixels that it could touch are full.
    Hidden,
    /// The slab does not cut the voxel's kernel.
    NotCut,
}

/// Splats the sections that one slab cuts.
struct SectionSplatter<'a> {
    stage: &'a Stage<'a>,
    table: &'a SectionTable,
    shape: PixelShape,
    /// Depths of the slab's faces.
    faces: [f32; 2],
    origin: [usize; 2],
}

impl SectionSplatter<'_> {
    /// Adds a voxel's section to the sheet.
    #[inline]
    fn splat(
        &self,
        voxel: usize,
        open: &OpenPixels,
        sheet: &mut Sheet,
        row: &mut [f32],
    ) -> Splatted {
        let (raster, point) = (&self.stage.raster, self.stage.points[voxel]);
        let depth = point[2];
        if depth + raster.reach <= self.faces[0] || self.faces[1] <= depth - raster.reach {
            return Splatted::NotCut;
        }
        let [front, back] = self.faces.map(|face| (face - depth) * raster.index_per_depth);
        let [x, y] = raster.pixel_of(&self.shape, point);
        let footprint = Footprint {
            center: [x - self.origin[0] as f32, y - self.origin[1] as f32],
            radius: raster.radius,
            rho_max: if raster.is_tilted {
                raster.radius
            } else {
                disc_radius(raster.radius, front, back)
            },
            samples_per_index: self.table.samples_per_index(),
        };
        if !footprint.is_open(open, &self.shape) {
            return Splatted::Hidden;
        }
        let color = self.stage.colors[voxel].map(|channel| channel * self.shape.gain);
        if raster.is_tilted {
            let [tilt_x, tilt_y] = self.shape.tilt;
            splat(sheet, open, &self.shape, &footprint, color, |at| {
                let later = tilt_x * at.dx + tilt_y * at.dy;
                self.table.sample_at(at.position, front + later, back + later)
            });
        } else {
            self.table.blend(front, back, row);
            splat(sheet, open, &self.shape, &footprint, color, |at| lerp_radial(row, at.position));
        }
        Splatted::Yes
    }
}

/// The radius of the disc in which a slab between two faces cuts a ball.
fn disc_radius(radius: f32, front: f32, back: f32) -> f32 {
    let nearest = front.max(-back).max(0.0);
    (radius * radius - nearest * nearest).max(0.0).sqrt()
}
