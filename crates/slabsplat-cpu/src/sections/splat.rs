//! Sections, splatted: what was prepared of eight voxels goes to the inner loop one after the other.
//!
//! ```text
//! for every eight voxels of a class that the slab may cut:
//!     prepare them (batch.rs)
//!     for each that is drawn and meets an open block:
//!         blend the polynomials of two rows of its table, or take the whole footprint's, or the table itself
//!         splat it (footprints/splat.rs)
//! ```

use super::batch::SectionBatch;
use super::cut::{SlabCut, Voxels, bits};
use super::shared::{Kind, Sections};
use crate::footprints::splat::{AnyPolynomial, Footprint, splat_outlined};
use crate::footprints::tilted::Tilted;
use crate::footprints::weights::{ByCubicTable, ByTable, PixelByPixel};
use crate::pixels::rectangle::PixelBox;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::voxels::by_sheet::N_AT_ONCE;
use fearless_simd::{Simd, f32x4, prelude::*};
use slabsplat_kernel::{MAX_COEFFICIENTS, RadialPolynomials};

/// A section that is about to be splatted.
#[derive(Clone, Copy, Debug)]
struct Section {
    footprint: Footprint,
    /// Index units from the voxel to the slab's faces.
    faces: [f32; 2],
    /// Whether it holds what lies beyond one of the faces, too.
    is_merged: bool,
    /// Whether a polynomial of low degree is good enough.
    is_low_degree: bool,
    /// Where its disc ends, `2·(ρ/R)² − 1`.
    edge: f32,
    /// Where in its table it is, in rows.
    row: f32,
}

impl SlabCut<'_> {
    /// Adds the sections of voxels of one kind to the sheet.
    #[inline(always)]
    pub(crate) fn add_sections<S: Simd>(
        &self,
        simd: S,
        kind: Kind,
        voxels: Voxels<'_>,
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) {
        for first in (0..voxels.len).step_by(N_AT_ONCE) {
            let batch = self.prepare(simd, kind, voxels, first, tile);
            for idx in bits(batch.drawn) {
                let pixels = batch.pixels_of(idx);
                let Some(blocks) = tile.accept(&pixels) else { continue };
                sheet.touched.add(blocks);
                let color = voxels.voxel(first + idx).color;
                self.add(simd, kind, &self.section(simd, &batch, idx, pixels, color), sheet);
            }
        }
    }

    #[inline(always)]
    fn section<S: Simd>(
        &self,
        simd: S,
        batch: &SectionBatch,
        idx: usize,
        pixels: PixelBox,
        voxel_color: [f32; 4],
    ) -> Section {
        let mut color = [0.0; 4];
        let gains = f32x4::from_slice(simd, &self.channels) * self.shape.gain;
        (f32x4::from_slice(simd, &voxel_color) * gains).store_slice(&mut color);
        let center = [batch.centers[0][idx], batch.centers[1][idx]];
        Section {
            footprint: Footprint { center, pixels, color },
            faces: [batch.faces[0][idx], batch.faces[1][idx]],
            is_merged: batch.is_merged >> idx & 1 == 1,
            is_low_degree: voxel_color[3] <= self.sections.most_of_low_degree,
            edge: batch.edges[idx],
            row: batch.rows[idx],
        }
    }

    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, kind: Kind, section: &Section, sheet: &mut Sheet) {
        let Sections { raster, chord_units_per_index, .. } = *self.sections;
        let Section { footprint, faces, edge, .. } = section;
        let fitted = self.sections.fitted(section.is_merged || kind == Kind::Whole);
        let polynomials = fitted.polynomials.of(section.is_low_degree);
        let coefficients;
        let polynomial = match kind {
            Kind::ByTable => {
                let (table, radius) = (fitted.table, raster.radius);
                let weigh = PixelByPixel(ByTable { table, radius, faces: *faces, edge: *edge });
                return splat_outlined(simd, sheet, &self.shape, footprint, &weigh);
            }
            Kind::ByCubicTable => {
                let Some(table) = self.sections.cubic else { return };
                let radius = raster.radius;
                let weigh = PixelByPixel(ByCubicTable { table, radius, faces: *faces });
                return splat_outlined(simd, sheet, &self.shape, footprint, &weigh);
            }
            Kind::Tilted => {
                let Some(sections) = self.sections.tilted else { return };
                let tilted = Tilted { sections, radius: raster.radius, faces: *faces };
                return splat_outlined(simd, sheet, &self.shape, footprint, &tilted);
            }
            Kind::Whole => AnyPolynomial::whole(polynomials.last_row()),
            Kind::Upright => {
                coefficients = blended(simd, polynomials, section.row);
                let faces = faces.map(|face| face * chord_units_per_index);
                AnyPolynomial { coefficients: &coefficients, edge: *edge, faces }
            }
        };
        polynomial.splat(simd, sheet, &self.shape, footprint, raster.is_sheared);
    }
}

/// The coefficients at a position between two rows.
#[inline(always)]
fn blended<S: Simd>(
    simd: S,
    polynomials: &RadialPolynomials,
    position: f32,
) -> [f32; MAX_COEFFICIENTS] {
    let row = position as i32;
    let t = position - row as f32;
    let [near, far] = polynomials.around(row as usize);
    let mut coefficients = [0.0; MAX_COEFFICIENTS];
    for first in [0, 4, 8] {
        let near = f32x4::from_slice(simd, &near[first..first + 4]);
        let far = f32x4::from_slice(simd, &far[first..first + 4]);
        let blend = (far - near).mul_add(f32x4::splat(simd, t), near);
        blend.store_slice(&mut coefficients[first..first + 4]);
    }
    coefficients
}
