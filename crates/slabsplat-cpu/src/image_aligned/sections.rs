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
use fearless_simd::{Simd, f32x4, prelude::*, u32x4};
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

/// What became of a section.
enum Prepared {
    Yes,
    /// All pixels that it could touch are full.
    Hidden,
    /// The slab does not cut the voxel's kernel, or not on this tile.
    NotCut,
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

impl<'a> SlabCut<'a> {
    pub(crate) fn new(slabs: &'a Slabs<'a>, slab: usize) -> Self {
        let faces = slabs.grid.faces(slab).map(|face| face as f32);
        Self { slabs, slab, shape: slabs.shape(slab), faces }
    }

    /// Adds the sections of voxels of one class to the sheet.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(
        &self,
        simd: S,
        class: usize,
        voxels: &[Voxel],
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) {
        match (class, self.slabs.fewer) {
            (0, Some(fewer)) => {
                let whole = fewer.polynomials.last_row();
                self.splat_in_turns(simd, voxels, tile, sheet, |voxel, tile, sheet, section| {
                    self.place(simd, voxel, self.slabs.raster.radius, tile, sheet, section)
                }, |sheet, section| {
                    self.splat_polynomial(simd, sheet, section, whole, 1.0);
                });
            }
            _ if self.slabs.raster.is_tilted => {
                self.splat_in_turns(simd, voxels, tile, sheet, |voxel, tile, sheet, section| {
                    self.prepare_tilted(simd, voxel, tile, sheet, section)
                }, |sheet, section| {
                    let tilted = Tilted {
                        table: self.slabs.tables(section.is_folded).0,
                        radius: self.slabs.raster.radius,
                        faces: section.faces,
                    };
                    splat(simd, sheet, &self.shape, &section.footprint, &tilted);
                });
            }
            _ => {
                self.splat_in_turns(simd, voxels, tile, sheet, |voxel, tile, sheet, section| {
                    self.prepare(simd, voxel, tile, sheet, section)
                }, |sheet, section| {
                    self.splat_polynomial(simd, sheet, section, &section.coefficients, section.edge);
                });
            }
        }
    }

    /// Prepares some sections, splats them, prepares more.
    #[inline(always)]
    fn splat_in_turns<S: Simd>(
        &self,
        _: S,
        voxels: &[Voxel],
        tile: &mut Tile,
        sheet: &mut Sheet,
        prepare: impl Fn(&Voxel, &Tile, &mut Sheet, &mut Section) -> Prepared,
        splat: impl Fn(&mut Sheet, &Section),
    ) {
        let mut sections = [Section::default(); N_PREPARED];
        for voxels in voxels.chunks(N_PREPARED) {
            let mut n_sections = 0;
            for voxel in voxels {
                match prepare(voxel, tile, sheet, &mut sections[n_sections]) {
                    Prepared::Yes => n_sections += 1,
                    Prepared::Hidden => tile.stats.n_culled += 1,
                    Prepared::NotCut => {}
                }
            }
            tile.stats.n_splats += n_sections as u64;
            sections[..n_sections].iter().for_each(|section| splat(sheet, section));
        }
    }

    /// Where a footprint that ends at `rho_max` lies.
    #[inline(always)]
    fn place<S: Simd>(
        &self,
        simd: S,
        voxel: &Voxel,
        rho_max: f32,
        tile: &Tile,
        sheet: &mut Sheet,
        section: &mut Section,
    ) -> Prepared {
        let [x, y] = self.slabs.raster.pixel_of(&self.shape, voxel.point);
        let center = [x - tile.origin[0] as f32, y - tile.origin[1] as f32];
        let half = self.shape.half_extent.map(|extent| extent * rho_max);
        let Some(pixels) = PixelBox::within_tile(simd, center, half) else {
            return Prepared::NotCut;
        };
        let blocks = Blocks::meeting(&pixels);
        if !tile.open.meets(blocks) {
            return Prepared::Hidden;
        }
        sheet.touched.add(blocks);
        let color = voxel.color.map(|channel| channel * self.shape.gain);
        section.footprint = Footprint { center, pixels, color };
        Prepared::Yes
    }

    #[inline(always)]
    fn prepare<S: Simd>(
        &self,
        simd: S,
        voxel: &Voxel,
        tile: &Tile,
        sheet: &mut Sheet,
        section: &mut Section,
    ) -> Prepared {
        let Some(([front, back], is_folded)) = self.faces_of(voxel) else {
            return Prepared::NotCut;
        };
        // The disc in which a slab between two faces cuts a ball.
        let nearest = max(max(front, -back), 0.0);
        let radius = self.slabs.raster.radius;
        let disc_squared = radius * radius - nearest * nearest;
        if disc_squared <= 0.0 {
            return Prepared::NotCut;
        }
        let (table, polynomials) = self.slabs.tables(is_folded);
        let (row, t) = table.row_at(front, back);
        polynomials.blend(row, t, &mut section.coefficients);
        section.edge = disc_squared * self.slabs.edge_per_disc - 1.0;
        self.place(simd, voxel, disc_squared.sqrt(), tile, sheet, section)
    }

    /// A tilted slab may cut a ball far from the ray through its centre.
    #[inline(always)]
    fn prepare_tilted<S: Simd>(
        &self,
        simd: S,
        voxel: &Voxel,
        tile: &Tile,
        sheet: &mut Sheet,
        section: &mut Section,
    ) -> Prepared {
        let Some((faces, is_folded)) = self.faces_of(voxel) else { return Prepared::NotCut };
        if self.slabs.reach_in_index <= max(faces[0], -faces[1]) {
            return Prepared::NotCut;
        }
        (section.faces, section.is_folded) = (faces, is_folded);
        self.place(simd, voxel, self.slabs.raster.radius, tile, sheet, section)
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
    fn splat_polynomial<S: Simd>(
        &self,
        simd: S,
        sheet: &mut Sheet,
        section: &Section,
        coefficients: &[f32; MAX_COEFFICIENTS],
        edge: f32,
    ) {
        let (shape, footprint) = (&self.shape, &section.footprint);
        let is_short = self.slabs.n_coefficients == 8;
        match (is_short, self.slabs.raster.leans) {
            (true, false) => {
                splat(simd, sheet, shape, footprint, &Polynomial::<8, false> { coefficients, edge });
            }
            (true, true) => {
                splat(simd, sheet, shape, footprint, &Polynomial::<8, true> { coefficients, edge });
            }
            (false, false) => {
                splat(simd, sheet, shape, footprint, &Polynomial::<12, false> { coefficients, edge });
            }
            (false, true) => {
                splat(simd, sheet, shape, footprint, &Polynomial::<12, true> { coefficients, edge });
            }
        }
    }
}

/// As `f32::max` where neither is NaN, and a single instruction.
#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

impl PixelBox {
    /// The pixels of a tile that have their centres within `half` of `center`; `None` if there are none.
    #[inline(always)]
    pub(crate) fn within_tile<S: Simd>(
        simd: S,
        [x, y]: [f32; 2],
        [half_width, half_height]: [f32; 2],
    ) -> Option<Self> {
        let splat = |value: f32| f32x4::splat(simd, value);
        let center: f32x4<S> = [x, y, x, y].simd_into(simd);
        let half: f32x4<S> = [-half_width, -half_height, half_width, half_height].simd_into(simd);
        // Adding 1½·2²³ rounds to whole numbers and leaves them in the low bits. Whether an edge goes up or down at a
        // tie does not matter: it has no weight. What is NaN becomes 0.
        let inside = (center + half).max(splat(0.0)).min(splat(TILE_SIDE as f32));
        let rounded: u32x4<S> = (inside + splat(12_582_912.0)).bitcast();
        let [x_min, y_min, x_end, y_end] = <[u32; 4]>::from(rounded).map(|bits| bits as u8);
        let pixels = Self { min: [x_min, y_min], end: [x_end, y_end] };
        (x_min < x_end && y_min < y_end).then_some(pixels)
    }
}
