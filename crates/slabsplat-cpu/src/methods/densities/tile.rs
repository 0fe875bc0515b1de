//! One tile of the image, from its voxels to its pixels.

use super::density_frame::DensityFrame;
use super::gradient::{Neighborhood, Spacing};
use super::sheet::{Place, Section, Sheet, Sum};
use super::summed::Summed;
use super::voxel::DensityVoxel;
use crate::footprints::raster::PixelShape;
use crate::pixels::tile::Tile;
use crate::voxels::by_sheet::{BySheet, Run};
use slabsplat_core::glam::DVec3;
use slabsplat_kernel::CubicSectionTable;

/// What a thread needs.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    /// Voxels of a tile, by the slab in which each begins.
    pub(super) voxels: BySheet<DensityVoxel>,
    summed: Summed,
    sheets: Sheets,
}

impl Workspace {
    pub(super) fn resident_bytes(&self) -> usize {
        self.voxels.resident_bytes() + 3 * Sheet::BYTES
    }
}

/// The sheet that is classified, and its neighbours.
#[derive(Debug, Default)]
struct Sheets {
    before: Sheet,
    here: Sheet,
    behind: Sheet,
}

impl DensityFrame<'_> {
    /// Splats the sheets of a tile, and classifies and composites each when the one behind it is there, until
    /// the tile is saturated.
    pub(super) fn render_tile(&self, tile: &mut Tile, workspace: &mut Workspace) {
        let Workspace { voxels, summed, sheets } = workspace;
        let (starts, n_before) = (voxels.sheets(), self.slabs.n_before);
        if starts.is_empty() {
            return;
        }
        sheets.clear();
        let end = (starts.end + n_before).min(self.slabs.grid.n_slabs());
        for slab in starts.start..end {
            summed.follow(tile.open);
            let starting_in = slab.saturating_sub(n_before)..slab + 1;
            let here = voxels.starting_in(0, starting_in.clone());
            self.add_slab(slab, here, summed, tile, &mut sheets.behind);
            if starts.start < slab {
                self.classify(slab - 1, sheets, tile);
            }
            if tile.is_saturated() {
                let waiting = voxels.starting_in(0, starting_in.start..usize::MAX);
                tile.stats.n_culled += self.n_sections_behind(slab, waiting);
                return;
            }
            sheets.advance();
        }
        self.classify(end - 1, sheets, tile);
    }

    /// Adds the sections that a slab cuts to its sheet.
    fn add_slab(
        &self,
        slab: usize,
        voxels: Run<'_, DensityVoxel>,
        summed: &Summed,
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) {
        if voxels.len == 0 || slab < self.slabs.first_drawn {
            return;
        }
        let grid = &self.slabs.grid;
        let shape = self.raster.shape_at(grid.middle(slab));
        let faces = grid.faces(slab).map(|face| face as f32);
        let half_depth = self.raster.half_depth;
        let mut row = [[0.0; 4]; CubicSectionTable::ROW_LEN];
        for voxel in voxels.iter() {
            let depth = voxel.point[2];
            if depth + half_depth <= faces[0] || faces[1] <= depth - half_depth {
                continue;
            }
            let cut = faces.map(|face| (face - depth) * self.raster.index_per_depth);
            let section = self.section(&shape, voxel, cut, tile);
            if self.add(&shape, &section, cut, summed, sheet, &mut row) {
                tile.stats.n_splats += 1;
            } else {
                tile.stats.n_culled += 1;
            }
        }
    }

    #[inline]
    fn section(
        &self,
        shape: &PixelShape,
        voxel: &DensityVoxel,
        cut: [f32; 2],
        tile: &Tile,
    ) -> Section {
        let [x, y] = self.raster.pixel_of(shape, voxel.point);
        let radius = self.raster.radius;
        let rho_max = if self.raster.is_tilted { radius } else { disc_radius(radius, cut) };
        let center = [x - tile.origin[0] as f32 + 1.0, y - tile.origin[1] as f32 + 1.0];
        Section { center, radius, rho_max, value: voxel.value }
    }

    /// Adds the section of a voxel between two faces, in index units from its centre. Returns whether it fell
    /// on anything that is summed.
    #[inline]
    fn add(
        &self,
        shape: &PixelShape,
        section: &Section,
        cut: [f32; 2],
        summed: &Summed,
        sheet: &mut Sheet,
        row: &mut [[f32; 4]; CubicSectionTable::ROW_LEN],
    ) -> bool {
        let (gain, table) = (shape.gain, self.table);
        if self.raster.is_tilted {
            sheet.add(summed, shape, section, |Place { rho_squared, offset: [dx, dy] }| {
                let later = shape.tilt[0] * dx + shape.tilt[1] * dy;
                gain * table.weight(rho_squared, cut.map(|face| face + later))
            })
        } else {
            table.blend(cut, row);
            sheet.add(summed, shape, section, |at| gain * table.weight_in(row, at.rho_squared, cut))
        }
    }

    /// Classifies the open pixels of a slab's sheet, puts them behind what is there, and closes the blocks
    /// that are then saturated.
    fn classify(&self, slab: usize, sheets: &Sheets, tile: &mut Tile) {
        if sheets.here.is_empty() {
            return;
        }
        let spacing = self.spacing_at(slab);
        for block in tile.open.iter() {
            let mut has_changed = false;
            for pixel in tile.pixels_of(block) {
                if let Some(behind) = self.classified(sheets, tile.origin, pixel, spacing) {
                    tile.put_pixel_behind(pixel, behind);
                    has_changed = true;
                }
            }
            if has_changed {
                tile.close_if_saturated(block, self.plan.opacity_cutoff);
            }
        }
    }

    /// What a pixel of a sheet adds; `None` if nothing.
    #[inline]
    fn classified(
        &self,
        sheets: &Sheets,
        origin: [usize; 2],
        pixel: [usize; 2],
        spacing: Spacing,
    ) -> Option<[f32; 4]> {
        let at = pixel.map(|idx| idx + 1);
        let here = sheets.here.at(at);
        if here.length <= 0.0 {
            return None;
        }
        let density = f64::from(here.weighted) / f64::from(here.length);
        let opacity = self.classifier.opacity(density)?;
        let normal = if self.plan.light.is_some() {
            let lean = self.rays.lean([origin[0] + pixel[0], origin[1] + pixel[1]]);
            sheets.around(at).normal(density, &Spacing { lean, ..spacing })
        } else {
            DVec3::ZERO
        };
        Some(self.classifier.premultiplied(here.length.into(), opacity, normal))
    }

    /// How many sections voxels have in the slabs behind one.
    fn n_sections_behind(&self, slab: usize, voxels: Run<'_, DensityVoxel>) -> u64 {
        let n_behind = |voxel: &DensityVoxel| {
            let [first, last] = self.slabs_of(voxel);
            (last + 1).saturating_sub(first.max(slab + 1)) as u64
        };
        voxels.iter().map(n_behind).sum()
    }
}

impl Sheets {
    fn clear(&mut self) {
        self.before.clear();
        self.here.clear();
        self.behind.clear();
    }

    /// Advances by a slab: what was behind is here.
    fn advance(&mut self) {
        std::mem::swap(&mut self.before, &mut self.here);
        std::mem::swap(&mut self.here, &mut self.behind);
        self.behind.clear();
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

/// The radius of the disc in which a slab between two faces cuts a ball.
fn disc_radius(radius: f32, [front, back]: [f32; 2]) -> f32 {
    let nearest = front.max(-back).max(0.0);
    (radius * radius - nearest * nearest).max(0.0).sqrt()
}
