//! One tile of the image, from its voxels to its pixels.

use super::buckets::SlabBuckets;
use super::gradient::{Neighborhood, Spacing};
use super::open::Open;
use super::sheet::{Place, Section, Sheet, Sum};
use super::{Stage, TILE_SIDE};
use crate::raster::PixelShape;
use slabsplat_backend::FrameStats;
use slabsplat_core::glam::DVec3;
use slabsplat_kernel::{CubicSectionTable, cubic_at};

/// A square of the image.
pub(super) struct Tile<'a> {
    stage: &'a Stage<'a>,
    /// The image pixel in the upper left corner.
    origin: [usize; 2],
    open: &'a mut Open,
    /// Premultiplied colour and opacity, row by row.
    pixels: &'a mut [[f32; 4]],
    /// Of this tile: splats, and whether it is full.
    pub(super) stats: FrameStats,
}

/// What a thread keeps from tile to tile, and from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    pub(super) open: Open,
    pub(super) scratch: Scratch,
}

/// What is worked with on a tile.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// The voxels on the tile, in the order of the list.
    pub(super) voxels: Vec<u32>,
    buckets: SlabBuckets,
    sheets: Sheets,
}

impl Workspace {
    pub(super) fn resident_bytes(&self) -> usize {
        let Scratch { voxels, buckets, sheets } = &self.scratch;
        let Sheets { before, here, behind } = sheets;
        voxels.capacity() * size_of::<u32>()
            + buckets.resident_bytes()
            + [before, here, behind].map(Sheet::resident_bytes).iter().sum::<usize>()
    }
}

/// The sheet that is classified, and its neighbours.
#[derive(Debug, Default)]
struct Sheets {
    before: Sheet,
    here: Sheet,
    behind: Sheet,
}

impl<'a> Tile<'a> {
    /// A tile of which nothing is drawn: `pixels` are 0, and `open` is overwritten.
    pub(super) fn new(
        stage: &'a Stage<'a>,
        tile_idx: usize,
        open: &'a mut Open,
        pixels: &'a mut [[f32; 4]],
    ) -> Self {
        let origin = stage.tiles.origin(tile_idx);
        open.open_all(stage.inside(origin));
        Self { stage, origin, open, pixels, stats: FrameStats::default() }
    }

    /// Splats the tile's sheets, and classifies and composites each when the one behind it is there, until the tile
    /// is full.
    pub(super) fn render(&mut self, scratch: &mut Scratch) {
        let Scratch { voxels, buckets, sheets } = scratch;
        let stage = self.stage;
        buckets.fill(voxels, |voxel| stage.slabs_of(voxel)[0]);
        let Some([first, last]) = buckets.slab_range() else { return };
        sheets.clear(TILE_SIDE + 2);
        let last = (last + stage.n_slabs_before).min(stage.slabs.n_slabs() - 1);
        for slab in first..=last {
            let first_bucket = slab.saturating_sub(stage.n_slabs_before);
            self.splat(slab, buckets.beginning_in(first_bucket, slab), &mut sheets.behind);
            if first < slab {
                self.classify(slab - 1, sheets);
            }
            if self.open.is_empty() {
                let hidden = buckets.beginning_in(first_bucket, last);
                self.stats.n_culled += stage.n_sections_behind(slab, hidden);
                return;
            }
            sheets.advance(TILE_SIDE + 2);
        }
        self.classify(last, sheets);
    }

    /// Adds the sections that a slab cuts to its sheet.
    fn splat(&mut self, slab: usize, voxels: &[u32], sheet: &mut Sheet) {
        let stage = self.stage;
        if voxels.is_empty() || !stage.plan.view.draws_slab(stage.slabs.faces(slab)) {
            return;
        }
        let shape = stage.raster.shape_at(stage.slabs.middle(slab));
        let faces = stage.slabs.faces(slab).map(|face| face as f32);
        let mut row = [[0.0; 4]; CubicSectionTable::ROW_LEN];
        for &voxel in voxels {
            let depth = stage.points[voxel as usize][2];
            if depth + stage.raster.reach <= faces[0] || faces[1] <= depth - stage.raster.reach {
                continue;
            }
            let cut = faces.map(|face| (face - depth) * stage.raster.index_per_depth);
            if self.splat_section(&shape, voxel, cut, sheet, &mut row) {
                self.stats.n_splats += 1;
            } else {
                self.stats.n_culled += 1;
            }
        }
    }

    /// Adds the section of a voxel between two faces, in index units from its centre. Tells whether it fell on anything
    /// that is summed.
    #[inline]
    fn splat_section(
        &self,
        shape: &PixelShape,
        voxel: u32,
        cut: [f32; 2],
        sheet: &mut Sheet,
        row: &mut [[f32; 4]; CubicSectionTable::ROW_LEN],
    ) -> bool {
        let (stage, table) = (self.stage, self.stage.table);
        let [x, y] = stage.raster.pixel_of(shape, stage.points[voxel as usize]);
        let radius = stage.raster.radius;
        let is_tilted = stage.raster.is_tilted;
        let section = Section {
            center: [x - self.origin[0] as f32 + 1.0, y - self.origin[1] as f32 + 1.0],
            radius,
            rho_max: if is_tilted { radius } else { disc_radius(radius, cut) },
            cells_per_index: table.cells_per_index(),
            value: stage.values[voxel as usize],
        };
        if is_tilted {
            sheet.splat(self.open, shape, &section, |Place { position, offset: [dx, dy] }| {
                let later = shape.tilt[0] * dx + shape.tilt[1] * dy;
                shape.gain * table.weight(position, cut.map(|face| face + later))
            })
        } else {
            table.blend(cut, row);
            let gain = shape.gain;
            sheet.splat(self.open, shape, &section, |at| gain * cubic_at(&row[..], at.position))
        }
    }

    /// Classifies the open pixels of a slab's sheet, and puts them behind what is there.
    fn classify(&mut self, slab: usize, sheets: &Sheets) {
        if sheets.here.is_empty() {
            return;
        }
        let mut spacing = self.stage.spacing_at(slab);
        for row in 0..self.open.n_rows() {
            if !sheets.here.rows().contains(&(row + 1)) {
                continue;
            }
            for column in self.open.open(row) {
                let in_sheet = [column + 1, row + 1];
                spacing.lean =
                    self.stage.rays.lean([self.origin[0] + column, self.origin[1] + row]);
                if let Some(behind) = self.classified(sheets, in_sheet, &spacing) {
                    put_behind(&mut self.pixels[row * TILE_SIDE + column], behind);
                }
            }
        }
        let (pixels, cutoff) = (&*self.pixels, self.stage.plan.opacity_cutoff);
        self.open.close(|[column, row]| cutoff <= pixels[row * TILE_SIDE + column][3]);
        self.stats.n_full_tiles = u64::from(self.open.is_empty());
    }

    /// What a pixel of a sheet adds; `None` if nothing.
    #[inline]
    fn classified(&self, sheets: &Sheets, at: [usize; 2], spacing: &Spacing) -> Option<[f32; 4]> {
        let here = sheets.here.at(at);
        if here.length <= 0.0 {
            return None;
        }
        let classifier = &self.stage.classifier;
        let density = f64::from(here.weighted) / f64::from(here.length);
        let opacity = classifier.opacity(density)?;
        let normal = if classifier.is_lit() {
            sheets.around(at).normal(density, spacing)
        } else {
            DVec3::ZERO
        };
        Some(classifier.premultiplied(here.length.into(), opacity, normal))
    }
}

impl Sheets {
    fn clear(&mut self, side: usize) {
        self.before.clear(side);
        self.here.clear(side);
        self.behind.clear(side);
    }

    /// Goes on by a slab: what was behind is here.
    fn advance(&mut self, side: usize) {
        std::mem::swap(&mut self.before, &mut self.here);
        std::mem::swap(&mut self.here, &mut self.behind);
        self.behind.clear(side);
    }

    #[inline]
    fn around(&self, [column, row]: [usize; 2]) -> Neighborhood {
        let here = |column: usize, row: usize| -> Sum { self.here.at([column, row]) };
        Neighborhood {
            here: here(column, row),
            right_left: [here(column + 1, row), here(column - 1, row)],
            up_down: [here(column, row - 1), here(column, row + 1)],
            behind_before: [self.behind.at([column, row]), self.before.at([column, row])],
        }
    }
}

/// Front to back: `C ← C + (1 − A)·c`, `A ← A + (1 − A)·a`.
#[inline]
fn put_behind(pixel: &mut [f32; 4], behind: [f32; 4]) {
    let through = 1.0 - pixel[3];
    for (channel, behind) in pixel.iter_mut().zip(behind) {
        *channel += through * behind;
    }
}

/// The radius of the disc in which a slab between two faces cuts a ball.
fn disc_radius(radius: f32, [front, back]: [f32; 2]) -> f32 {
    let nearest = front.max(-back).max(0.0);
    (radius * radius - nearest * nearest).max(0.0).sqrt()
}
