//! The sections that a slab cuts out of kernels (paper §3.2), splatted.

use crate::by_sheet::{N_AT_ONCE, Run};
use crate::image_aligned::Slabs;
use crate::image_aligned::prepare::Kind;
use crate::image_aligned::products::AsProducts;
use crate::raster::PixelShape;
use crate::sheet::Sheet;
use crate::splat::{AnyPolynomial, Footprint, splat};
use crate::tile::Tile;
use crate::weights::ByTable;
use fearless_simd::{Simd, f32x4, prelude::*};
use slabsplat_kernel::{MAX_COEFFICIENTS, RadialPolynomials};

/// A slab, about to be splatted.
pub(crate) struct SlabCut<'a> {
    pub(crate) slabs: &'a Slabs<'a>,
    pub(crate) slab: usize,
    /// The footprint of its sections.
    pub(crate) shape: PixelShape,
    /// How sections are drawn as products, if they are.
    as_products: Option<AsProducts<'a>>,
    /// Depths of its faces.
    pub(crate) faces: [f32; 2],
}

/// A section that is about to be splatted.
#[derive(Clone, Copy, Debug)]
struct Section {
    footprint: Footprint,
    /// Index units from the voxel to the slab's faces.
    faces: [f32; 2],
    /// Whether it holds what lies beyond one of the faces, too.
    is_folded: bool,
    /// Where its disc ends, `2·(ρ/R)² − 1`.
    edge: f32,
    coefficients: [f32; MAX_COEFFICIENTS],
}

impl<'a> SlabCut<'a> {
    pub(crate) fn new(slabs: &'a Slabs<'a>, slab: usize) -> Self {
        let faces = slabs.grid.faces(slab).map(|face| face as f32);
        let as_products = slabs.as_products(slab);
        Self { slabs, slab, shape: slabs.shape(slab), as_products, faces }
    }

    /// Adds the sections of voxels of one class to the sheet.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(
        &self,
        simd: S,
        class: usize,
        voxels: Run<'_>,
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) {
        let kind = self.slabs.kind_of(class);
        match self.as_products {
            Some(how) if Slabs::may_be_products(class) => {
                self.splat_products(simd, kind, how, voxels, tile, sheet);
            }
            _ => self.splat_each(simd, kind, voxels, tile, sheet),
        }
    }

    /// Adds what products left in the knots to the sheet's pixels.
    #[inline(always)]
    pub(crate) fn gather<S: Simd>(&self, simd: S, sheet: &mut Sheet) {
        if let Some(how) = self.as_products {
            how.spline.gather(simd, sheet);
        }
    }

    #[inline(always)]
    fn splat_each<S: Simd>(
        &self,
        simd: S,
        kind: Kind,
        voxels: Run<'_>,
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) {
        for first in (0..voxels.len).step_by(N_AT_ONCE) {
            let eight = self.prepare(simd, kind, voxels, first, tile);
            for idx in bits(eight.drawn) {
                let pixels = eight.pixels_of(idx);
                let Some(blocks) = tile.accept(&pixels) else { continue };
                sheet.touched.add(blocks);
                let voxel_color = voxels.color(first + idx);
                let by_few = voxel_color[3] <= self.slabs.most_of_few;
                let mut color = [0.0; 4];
                let summed = f32x4::from_slice(simd, &voxel_color);
                (summed * self.shape.gain).store_slice(&mut color);
                let center = [eight.centers[0][idx], eight.centers[1][idx]];
                let mut section = Section {
                    footprint: Footprint { center, pixels, color },
                    edge: eight.edges[idx],
                    is_folded: eight.is_folded >> idx & 1 == 1,
                    faces: [eight.faces[0][idx], eight.faces[1][idx]],
                    coefficients: [0.0; MAX_COEFFICIENTS],
                };
                if kind == Kind::Upright {
                    let (_, polynomials) = self.slabs.tables(section.is_folded);
                    let polynomials = polynomials.of(by_few);
                    section.coefficients = blended(simd, polynomials, eight.rows[idx]);
                }
                self.splat_section(simd, kind, by_few, &section, sheet);
            }
        }
    }

    #[inline(always)]
    fn splat_section<S: Simd>(
        &self,
        simd: S,
        kind: Kind,
        by_few: bool,
        section: &Section,
        sheet: &mut Sheet,
    ) {
        match (kind, self.slabs.fewer) {
            (Kind::ByTable, _) => {
                let by_table = ByTable {
                    table: self.slabs.tables(section.is_folded).0,
                    radius: self.slabs.raster.radius,
                    faces: section.faces,
                    edge: section.edge,
                };
                splat(simd, sheet, &self.shape, &section.footprint, &by_table);
            }
            (Kind::Whole, Some(fewer)) => {
                let whole = fewer.polynomials.of(by_few).last_row();
                self.splat_polynomial(simd, sheet, section, AnyPolynomial::whole(whole));
            }
            _ => {
                let units = self.slabs.chord_units_per_index;
                let polynomial = AnyPolynomial {
                    coefficients: &section.coefficients,
                    edge: section.edge,
                    faces: section.faces.map(|face| face * units),
                };
                self.splat_polynomial(simd, sheet, section, polynomial);
            }
        }
    }

    #[inline(always)]
    fn splat_polynomial<S: Simd>(
        &self,
        simd: S,
        sheet: &mut Sheet,
        section: &Section,
        polynomial: AnyPolynomial<'_>,
    ) {
        let leans = self.slabs.raster.leans;
        polynomial.splat(simd, sheet, &self.shape, &section.footprint, leans);
    }
}

/// The coefficients at a place between two rows.
#[inline(always)]
fn blended<S: Simd>(
    simd: S,
    polynomials: &RadialPolynomials,
    place: f32,
) -> [f32; MAX_COEFFICIENTS] {
    let row = place as i32;
    let t = place - row as f32;
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

/// The places of the bits that are set.
#[inline(always)]
pub(super) fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = mask.trailing_zeros() as usize;
        mask &= mask.checked_sub(1)?;
        Some(place)
    })
}
