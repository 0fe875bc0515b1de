//! The paper's method (§3.2): kernel sections summed in slabs parallel to the image, slab by slab from
//! the eye, and composited.

use super::Stage;
use super::lit_faces::LitFaces;
use super::on_demand::{LevelVoxels, SeenLevel};
use super::slabs::{
    self, BrickVoxels, ReadRoom, SectionsInSlabs, Sheets, SlabOnTile, SlabSums, Voxels,
};
use crate::footprints::raster::Raster;
use crate::pixels::blocks::Blocks;
use crate::pixels::ended_rays::SlabToEndIn;
use crate::pixels::tile::Tile;
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use crate::voxels::relevant::RelevantVoxels;
use fearless_simd::Simd;
use slabsplat_backend::{ColorSplats, FramePlan, LayerPlan, Splats};
use slabsplat_core::{Cancelled, Compositing, SlabGrid};
use slabsplat_traverse::{Brick, BrickView, RelevantList, VoxelRecord};

/// What is cached from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Buffers(slabs::Buffers<(), ()>);

/// Renders into empty tiles; returns how many voxels were never tossed, being occluded.
pub(crate) fn render(
    stages: &[Stage<'_>],
    plan: &FramePlan<'_>,
    tiles: &mut Tiles,
    buffers: &mut Buffers,
    watch: &mut Stopwatch<'_>,
) -> Result<u64, Cancelled> {
    let levels: Vec<Vec<SeenLevel<'_>>> = stages
        .iter()
        .map(|stage| match stage.relevant {
            RelevantVoxels::Listed(_) => Vec::new(),
            RelevantVoxels::OnDemand(_) => SeenLevel::all(stage.layer),
        })
        .collect();
    let mut drawn = Vec::with_capacity(stages.len());
    for (stage, levels) in stages.iter().zip(&levels) {
        Drawn::add_layer(stage, levels, &mut drawn);
    }
    let layers = drawn.iter().filter_map(|drawn| {
        let Stage { plan, frame, level, .. } = drawn.stage;
        let (layer, raster, bricks, voxels) = drawn.parts();
        let finest = (drawn.stage.layer, &drawn.stage.raster);
        let Splats::Colors(ColorSplats::Sections(splats)) = &layer.splats else { return None };
        let stage =
            slabs::Stage { plan, layer, frame, level: *level, raster, finest, bricks, voxels };
        Some((stage, SectionsInSlabs::of_colors(splats)))
    });
    let Some((_, first)) = layers.clone().next() else { return Ok(0) };
    let sheets = Composited {
        compositing: plan.compositing,
        cutoff: plan.opacity_cutoff,
        slabs: first.slabs(),
    };
    slabs::render(layers, &sheets, tiles, &mut buffers.0, watch)
}

impl Buffers {
    pub(crate) fn resident_bytes(&self) -> usize {
        self.0.resident_bytes::<Composited<'_>>()
    }
}

/// A layer, or one level of it.
struct Drawn<'a> {
    stage: &'a Stage<'a>,
    voxels: DrawnVoxels<'a>,
}

enum DrawnVoxels<'a> {
    Listed(Listed<'a>),
    OnDemand(&'a SeenLevel<'a>, LevelVoxels<'a>),
}

impl<'a> Drawn<'a> {
    /// Appends what is drawn of a layer, the coarsest first, which leaves to others what it does not draw.
    fn add_layer(stage: &'a Stage<'a>, levels: &'a [SeenLevel<'a>], drawn: &mut Vec<Self>) {
        match &stage.relevant {
            RelevantVoxels::Listed(list) => {
                let listed = Listed { stage, list, faces: LitFaces::of(stage.layer) };
                drawn.push(Self { stage, voxels: DrawnVoxels::Listed(listed) });
            }
            RelevantVoxels::OnDemand(on_demand) => {
                let of_level = |level: usize| {
                    let voxels = LevelVoxels::new(stage, on_demand, levels, level);
                    Self { stage, voxels: DrawnVoxels::OnDemand(&levels[level], voxels) }
                };
                drawn.extend((0..levels.len()).rev().map(of_level));
            }
        }
    }

    fn parts(&self) -> (&LayerPlan<'a>, &Raster, &BrickView, &dyn Voxels) {
        match &self.voxels {
            DrawnVoxels::Listed(voxels) => {
                let Stage { layer, raster, bricks, .. } = self.stage;
                (layer, raster, bricks, voxels)
            }
            DrawnVoxels::OnDemand(seen, voxels) => (seen.plan, &seen.raster, &seen.bricks, voxels),
        }
    }
}

/// Relevant voxels of a list, classified and shaded.
struct Listed<'a> {
    stage: &'a Stage<'a>,
    list: &'a RelevantList,
    faces: Option<LitFaces<'a>>,
}

impl Voxels for Listed<'_> {
    fn n_voxels(&self) -> u64 {
        self.list.len() as u64
    }

    fn listed(&self) -> &[Brick] {
        self.list.bricks()
    }

    fn read<'a>(&'a self, brick: &Brick, _: &'a mut ReadRoom) -> Option<BrickVoxels<'a>> {
        Some(BrickVoxels::new(self.list.voxels_of(brick)))
    }

    fn color(
        &self,
        brick: &Brick,
        _: &BrickVoxels<'_>,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        self.stage.color(self.faces.as_ref(), brick, records, colors);
    }
}

/// Layers are joined, and their sheet goes behind what there is of the picture.
struct Composited<'a> {
    compositing: Compositing,
    cutoff: f32,
    slabs: &'a SlabGrid,
}

impl Composited<'_> {
    fn faces(&self, slab: usize) -> [f32; 2] {
        self.slabs.faces(slab).map(|face| face as f32)
    }
}

impl Sheets for Composited<'_> {
    type Retained = ();
    type Scratch = ();

    const AT_ONCE: usize = 1;
    const N_BEHIND: usize = 0;

    fn front(&self, slab: usize) -> f32 {
        self.slabs.front(slab) as f32
    }

    fn splits_slabs(&self) -> bool {
        self.compositing.sums_extinction()
    }

    #[inline(always)]
    fn needed(&self, SlabOnTile { slab, regions }: SlabOnTile<'_>, layer: usize) -> Blocks {
        let faces = self.faces(slab);
        if !regions.part_shows(faces) {
            return Blocks::NONE;
        }
        regions.of(layer).map_or(Blocks::ALL, |region| region.showing(faces))
    }

    /// Those of one region are cut together.
    #[inline(always)]
    fn take<S: Simd>(
        &self,
        _: S,
        SlabOnTile { slab, regions }: SlabOnTile<'_>,
        layer: usize,
        SlabSums { of_layer, joined }: SlabSums<'_>,
        (): &mut (),
        (): &mut (),
    ) {
        if regions.is_that_of_next(layer) {
            return;
        }
        if let Some(region) = regions.of(layer) {
            region.cut(of_layer, self.faces(slab));
        }
        if !regions.is_only() {
            joined.take_from(of_layer);
        }
    }

    #[inline(always)]
    fn show<S: Simd>(
        &self,
        simd: S,
        SlabOnTile { slab, regions }: SlabOnTile<'_>,
        SlabSums { of_layer, joined }: SlabSums<'_>,
        tile: &mut Tile,
        (): &mut (),
        (): &mut (),
    ) {
        let sheet = if regions.is_only() { of_layer } else { joined };
        if let Some(part) = regions.part() {
            part.cut(sheet, self.faces(slab));
        }
        let (compositing, cutoff) = (self.compositing, self.cutoff);
        tile.end_rays_in(SlabToEndIn { compositing, faces: self.faces(slab), cutoff }, sheet);
        tile.put_behind(simd, compositing, sheet, cutoff);
    }

    fn scratch_bytes((): &()) -> usize {
        0
    }
}
