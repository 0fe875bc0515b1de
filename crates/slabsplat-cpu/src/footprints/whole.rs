//! Whole footprints, as the two traditional methods splat them.

use super::raster::Raster;
use super::splat::{AnyPolynomial, Footprint};
use crate::pixels::rectangle::PixelBox;
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::voxels::voxel::Voxel;
use fearless_simd::Simd;
use slabsplat_kernel::RadialPolynomials;

/// What all whole footprints of a frame share.
pub(crate) struct WholeFootprints<'a> {
    pub(crate) raster: &'a Raster,
    pub(crate) polynomials: &'a RadialPolynomials,
}

impl WholeFootprints<'_> {
    /// Adds a voxel's footprint to the sheet; returns the pixels that it may touch, if any of them is open.
    #[inline(always)]
    pub(crate) fn add<S: Simd, T>(
        &self,
        simd: S,
        voxel: &Voxel<T>,
        tile: &mut Tile,
        sheet: &mut Sheet,
    ) -> Option<PixelBox> {
        let Self { raster, .. } = *self;
        let shape = raster.shape_at(voxel.point[2].into());
        let [x, y] = raster.pixel_of(&shape, voxel.point);
        let center = [x - tile.origin[0] as f32, y - tile.origin[1] as f32];
        let half = shape.half_extent.map(|extent| extent * raster.radius);
        let pixels = PixelBox::within_tile(simd, center, half)?;
        let blocks = tile.accept(&pixels)?;
        sheet.touched.add(blocks);
        let color = voxel.color.map(|channel| channel * shape.gain);
        let footprint = Footprint { center, pixels, color };
        let polynomial = AnyPolynomial::whole(self.polynomials.row(0));
        polynomial.splat_outlined(simd, sheet, &shape, &footprint, raster.is_sheared);
        Some(pixels)
    }
}
