//! The paper's method (§3.2): kernel sections summed in slabs parallel to the image, slab by slab from
//! the eye, and composited.

use super::Stage;
use super::slabs::{self, SectionsInSlabs, Sheets, Voxels};
use crate::pixels::sheet::Sheet;
use crate::pixels::tile::Tile;
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use fearless_simd::Simd;
use slabsplat_backend::SectionSplats;
use slabsplat_core::Compositing;
use slabsplat_traverse::{Brick, RelevantList, VoxelLighting, VoxelRecord};

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers(slabs::Buffers<(), ()>);

/// Renders into empty tiles; returns how many voxels were never tossed, being occluded.
pub(crate) fn render(
    stage: &Stage<'_>,
    splats: &SectionSplats,
    tiles: &mut Tiles,
    buffers: &mut Buffers,
    watch: &mut Stopwatch,
) -> u64 {
    let Stage { plan, level, raster, list, bricks, lighting } = stage;
    let voxels = &Shaded { list, lighting };
    let stage = slabs::Stage { plan, level: *level, raster, bricks, voxels };
    let sheets = Composited { compositing: plan.compositing, cutoff: plan.opacity_cutoff };
    let sections = SectionsInSlabs::of_colors(splats);
    slabs::render(&stage, &sections, &sheets, tiles, &mut buffers.0, watch)
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.0.resident_bytes::<Composited>()
    }
}

/// Relevant voxels, classified and shaded.
struct Shaded<'a> {
    list: &'a RelevantList,
    lighting: &'a VoxelLighting<'a>,
}

impl Voxels for Shaded<'_> {
    fn bricks(&self) -> &[Brick] {
        self.list.bricks()
    }

    fn records_of<'a>(&'a self, brick: &Brick, _: &'a mut Vec<VoxelRecord>) -> &'a [VoxelRecord] {
        self.list.voxels_of(brick)
    }

    fn color(&self, brick: &Brick, records: &[VoxelRecord], colors: &mut [[f32; 4]]) {
        self.lighting.shade_brick(brick, records, colors);
    }
}

/// A sheet goes behind what there is of the picture.
struct Composited {
    compositing: Compositing,
    cutoff: f32,
}

impl Sheets for Composited {
    type Retained = ();
    type Scratch = ();

    const AT_ONCE: usize = 1;
    const N_BEHIND: usize = 0;

    #[inline(always)]
    fn take<S: Simd>(
        &self,
        simd: S,
        _: usize,
        sheet: &mut Sheet,
        tile: &mut Tile,
        (): &mut (),
        (): &mut (),
    ) {
        tile.put_behind(simd, self.compositing, sheet, self.cutoff);
    }

    fn release(&self, (): &mut (), (): &mut ()) {}

    fn scratch_bytes((): &()) -> usize {
        0
    }
}
