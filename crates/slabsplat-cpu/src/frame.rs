//! One frame from plan to picture: dispatch to the method, and what all of them share.

use crate::footprints::raster::Raster;
use crate::meshes;
use crate::methods::{Stage, axis_aligned, densities, every_sample, image_aligned};
use crate::pixels::tiles::Tiles;
use crate::stopwatch::Stopwatch;
use crate::voxels::relevant::{Budget, Relevant};
use fearless_simd::Level;
use slabsplat_backend::{
    ByIdentity, Cached, ColorSplats, Frame, FrameCost, FramePlan, LayerPlan, Splats,
};
use slabsplat_core::{Compositing, FrameHandle, StageError, Volume};
use slabsplat_mesh::Rasterizer;
use slabsplat_traverse::{
    BlinnPhong8, BrickView, Classification, OwnVoxelRules, VoxelLighting, VoxelRules,
};

/// What is cached from frame to frame: what need not be made anew, and memory.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    /// Of an image of that size, with that border.
    tiles: Cached<([u32; 2], usize), Tiles>,
    meshes: Rasterizer,
    of_methods: OfMethods,
}

#[derive(Debug, Default)]
struct OfMethods {
    budget: Budget,
    of_layers: Vec<OfLayer>,
    image_aligned: image_aligned::Buffers,
    axis_aligned: axis_aligned::Buffers,
    every_sample: every_sample::Buffers,
    densities: densities::Buffers,
}

/// What is cached of a layer of coloured splats.
#[derive(Debug, Default)]
struct OfLayer {
    relevant: Relevant,
    classification: Cached<ClassifiedBy, Classification>,
    /// Of the last frame; only their room serves the next one.
    light: Option<BlinnPhong8>,
    bricks: Option<BrickView>,
}

type ClassifiedBy = (OwnVoxelRules, Compositing, ByIdentity<Volume>);

/// What a frame drew, but for what tiles tell.
struct Drawn {
    n_voxels: u64,
    n_occluded: u64,
}

/// Renders with the instructions of `level`. If the frame is cancelled, or has no room, buffers are as good
/// as any for the next one.
pub(crate) fn render(
    plan: &FramePlan<'_>,
    frame: &FrameHandle,
    level: Level,
    buffers: &mut Buffers,
) -> Result<Frame, StageError> {
    frame.check()?;
    let mut watch = Stopwatch::start(frame);
    let image_size = [plan.image.width, plan.image.height];
    let Buffers { tiles, meshes, of_methods } = buffers;
    // All layers splat alike.
    let first = plan.layers.first();
    let border = match first.map(|layer| &layer.splats) {
        Some(Splats::Colors(_)) | None => 0,
        Some(Splats::Densities(splats)) => densities::border(splats.shown),
    };
    let new_tiles = |_: &_| Tiles::new(image_size, border, frame);
    let tiles = tiles.try_made_of((image_size, border), new_tiles)?;
    tiles.clear(frame);
    if let Some(in_front) = plan.in_front {
        tiles.begin_with(in_front, plan.opacity_cutoff);
    }
    meshes::render(plan.meshes.as_ref(), tiles, meshes, &mut watch)?;
    let Drawn { n_voxels, n_occluded } = of_methods.draw(plan, level, tiles, &mut watch)?;
    tiles.end_rays_before(f32::INFINITY, plan.opacity_cutoff);
    let mut stats = tiles.stats();
    (stats.n_voxels, stats.n_occluded) = (n_voxels, n_occluded);
    let image = tiles.image(plan.image.premultiplied_background(), frame);
    if let Err(cancelled) = watch.done("image") {
        // To give back 200 MB takes 20 ms.
        rayon::spawn(move || drop(image));
        return Err(cancelled.into());
    }
    frame.reach(1.0);
    Ok(Frame::new(image, stats, FrameCost::new(watch.stages(), buffers.resident_bytes())))
}

impl OfMethods {
    /// Splats all layers, if there are any.
    fn draw(
        &mut self,
        plan: &FramePlan<'_>,
        level: Level,
        tiles: &mut Tiles,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Drawn, StageError> {
        let Some(first) = plan.layers.first() else {
            *self = Self { budget: self.budget, ..Self::default() };
            return Ok(Drawn { n_voxels: 0, n_occluded: 0 });
        };
        self.forget_others(&first.splats);
        match &first.splats {
            Splats::Colors(splats) => self.colors(plan, splats, level, tiles, watch),
            Splats::Densities(splats) => {
                let buffers = &mut self.densities;
                let [n_voxels, n_occluded] =
                    densities::render(plan, splats.shown, level, tiles, buffers, watch)?;
                Ok(Drawn { n_voxels, n_occluded })
            }
        }
    }

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
        watch: &mut Stopwatch<'_>,
    ) -> Result<Drawn, StageError> {
        self.of_layers.resize_with(plan.layers.len(), OfLayer::default);
        let of_layers = self.of_layers.iter_mut().zip(&plan.layers);
        let budget = self.budget.of(plan);
        let mut stages = Vec::with_capacity(plan.layers.len());
        for (of_layer, layer) in of_layers {
            stages.push(of_layer.stage(plan, layer, level, budget, watch.frame())?);
        }
        watch.done("list")?;
        let n_voxels = stages.iter().map(|stage: &Stage<'_>| stage.relevant.n_voxels()).sum();
        // All layers splat alike, and there is one but for sections.
        let n_occluded = match splats {
            ColorSplats::Sections(_) => {
                image_aligned::render(&stages, plan, tiles, &mut self.image_aligned, watch)?
            }
            ColorSplats::Slices { order, table } => {
                let buffers = &mut self.axis_aligned;
                axis_aligned::render(&stages[0], order, table, tiles, buffers, watch)?;
                0
            }
            ColorSplats::Voxels { table } => {
                every_sample::render(&stages[0], table, tiles, &mut self.every_sample, watch)?;
                0
            }
        };
        Ok(Drawn { n_voxels, n_occluded })
    }

    fn resident_bytes(&self) -> usize {
        self.of_layers.iter().map(OfLayer::resident_bytes).sum::<usize>()
            + self.image_aligned.resident_bytes()
            + self.axis_aligned.resident_bytes()
            + self.every_sample.resident_bytes()
            + self.densities.resident_bytes()
    }
}

impl OfLayer {
    fn stage<'a>(
        &'a mut self,
        plan: &'a FramePlan<'a>,
        layer: &'a LayerPlan<'a>,
        level: Level,
        budget: Budget,
        frame: &'a FrameHandle,
    ) -> Result<Stage<'a>, StageError> {
        let LayerPlan { volume, transfer, transfer_2d, colors, labels, gradient_opacity, .. } =
            *layer;
        let rules = VoxelRules { transfer, transfer_2d, colors, labels, gradient_opacity };
        let (compositing, identity) = (plan.compositing, ByIdentity::of(volume));
        let classified_by = (OwnVoxelRules::new(&rules), compositing, identity);
        let classify = |_: &_| Classification::for_frame(&rules, compositing, volume, frame);
        let classification = self.classification.try_made_of(classified_by, classify)?;
        self.light = layer.light.as_ref().map(BlinnPhong8::new);
        Ok(Stage {
            plan,
            layer,
            frame,
            level,
            raster: Raster::new(layer, 0),
            relevant: self.relevant.voxels(layer, &layer.relevant, &rules, budget, frame)?,
            bricks: self.bricks.insert(BrickView::new(volume.grid(), &layer.view)),
            lighting: VoxelLighting::new(classification, volume, rules, self.light.as_ref()),
        })
    }

    fn resident_bytes(&self) -> usize {
        self.relevant.resident_bytes()
            + self.classification.value().map_or(0, Classification::resident_bytes)
    }
}

impl Buffers {
    /// Empty ones, whose lists of voxels have such a budget.
    #[cfg(test)]
    pub(crate) fn with_budget(budget: Budget) -> Self {
        Self { of_methods: OfMethods { budget, ..OfMethods::default() }, ..Self::default() }
    }

    fn resident_bytes(&self) -> u64 {
        let of_tiles = self.tiles.value().map_or(0, Tiles::resident_bytes);
        (of_tiles + self.meshes.resident_bytes() + self.of_methods.resident_bytes()) as u64
    }
}
