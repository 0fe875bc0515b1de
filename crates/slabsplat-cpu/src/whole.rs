//! What the two traditional methods share: whole footprints, and all relevant voxels at once.

use crate::raster::Raster;
use crate::sheet::Sheet;
use crate::splat::{AnyPolynomial, Footprint, PixelBox};
use crate::tile::Tile;
use crate::voxel::Voxel;
use fearless_simd::Simd;
use slabsplat_kernel::RadialPolynomials;
use slabsplat_traverse::{
    BRICK_SIDE, BrickView, DepthOrder, RelevantList, Shader, TileBuckets, TileGrid, TileRect,
};

/// What is kept from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    /// All relevant voxels.
    pub(crate) voxels: Vec<Voxel>,
    pub(crate) order: DepthOrder,
    pub(crate) splats: TileBuckets,
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.voxels.capacity() * size_of::<Voxel>()
            + self.order.resident_bytes()
            + self.splats.resident_bytes()
    }
}

const VOXELS_PER_BRICK: usize = BRICK_SIDE * BRICK_SIDE * BRICK_SIDE;

/// Shades and projects all relevant voxels; `sheet_of` tells the sheet of a voxel by its coordinates.
pub(crate) fn voxels(
    list: &RelevantList,
    bricks: &BrickView,
    shader: &Shader<'_>,
    sheet_of: impl Fn([usize; 3]) -> usize + Sync,
    voxels: &mut Vec<Voxel>,
) {
    voxels.resize(list.len(), Voxel::default());
    list.fill_by_brick(voxels, |brick, records, voxels| {
        let mut points = [[0.0; 3]; VOXELS_PER_BRICK];
        bricks.project_brick(brick, records, &mut points[..records.len()]);
        let mut colors = [[0.0; 4]; VOXELS_PER_BRICK];
        shader.shade_brick(brick, records, &mut colors[..records.len()]);
        let shaded = points.into_iter().zip(colors);
        for ((voxel, &record), (point, color)) in voxels.iter_mut().zip(records).zip(shaded) {
            let sheets = sheet_of(list.voxel_coords(brick, record)) as u32;
            *voxel = Voxel { point, sheets, color };
        }
    });
}

/// Tosses `n_splats` voxels onto the tiles that their footprints touch, in the order in which `voxel` gives them.
pub(crate) fn toss<'a>(
    raster: &Raster,
    tiles: &TileGrid,
    n_splats: usize,
    voxel: impl Fn(usize) -> &'a Voxel + Sync,
    splats: &mut TileBuckets,
) {
    splats.toss(tiles, n_splats, |splat| {
        let point = voxel(splat).point;
        if point[2] < raster.near {
            return TileRect::EMPTY;
        }
        let [min, max] = raster.bounds(&raster.shape_at(point[2].into()), point);
        tiles.pixels_within(min, max).map_or(TileRect::EMPTY, |pixels| tiles.tiles_of(&pixels))
    });
}

/// Splats whole footprints.
pub(crate) struct Whole<'a> {
    pub(crate) raster: &'a Raster,
    pub(crate) polynomials: &'a RadialPolynomials,
}

impl Whole<'_> {
    /// Adds a voxel's footprint to the sheet; returns the pixels that it may touch, if any of them is open.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(
        &self,
        simd: S,
        voxel: &Voxel,
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
        polynomial.splat_apart(simd, sheet, &shape, &footprint, raster.leans);
        Some(pixels)
    }
}
