//! One frame from plan to picture: dispatch to the method, and what all of them share.

use crate::footprints::raster::Raster;
use crate::methods::{Stage, axis_aligned, densities, every_sample, image_aligned};
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use crate::voxels::relevant::Relevant;
use fearless_simd::Level;
use slabsplat_backend::{
    ByIdentity, Cached, ColorSplats, Frame, FrameCost, FramePlan, FrameStats, Splats,
};
use slabsplat_core::{Compositing, TransferFunction, Volume};
use slabsplat_traverse::{BrickView, Classification, VoxelLighting};

/// What is cached from frame to frame: what need not be made anew, and memory.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    /// Of an image of that size, with that border.
    tiles: Cached<([u32; 2], usize), Tiles>,
    of_methods: OfMethods,
}

#[derive(Debug, Default)]
struct OfMethods {
    relevant: Relevant,
    classification: Cached<(TransferFunction, Compositing, ByIdentity<Volume>), Classification>,
    image_aligned: image_aligned::Buffers,
    axis_aligned: axis_aligned::Buffers,
    every_sample: every_sample::Buffers,
    densities: densities::Buffers,
}

/// What a frame drew, but for what tiles tell.
struct Drawn {
    n_voxels: u64,
    n_occluded: u64,
}

/// Renders with the instructions of `level`.
pub(crate) fn render(plan: &FramePlan<'_>, level: Level, buffers: &mut Buffers) -> Frame {
    let mut watch = Stopwatch::start();
    let image_size = plan.view.image_size();
    let Buffers { tiles, of_methods } = buffers;
    let border = match &plan.splats {
        Splats::Colors(_) => 0,
        Splats::Densities(_) => densities::BORDER,
    };
    let tiles = tiles.made_of((image_size, border), |_| Tiles::new(image_size, border));
    tiles.clear();
    of_methods.forget_others(&plan.splats);
    let Drawn { n_voxels, n_occluded } = match &plan.splats {
        Splats::Colors(splats) => of_methods.colors(plan, splats, level, tiles, &mut watch),
        Splats::Densities(splats) => {
            let buffers = &mut of_methods.densities;
            let [n_voxels, n_occluded] =
                densities::render(plan, level, splats, tiles, buffers, &mut watch);
            Drawn { n_voxels, n_occluded }
        }
    };
    let stats = FrameStats { n_voxels, n_occluded, ..tiles.stats() };
    let image = tiles.image(plan.image.premultiplied_background());
    watch.done("image");
    let cost = FrameCost { stages: watch.stages(), resident_bytes: buffers.resident_bytes() };
    Frame { image, stats, cost }
}

impl OfMethods {
    /// Frees what only methods need that these splats are not of: each may hold all voxels.
    fn forget_others(&mut self, splats: &Splats) {
        let Self { image_aligned, axis_aligned, every_sample, densities, .. } = self;
        if !matches!(splats, Splats::Colors(ColorSplats::Sections(_))) {
            *image_aligned = image_aligned::Buffers::default();
        }
        if !matches!(splats, Splats::Colors(ColorSplats::Slices { .. })) {
            *axis_aligned = axis_aligned::Buffers::default();
        }
        if !matches!(splats, Splats::Colors(ColorSplats::Voxels { .. })) {
            *every_sample = every_sample::Buffers::default();
        }
        if !matches!(splats, Splats::Densities(_)) {
            *densities = densities::Buffers::default();
        }
    }

    /// Splats colours by one of the methods that do.
    fn colors(
        &mut self,
        plan: &FramePlan<'_>,
        splats: &ColorSplats,
        level: Level,
        tiles: &mut Tiles,
        watch: &mut Stopwatch,
    ) -> Drawn {
        let Self { relevant, classification, .. } = self;
        let FramePlan { volume, transfer, compositing, .. } = *plan;
        let classified_by = (transfer.clone(), compositing, ByIdentity::of(volume));
        let classification = classification
            .made_of(classified_by, |_| Classification::new(transfer, compositing, volume));
        let stage = Stage {
            plan,
            level,
            raster: Raster::new(plan, 0),
            list: relevant.voxels(volume, &plan.relevant),
            bricks: BrickView::new(volume.grid(), &plan.view),
            lighting: VoxelLighting::new(classification, volume, plan.light.as_ref()),
        };
        watch.done("list");
        let mut n_occluded = 0;
        match splats {
            ColorSplats::Sections(sections) => {
                let buffers = &mut self.image_aligned;
                n_occluded = image_aligned::render(&stage, sections, tiles, buffers, watch);
            }
            ColorSplats::Slices { order, table } => {
                axis_aligned::render(&stage, order, table, tiles, &mut self.axis_aligned, watch);
            }
            ColorSplats::Voxels { table } => {
                every_sample::render(&stage, table, tiles, &mut self.every_sample, watch);
            }
        }
        Drawn { n_voxels: stage.list.len() as u64, n_occluded }
    }

    fn resident_bytes(&self) -> usize {
        self.relevant.resident_bytes()
            + self.classification.value().map_or(0, Classification::resident_bytes)
            + self.image_aligned.resident_bytes()
            + self.axis_aligned.resident_bytes()
            + self.every_sample.resident_bytes()
            + self.densities.resident_bytes()
    }
}

impl Buffers {
    fn resident_bytes(&self) -> u64 {
        let of_tiles = self.tiles.value().map_or(0, Tiles::resident_bytes);
        (of_tiles + self.of_methods.resident_bytes()) as u64
    }
}
