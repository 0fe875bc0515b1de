//! The paper's method (§3.2): kernel sections summed in slabs parallel to the image, slab by slab from
//! the eye, and composited.

use super::Stage;
use super::cells::Cells;
use super::lit_faces::LitFaces;
use super::slabs::{self, SectionsInSlabs, Sheets, SlabOnTile, SlabSums, Voxels};
use crate::footprints::raster::Raster;
use crate::pixels::blocks::Blocks;
use crate::pixels::ended_rays::SlabToEndIn;
use crate::pixels::tile::Tile;
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use fearless_simd::{Simd, dispatch};
use slabsplat_backend::{ColorSplats, FramePlan, LayerPlan, Splats};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Cancelled, Compositing, SlabGrid};
use slabsplat_traverse::{Brick, BrickBounds, BrickView, VoxelRecord};

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
    let drawn: Vec<Drawn<'_>> = stages.iter().map(Drawn::new).collect();
    let layers = stages.iter().zip(&drawn).filter_map(|(stage, drawn)| {
        let Stage { plan, frame, level, .. } = stage;
        let (layer, raster, bricks, voxels) = drawn.parts();
        let Splats::Colors(ColorSplats::Sections(splats)) = &layer.splats else { return None };
        let stage = slabs::Stage { plan, layer, frame, level: *level, raster, bricks, voxels };
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

/// What is drawn of a layer.
enum Drawn<'a> {
    Voxels(Shaded<'a>),
    Cells(Box<DrawnCells<'a>>),
}

struct DrawnCells<'a> {
    layer: &'a LayerPlan<'a>,
    raster: Raster,
    bricks: BrickView,
    cells: Cells<Shaded<'a>>,
}

impl<'a> Drawn<'a> {
    fn new(stage: &'a Stage<'a>) -> Self {
        let voxels = Shaded::new(stage);
        let Some(layer) = &stage.layer.coarser else { return Self::Voxels(voxels) };
        Self::Cells(Box::new(DrawnCells {
            layer,
            raster: Raster::new(layer, 0),
            bricks: BrickView::new(&layer.grid(), &layer.view),
            cells: Cells::new(voxels, layer),
        }))
    }

    fn parts(&self) -> (&LayerPlan<'a>, &Raster, &BrickView, &dyn Voxels) {
        match self {
            Self::Voxels(voxels) => {
                let Stage { layer, raster, bricks, .. } = voxels.stage;
                (layer, raster, bricks, voxels)
            }
            Self::Cells(drawn) => (drawn.layer, &drawn.raster, &drawn.bricks, &drawn.cells),
        }
    }
}

/// Relevant voxels, classified and shaded.
struct Shaded<'a> {
    stage: &'a Stage<'a>,
    faces: Option<LitFaces<'a>>,
}

impl<'a> Shaded<'a> {
    fn new(stage: &'a Stage<'a>) -> Self {
        Self { stage, faces: LitFaces::of(stage.layer) }
    }

    fn shade(&self, brick: &Brick, records: &[VoxelRecord], colors: &mut [[f32; 4]]) {
        let Stage { lighting, level, .. } = self.stage;
        lighting.classify_brick(brick, records, colors);
        dispatch!(*level, simd => simd.vectorize(
            #[inline(always)]
            || lighting.light_brick(records, colors),
        ));
    }

    /// Shades voxels of a brick near lit faces, with normals of those.
    fn color_by_faces(
        &self,
        faces: &LitFaces<'_>,
        brick: &Brick,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        let (mut points, mut own) = ([[0.0; 3]; AT_ONCE], [VoxelRecord::default(); AT_ONCE]);
        for (records, colors) in records.chunks(AT_ONCE).zip(colors.chunks_mut(AT_ONCE)) {
            let (points, own) = (&mut points[..records.len()], &mut own[..records.len()]);
            own.copy_from_slice(records);
            self.stage.bricks.project_brick(brick, records, points);
            for (record, point) in own.iter_mut().zip(points) {
                if let Some(face) = faces.at(DVec3::from_array(point.map(f64::from))) {
                    let normal = DVec3::from_array(record.normal.map(f64::from));
                    *record = record.with_normal(faces.instead_of(normal, face).to_array());
                }
            }
            self.shade(brick, own, colors);
        }
    }
}

/// Voxels that are shaded at once where normals are changed.
const AT_ONCE: usize = 64;

impl Voxels for Shaded<'_> {
    fn bricks(&self) -> &[Brick] {
        self.stage.list.bricks()
    }

    fn records_of<'a>(&'a self, brick: &Brick, _: &'a mut Vec<VoxelRecord>) -> &'a [VoxelRecord] {
        self.stage.list.voxels_of(brick)
    }

    fn color(&self, brick: &Brick, records: &[VoxelRecord], colors: &mut [[f32; 4]]) {
        let BrickBounds { center, half_extents } = self.stage.bricks.bounds(brick);
        let [center, half_extents] =
            [center, half_extents].map(|v| DVec3::from_array(v.map(f64::from)));
        match &self.faces {
            Some(faces) if faces.may_be_in(center, half_extents) => {
                self.color_by_faces(faces, brick, records, colors);
            }
            _ => self.shade(brick, records, colors),
        }
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
        regions.of(layer).map_or(Blocks::ALL, |region| region.showing(self.faces(slab)))
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
        let (compositing, cutoff) = (self.compositing, self.cutoff);
        tile.end_rays_in(SlabToEndIn { compositing, faces: self.faces(slab), cutoff }, sheet);
        tile.put_behind(simd, compositing, sheet, cutoff);
    }

    fn scratch_bytes((): &()) -> usize {
        0
    }
}
