//! The sections that a slab cuts out of kernels (paper §3.2), prepared and splatted.
//!
//! What a section needs before its pixels can be visited (where it lies, how far its disc reaches, which rows of the
//! table it blends) takes a square root and a chain of other steps. They are taken for some dozens of voxels at a time,
//! so that they run side by side, and the inner loop finds everything ready.

use crate::blocks::Blocks;
use crate::image_aligned::{Slabs, Span};
use crate::raster::PixelShape;
use crate::sheet::Sheet;
use crate::splat::{Footprint, PixelBox, splat};
use crate::tile::{TILE_SIDE, Tile};
use crate::voxel::Voxel;
use crate::weights::{Polynomial, Tilted};
use fearless_simd::Simd;
use slabsplat_kernel::MAX_COEFFICIENTS;

/// Voxels whose sections are prepared at a time.
const N_PREPARED: usize = 32;

/// A slab, about to be splatted.
pub(crate) struct SlabCut<'a> {
    slabs: &'a Slabs<'a>,
    slab: usize,
    /// The footprint of its sections.
    shape: PixelShape,
    /// Depths of its faces.
    faces: [f32; 2],
}

/// A section that is about to be splatted.
#[derive(Clone, Copy, Debug, Default)]
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

/// What became of a section.
enum Prepared {
    Yes,
    /// All pixels that it could touch are full.
    Hidden,
    /// The slab does not cut the voxel's kernel, or not on this tile.
    NotCut,
}

impl<'a> SlabCut<'a> {
    pub(crate) fn new(slabs: &'a Slabs<'a>, slab: usize) -> Self {
        let faces = slabs.grid.faces(slab).map(|face| face as f32);
        Self { slabs, slab, shape: slabs.shape(slab), faces }
    }

    /// Adds the voxels' sections to the sheet.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(
        &self,
        simd: S,
        voxels: &[Voxel],
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) {
        let mut sections = [Section::default(); N_PREPARED];
        for voxels in voxels.chunks(N_PREPARED) {
            let mut n_sections = 0;
            for voxel in voxels {
                match self.prepare(voxel, tile, sheet, &mut sections[n_sections]) {
                    Prepared::Yes => n_sections += 1,
                    Prepared::Hidden => tile.stats.n_culled += 1,
                    Prepared::NotCut => {}
                }
            }
            tile.stats.n_splats += n_sections as u64;
            self.splat_prepared(simd, &sections[..n_sections], sheet);
        }
    }

    #[inline(always)]
    fn prepare(
        &self,
        voxel: &Voxel,
        tile: &Tile,
        sheet: &mut Sheet,
        section: &mut Section,
    ) -> Prepared {
        let raster = self.slabs.raster;
        let Some(([front, back], is_folded)) = self.faces_of(voxel) else {
            return Prepared::NotCut;
        };
        // The disc in which a slab between two faces cuts a ball; a tilted slab may cut it elsewhere.
        let nearest = front.max(-back).max(0.0);
        if self.slabs.reach_in_index <= nearest {
            return Prepared::NotCut;
        }
        let radius = raster.radius;
        let disc_squared = radius * radius - nearest * nearest;
        let rho_max = if raster.is_tilted { radius } else { disc_squared.sqrt() };
        let [x, y] = raster.pixel_of(&self.shape, voxel.point);
        let center = [x - tile.origin[0] as f32, y - tile.origin[1] as f32];
        let half = self.shape.half_extent.map(|extent| extent * rho_max);
        let Some(pixels) = PixelBox::within_tile(center, half) else { return Prepared::NotCut };
        let blocks = Blocks::meeting(&pixels);
        if !tile.open.meets(blocks) {
            return Prepared::Hidden;
        }
        sheet.touched.add(blocks);
        let color = voxel.color.map(|channel| channel * self.shape.gain);
        let (table, polynomials) = self.slabs.tables(is_folded);
        let (row, t) = table.row_at(front, back);
        section.footprint = Footprint { center, pixels, color };
        section.faces = [front, back];
        section.is_folded = is_folded;
        section.edge = 2.0 * disc_squared / (radius * radius) - 1.0;
        polynomials.blend(row, t, &mut section.coefficients);
        Prepared::Yes
    }

    /// Index units from the voxel to the faces that cut it, and whether others were spared; `None` if it is not drawn
    /// in this slab.
    #[inline(always)]
    fn faces_of(&self, voxel: &Voxel) -> Option<([f32; 2], bool)> {
        let raster = self.slabs.raster;
        let [front, back] =
            self.faces.map(|face| (face - voxel.point[2]) * raster.index_per_depth);
        let span = Span::from_bits(voxel.sheets);
        let Some(n_more) = span.folded() else { return Some(([front, back], false)) };
        let place = self.slab.wrapping_sub(span.first());
        if n_more < place {
            return None;
        }
        let far = 2.0 * self.slabs.reach_in_index;
        let (is_first, is_last) = (place == 0, place == n_more);
        let front = if is_first { -far } else { front };
        let back = if is_last { far } else { back };
        Some(([front, back], is_first || is_last))
    }

    #[inline(always)]
    fn splat_prepared<S: Simd>(&self, simd: S, sections: &[Section], sheet: &mut Sheet) {
        let raster = self.slabs.raster;
        match (raster.is_tilted, self.slabs.n_coefficients(), raster.leans) {
            (true, ..) => {
                for section in sections {
                    let tilted = Tilted {
                        table: self.slabs.tables(section.is_folded).0,
                        radius: raster.radius,
                        faces: section.faces,
                    };
                    splat(simd, sheet, &self.shape, &section.footprint, &tilted);
                }
            }
            (false, 8, false) => self.splat_polynomials::<S, 8, false>(simd, sections, sheet),
            (false, 8, true) => self.splat_polynomials::<S, 8, true>(simd, sections, sheet),
            (false, _, false) => self.splat_polynomials::<S, 12, false>(simd, sections, sheet),
            (false, _, true) => self.splat_polynomials::<S, 12, true>(simd, sections, sheet),
        }
    }

    #[inline(always)]
    fn splat_polynomials<S: Simd, const N: usize, const LEANS: bool>(
        &self,
        simd: S,
        sections: &[Section],
        sheet: &mut Sheet,
    ) {
        for section in sections {
            let polynomial = Polynomial::<N, LEANS> {
                coefficients: &section.coefficients,
                edge: section.edge,
            };
            splat(simd, sheet, &self.shape, &section.footprint, &polynomial);
        }
    }
}

impl PixelBox {
    /// The pixels of a tile that have their centres within `half` of `center`; `None` if there are none.
    #[inline(always)]
    pub(crate) fn within_tile(center: [f32; 2], half: [f32; 2]) -> Option<Self> {
        // Adding 1½·2²³ rounds to whole numbers and leaves them in the low bits, without the checks of a cast, which
        // cost as much as all the rest. Whether an edge goes up or down at a tie does not matter: it has no weight.
        const MAGIC: f32 = 12_582_912.0;
        let pixel = |at: f32| (at.max(0.0).min(TILE_SIDE as f32) + MAGIC).to_bits() as u8;
        let min = [0, 1].map(|axis| pixel(center[axis] - half[axis]));
        let end = [0, 1].map(|axis| pixel(center[axis] + half[axis]));
        (min[0] < end[0] && min[1] < end[1]).then_some(Self { min, end })
    }
}
