//! Makes frame plans, and keeps the tables that the next frame can use again.

use crate::layer_order::in_one_order;
use crate::layer_to_plan::{FrameToPlan, TablesOfLayer};
use crate::meshes;
use crate::scene_checks::{check_method, check_parts, is_of_densities};
use crate::seen_layer::{CellsToSee, SeenLayer};
use crate::slabs::{Depths, check_sections};
use crate::work::SlabWork;
use crate::{DensitySplats, FramePlan, PlanError, SceneInParts};
use slabsplat_core::{
    Compositing, FrameHandle, Grid, Layer, Light, Method, Mode, Part, PartInView, PartSupport,
    Scene,
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
    leaves_out_cells: bool,
}

impl Planner {
    /// Adds a kernel, which settings may name from now on.
    ///
    /// # Errors
    /// As [`Kernels::add`].
    pub fn add_kernel(&mut self, kernel: Arc<dyn Kernel>) -> Result<(), KernelError> {
        self.kernels.add(kernel)
    }

    /// Says whether plans have cells that may be drawn instead of voxels. They do at first; for backends that
    /// draw none ([`Caps::draws_cells`](crate::Caps::draws_cells)) their tables are made in vain.
    pub fn plan_cells(&mut self, are_planned: bool) {
        self.leaves_out_cells = !are_planned;
    }

    /// Plans a frame of `scene` that draws the voxels whose opacity is above 0.
    ///
    /// # Errors
    /// If the scene has neither layers nor meshes, the settings name no kernel, or their numbers cannot be
    /// used with these layers.
    pub fn plan<'a>(&mut self, scene: &'a Scene) -> Result<FramePlan<'a>, PlanError> {
        self.plan_for_frame(scene, &FrameHandle::new())
    }

    /// The same for a frame: with some settings tables take seconds.
    ///
    /// # Errors
    /// If that is cancelled, too ([`PlanError::Cancelled`]).
    pub fn plan_for_frame<'a>(
        &mut self,
        scene: &'a Scene,
        frame: &FrameHandle,
    ) -> Result<FramePlan<'a>, PlanError> {
        self.plan_what_is_drawn(scene, None, frame)
    }

    /// How far outside of a part voxels of `grid`, which is of one of the layers of `scene`, may have a share
    /// in its picture, and the coarsest level of cells by which they may be drawn there.
    ///
    /// # Errors
    /// If the settings name no kernel, or the grid cannot be seen.
    pub fn support_of_parts(
        &self,
        scene: &SceneInParts<'_>,
        grid: &Grid,
    ) -> Result<PartSupport, PlanError> {
        let kernel = self.kernels.named(&scene.settings.kernel.0)?;
        let support = scene.support(grid, &*kernel)?;
        Ok(if self.leaves_out_cells { support.with_cells(0) } else { support })
    }

    /// Plans a frame of a part of a scene, whose layers need have no voxels but those
    /// [around it](Self::support_of_parts), on grids of their own. Cells of levels up to `coarsest` may be
    /// drawn of those on grids [in a whole](Grid::whole) ([model §17](slabsplat_core::model)).
    ///
    /// # Errors
    /// If the scene could not be drawn, or is not drawn in parts.
    pub fn plan_part<'a>(
        &mut self,
        scene: &'a Scene,
        part: &Part,
        coarsest: u32,
        frame: &FrameHandle,
    ) -> Result<FramePlan<'a>, PlanError> {
        check_parts(scene)?;
        self.plan_what_is_drawn(scene, Some((part, coarsest)), frame)
    }

    fn plan_what_is_drawn<'a>(
        &mut self,
        scene: &'a Scene,
        part: Option<(&Part, u32)>,
        frame: &FrameHandle,
    ) -> Result<FramePlan<'a>, PlanError> {
        let (part, coarsest_in_part) = part.unzip();
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
        let cells = CellsToSee { levels: &levels, coarsest_in_part };
        let cells = (!self.leaves_out_cells).then_some(&cells);
        let grids = layers.iter().map(|layer| layer.volume.grid());
        let center = part.map_or_else(|| Grid::center_of_all(grids.clone()), Part::center);
        let seen =
            layers.iter().map(|layer| SeenLayer::new(layer, center, scene, kernel.radius(), cells));
        let seen = collected(n_layers, seen)?;
        let views = seen.iter().map(|seen| (seen.layer.volume.grid().unit(), seen.voxels.view));
        let meshes = meshes::in_view(scene, views)?;
        let without_layers = FramePlan {
            layers: Vec::new(),
            meshes,
            image: scene.image,
            compositing: scene.settings.mode.compositing().unwrap_or(Compositing::Extinction),
            opacity_cutoff: scene.settings.opacity_cutoff as f32,
            part: part
                .zip(seen.first())
                .map(|(part, seen)| PartInView::new(part, &seen.voxels.view)),
            in_front: None,
        };
        let has_meshes = without_layers.meshes.is_some();
        let Some(unit) = least_unit(&layers) else {
            return has_meshes.then_some(without_layers).ok_or(PlanError::NoLayers);
        };
        let width = match method {
            Method::ImageAligned => settings.slab_width,
            Method::PostClassified => settings.slab_width / DensitySplats::SHEETS_PER_SLAB,
            // They have no slabs.
            Method::AxisAligned | Method::EverySample => 1.0,
        };
        if has_slabs(method) {
            grids.clone().try_for_each(|grid| {
                check_sections(grid, kernel.radius(), width * unit, settings.slab_width)
            })?;
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
            has_meshes,
            frame,
        };
        self.tables.resize_with(n_layers, TablesOfLayer::default);
        let parts = seen.into_iter().zip(&mut self.tables);
        let parts = parts.filter(|(seen, _)| shows(seen.layer, scene.settings.mode));
        let plans = parts.map(|(seen, tables)| to_plan.layer(&seen, tables));
        Ok(FramePlan { layers: collected(n_layers, plans)?, ..without_layers })
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
