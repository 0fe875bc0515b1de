//! Makes frame plans, and keeps the tables that the next frame can use again.

use crate::layer_order::in_one_order;
use crate::meshes;
use crate::scene_checks::{check_method, is_of_densities};
use crate::seen_layer::{SeenGrid, SeenLayer};
use crate::shown_values::shown_ranges;
use crate::slabs::{Depths, check_sections};
use crate::tables::{LayerToSplat, Tables};
use crate::work::SlabWork;
use crate::{DensitySplats, FramePlan, LayerPlan, PlanError};
use slabsplat_core::{
    BlinnPhong, Compositing, Layer, Light, Method, Mode, RegionInView, RenderSettings, Scene,
    Shading, SlabGrid,
};
use slabsplat_kernel::{DetailLevels, ErrorBudget, Kernel, KernelError, Kernels};
use std::sync::Arc;

/// Makes frame plans. Tables cost a millisecond or more, and seldom change from one frame to the next, so the
/// last ones are cached.
#[derive(Debug, Default)]
pub struct Planner {
    kernels: Kernels,
    /// Of the layers of the last frame, in its order.
    tables: Vec<TablesOfLayer>,
}

/// Those of a layer by its voxels, and by cells of them.
#[derive(Debug, Default)]
struct TablesOfLayer {
    of_voxels: Tables,
    of_cells: Tables,
}

impl Planner {
    /// Adds a kernel, which settings may name from now on.
    ///
    /// # Errors
    /// As [`Kernels::add`].
    pub fn add_kernel(&mut self, kernel: Arc<dyn Kernel>) -> Result<(), KernelError> {
        self.kernels.add(kernel)
    }

    /// Plans a frame of `scene` that draws the voxels whose opacity is above 0.
    ///
    /// # Errors
    /// If the scene has neither layers nor meshes, the settings name no kernel, or their numbers cannot be
    /// used with these layers.
    pub fn plan<'a>(&mut self, scene: &'a Scene) -> Result<FramePlan<'a>, PlanError> {
        let settings = scene.settings.clone().checked()?;
        scene.image.checked()?;
        Light::check_all(&scene.lights)?;
        let n_layers = scene.layers.len();
        check_method(scene, settings.method)?;
        // Both methods with slabs have the same densities.
        let method =
            if is_of_densities(settings.mode) { Method::PostClassified } else { settings.method };
        let kernel = self.kernels.named(&settings.kernel.0)?;
        let layers = in_one_order(&scene.layers);
        // What densities may be off is off in each layer by itself (model §10).
        let n_sharing = if method == Method::PostClassified { 1 } else { n_layers };
        let levels = DetailLevels::new(&*kernel, ErrorBudget::new(&settings).among(n_sharing));
        let seen = layers
            .iter()
            .map(|layer| SeenLayer::new(layer, &layers, scene, kernel.radius(), &levels));
        let seen = collected(n_layers, seen)?;
        let views = seen.iter().map(|seen| (seen.layer.volume.grid().unit(), seen.voxels.view));
        let meshes = meshes::in_view(scene, views)?;
        let frame = FramePlan {
            layers: Vec::new(),
            meshes,
            image: scene.image,
            compositing: scene.settings.mode.compositing().unwrap_or(Compositing::Extinction),
            opacity_cutoff: scene.settings.opacity_cutoff as f32,
        };
        let Some(unit) = least_unit(&layers) else {
            return frame.meshes.is_some().then_some(frame).ok_or(PlanError::NoLayers);
        };
        let width = match method {
            Method::ImageAligned => settings.slab_width,
            Method::PostClassified => settings.slab_width / DensitySplats::SHEETS_PER_SLAB,
            // They have no slabs.
            Method::AxisAligned | Method::EverySample => 1.0,
        };
        if has_slabs(method) {
            layers.iter().map(|layer| layer.volume.grid()).try_for_each(|grid| {
                check_sections(grid, kernel.radius(), width * unit, settings.slab_width)
            })?;
            let grids = layers.iter().map(|layer| layer.volume.grid());
            let (slab_width, n_pixels) = (settings.slab_width, scene.image.n_pixels());
            let radius = kernel.radius();
            // Of densities it would show another picture.
            let is_drawn_by_every_sample = &|| {
                method == Method::ImageAligned && check_method(scene, Method::EverySample).is_ok()
            };
            SlabWork { grids, method, radius, slab_width, n_pixels, is_drawn_by_every_sample }
                .check()?;
        }
        let slabs = Depths::slabs(seen.iter().flat_map(SeenLayer::depths), width * unit)?;
        let to_plan = FrameToPlan {
            scene,
            kernel: &*kernel,
            settings: settings.tolerance(scene.settings.tolerance / n_sharing as f64),
            method,
            unit,
            width,
            slabs,
            has_meshes: frame.meshes.is_some(),
        };
        self.tables.resize_with(n_layers, TablesOfLayer::default);
        let parts = seen.into_iter().zip(&mut self.tables);
        let parts = parts.filter(|(seen, _)| shows(seen.layer, scene.settings.mode));
        let plans = parts.map(|(seen, tables)| to_plan.layer(&seen, tables));
        Ok(FramePlan { layers: collected(n_layers, plans)?, ..frame })
    }
}

/// What the plans of all layers of a frame share.
struct FrameToPlan<'a> {
    scene: &'a Scene,
    kernel: &'a dyn Kernel,
    /// With the tolerance that a layer has of it.
    settings: RenderSettings,
    method: Method,
    /// The shortest voxel step of any layer, and the width of what sheets are of, in such.
    unit: f64,
    width: f64,
    slabs: SlabGrid,
    has_meshes: bool,
}

impl FrameToPlan<'_> {
    fn layer<'a>(
        &self,
        seen: &SeenLayer<'a>,
        TablesOfLayer { of_voxels, of_cells }: &mut TablesOfLayer,
    ) -> Result<LayerPlan<'a>, PlanError> {
        let mut planned = |seen_cells| self.level(seen.layer, seen_cells, of_cells, None);
        let coarser = seen.cells.as_ref().map(&mut planned).transpose()?;
        self.level(seen.layer, &seen.voxels, of_voxels, coarser.map(Box::new))
    }

    fn level<'a>(
        &self,
        layer: &'a Layer,
        SeenGrid { level, grid, view, shape, depths }: &SeenGrid,
        tables: &mut Tables,
        coarser: Option<Box<LayerPlan<'a>>>,
    ) -> Result<LayerPlan<'a>, PlanError> {
        // The same slabs, in steps of this grid.
        let scale = self.unit / grid.unit();
        let settings = self
            .settings
            .clone()
            .method(self.method)
            .slab_width(scale * self.width)
            .base_slab_width(scale * self.settings.base_slab_width);
        settings.check_hierarchy(shape.kappa)?;
        let slabs = depths.in_slabs(&self.slabs, view);
        let is_cut = !layer.region.is_everywhere();
        let is_split = is_cut || self.has_meshes;
        let kernel = self.kernel;
        let to_splat = LayerToSplat { kernel, grid, view, shape, settings, slabs, is_split };
        Ok(LayerPlan {
            volume: &layer.volume,
            relevant: shown_ranges(layer, self.scene.settings.mode.into()),
            transfer: &layer.transfer,
            transfer_2d: layer.transfer_2d.as_ref(),
            gradient_opacity: layer.gradient_opacity.as_ref(),
            colors: layer.colors.as_ref(),
            labels: layer.labels.as_ref(),
            isosurfaces: &layer.isosurfaces,
            light: match layer.shading {
                Shading::None => None,
                Shading::Phong(phong) => {
                    Some(BlinnPhong::new(phong, &self.scene.lights, view.axes().forward))
                }
            },
            region: is_cut.then(|| RegionInView::new(&layer.region, view)),
            level: *level,
            grid: *grid,
            coarser,
            splats: tables.splats(to_splat),
            radius: kernel.radius(),
            half_depth: depths.half_depth,
            view: *view,
            shape: *shape,
        })
    }
}

/// So many of them, or the first error. What collects results has room for more than it needs.
fn collected<T>(
    n: usize,
    items: impl Iterator<Item = Result<T, PlanError>>,
) -> Result<Vec<T>, PlanError> {
    let mut collected = Vec::with_capacity(n);
    for item in items {
        collected.push(item?);
    }
    Ok(collected)
}

/// Whether kernels are cut into sections, of which there may be too many.
fn has_slabs(method: Method) -> bool {
    match method {
        Method::ImageAligned | Method::PostClassified => true,
        Method::AxisAligned | Method::EverySample => false,
    }
}

/// Whether there is anything that a layer could show.
fn shows(layer: &Layer, mode: Mode) -> bool {
    mode != Mode::Isosurfaces || !layer.isosurfaces.is_empty()
}

/// The shortest voxel step of any layer.
fn least_unit(layers: &[&Layer]) -> Option<f64> {
    layers.iter().map(|layer| layer.volume.grid().unit()).reduce(f64::min)
}

#[cfg(test)]
mod tests;
