//! Makes frame plans, and keeps the tables that the next frame can use again.

use crate::layer_order::in_one_order;
use crate::meshes;
use crate::slabs::Depths;
use crate::tables::{LayerToSplat, Tables};
use crate::{DensitySplats, FramePlan, LayerPlan};
use slabsplat_core::{
    BlinnPhong, Compositing, Grid, ImageError, IsoRange, LabelStyle, Layer, Light, LightError,
    Method, Mode, OutOfRange, RegionInView, RenderSettings, Scene, SettingsError, Shading,
    Statistic, TooManySlabs, TransferFunction, View, ViewError,
};
use slabsplat_kernel::{FootprintShape, UnknownKernel, kernel_named};
use thiserror::Error;

/// Why a scene cannot be drawn.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// There is no such kernel.
    #[error(transparent)]
    UnknownKernel(#[from] UnknownKernel),
    /// A width, count or cut-off cannot be used.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// There is no such picture.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// Voxels would be too large or too small.
    #[error(transparent)]
    View(#[from] ViewError),
    /// A coefficient of the shading cannot be used.
    #[error(transparent)]
    Shading(#[from] OutOfRange),
    /// A light cannot be used.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The slabs are too thin for the volume.
    #[error(transparent)]
    TooManySlabs(#[from] TooManySlabs),
    /// There is nothing to draw.
    #[error("the scene has no layers and no meshes")]
    NoLayers,
    /// Its sheets are not of colours in slabs, which layers could share.
    #[error(
        "{what} draws one layer, not {n_layers}: image-aligned sheets that are composited draw any number"
    )]
    OneLayer {
        /// The method or the mode.
        what: String,
        /// How many layers the scene has.
        n_layers: usize,
    },
    /// Sheets of this method are not of slabs, which a region could cut.
    #[error("the method {0} cuts nothing off: image-aligned and post-classified do")]
    NoRegions(Method),
    /// Labels are of voxels, and of another number of them than there are.
    #[error("labels of {labels:?} voxels are not those of a volume of {volume:?}")]
    LabelsOfAnotherGrid {
        /// Of the labels, along each axis.
        labels: [usize; 3],
        /// Of the volume.
        volume: [usize; 3],
    },
    /// A density is a mean over voxels, which may have several labels.
    #[error(
        "{what} shows densities, which have no labels: use image-aligned sheets that are composited"
    )]
    LabelsOfDensities {
        /// The method or the mode.
        what: String,
    },
    /// Its sheets have no depths up to which they could count, or are not composited.
    #[error(
        "{what} draws no meshes: image-aligned and post-classified sheets that are composited do"
    )]
    NoMeshes {
        /// The method or the mode.
        what: String,
    },
    /// No numbers hold where all of them are.
    #[error("the meshes of the scene are too large, or too far apart, to be seen at once")]
    MeshesTooLarge,
    /// The method has no densities to choose from.
    #[error(
        "the mode {mode} shows densities, which {method} has none of: use image-aligned or post-classified"
    )]
    NoDensities {
        /// The mode.
        mode: Mode,
        /// The method.
        method: Method,
    },
}

/// Makes frame plans. Tables cost a millisecond or more, and seldom change from one frame to the next, so the
/// last ones are cached.
#[derive(Debug, Default)]
pub struct Planner {
    /// Of the layers of the last frame, in its order.
    tables: Vec<Tables>,
}

impl Planner {
    /// Plans a frame of `scene` that draws the voxels whose opacity is above 0.
    ///
    /// # Errors
    /// If the scene has neither layers nor meshes, the settings name no kernel, or their numbers cannot be
    /// used with these layers.
    pub fn plan<'a>(&mut self, scene: &'a Scene) -> Result<FramePlan<'a>, PlanError> {
        let settings = scene.settings.clone().checked()?;
        scene.image.checked()?;
        Light::check_all(&scene.lights)?;
        let (n_layers, statistic) = (scene.layers.len(), settings.mode.statistic());
        check_method(scene)?;
        // Of which density a picture shows, both methods with slabs have the same.
        let method = if statistic.is_some() { Method::PostClassified } else { settings.method };
        let kernel = kernel_named(&settings.kernel.0)?;
        let layers = in_one_order(&scene.layers);
        let seen = layers.iter().map(|layer| SeenLayer::new(layer, &layers, scene));
        let seen = collected(n_layers, seen)?;
        let views = seen.iter().map(|seen| (seen.layer.volume.grid().unit(), seen.view));
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
        let has_meshes = frame.meshes.is_some();
        let width = match method {
            Method::ImageAligned => settings.slab_width,
            Method::PostClassified => settings.slab_width / DensitySplats::SHEETS_PER_SLAB,
            // They have no slabs.
            Method::AxisAligned | Method::EverySample => 1.0,
        };
        let depths = seen.iter().map(|layer| layer.depths(kernel.radius())).collect::<Vec<_>>();
        let slabs = Depths::slabs(&depths, width * unit)?;
        self.tables.resize_with(n_layers, Tables::default);
        let parts = seen.into_iter().zip(&depths).zip(&mut self.tables);
        let plan = |((seen, depths), tables): ((SeenLayer<'a>, &Depths), &mut Tables)| {
            let SeenLayer { layer, view, shape } = seen;
            let grid = layer.volume.grid();
            // The same slabs, in voxel steps of this layer.
            let scale = unit / grid.unit();
            let settings = settings
                .clone()
                .method(method)
                .slab_width(scale * width)
                .base_slab_width(scale * settings.base_slab_width)
                .tolerance(settings.tolerance / n_layers as f64);
            settings.check_hierarchy(shape.kappa)?;
            let slabs = depths.in_slabs(&slabs, &view);
            let (view, shape, kernel) = (&view, &shape, &*kernel);
            let is_cut = !layer.region.is_everywhere();
            let is_split = is_cut || has_meshes;
            let to_splat = LayerToSplat { kernel, grid, view, shape, settings, slabs, is_split };
            Ok(LayerPlan {
                volume: &layer.volume,
                relevant: shown_ranges(visible_ranges(layer), statistic),
                transfer: &layer.transfer,
                labels: layer.labels.as_ref(),
                light: match layer.shading {
                    Shading::None => None,
                    Shading::Phong(phong) => {
                        Some(BlinnPhong::new(phong, &scene.lights, view.axes().forward))
                    }
                },
                region: is_cut.then(|| RegionInView::new(&layer.region, view)),
                splats: tables.splats(to_splat),
                radius: kernel.radius(),
                half_depth: depths.half_depth,
                view: *view,
                shape: *shape,
            })
        };
        Ok(FramePlan { layers: collected(n_layers, parts.map(plan))?, ..frame })
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

/// Whether the method can draw such a scene.
fn check_method(scene: &Scene) -> Result<(), PlanError> {
    let RenderSettings { method, mode, .. } = scene.settings;
    let has_slabs = match method {
        Method::ImageAligned | Method::PostClassified => true,
        Method::AxisAligned | Method::EverySample => false,
    };
    let n_layers = scene.layers.len();
    check_labels(scene)?;
    if !scene.meshes.is_empty() {
        if !has_slabs {
            return Err(PlanError::NoMeshes { what: format!("the method {method}") });
        }
        if mode.statistic().is_some() {
            return Err(PlanError::NoMeshes { what: format!("the mode {mode}") });
        }
    }
    if !has_slabs && scene.layers.iter().any(|layer| !layer.region.is_everywhere()) {
        return Err(PlanError::NoRegions(method));
    }
    if mode.statistic().is_some() {
        if !has_slabs {
            return Err(PlanError::NoDensities { mode, method });
        }
        if 1 < n_layers {
            return Err(PlanError::OneLayer { what: format!("the mode {mode}"), n_layers });
        }
    } else if 1 < n_layers && method != Method::ImageAligned {
        return Err(PlanError::OneLayer { what: format!("the method {method}"), n_layers });
    }
    Ok(())
}

/// Whether the method can tell labels, and each voxel has one.
fn check_labels(scene: &Scene) -> Result<(), PlanError> {
    let RenderSettings { method, mode, .. } = scene.settings;
    for layer in &scene.layers {
        let Some(labels) = &layer.labels else { continue };
        if mode.statistic().is_some() {
            return Err(PlanError::LabelsOfDensities { what: format!("the mode {mode}") });
        }
        if method == Method::PostClassified {
            return Err(PlanError::LabelsOfDensities { what: format!("the method {method}") });
        }
        let [labels, volume] = [labels.map().dims(), layer.volume.grid().dims()];
        if labels != volume {
            return Err(PlanError::LabelsOfAnotherGrid { labels, volume });
        }
    }
    Ok(())
}

/// The values that are visible of any voxel.
fn visible_ranges(layer: &Layer) -> Vec<IsoRange> {
    let of_layer = &layer.transfer;
    let Some(labels) = &layer.labels else { return of_layer.iso_ranges() };
    let styles = labels.map().labels().iter().map(|&label| labels.style(label));
    let shown: Vec<&LabelStyle> =
        styles.filter(|style| style.transfer(of_layer).is_some()).collect();
    let own = shown.iter().filter_map(|style| style.transfer.as_ref());
    let shows_layer = shown.iter().any(|style| style.transfer.is_none());
    IsoRange::union(
        own.chain(shows_layer.then_some(of_layer)).flat_map(TransferFunction::iso_ranges),
    )
}

/// The densities that decide what is shown, where those of some ranges are visible.
fn shown_ranges(visible: Vec<IsoRange>, statistic: Option<Statistic>) -> Vec<IsoRange> {
    let (Some(statistic), Some(first), Some(last)) = (statistic, visible.first(), visible.last())
    else {
        return visible;
    };
    // A larger density hides a visible one, or a lesser one does; into a mean all of them go.
    let (lo, hi) = match statistic {
        Statistic::Maximum => (first.lo, f64::INFINITY),
        Statistic::Minimum => (f64::NEG_INFINITY, last.hi),
        Statistic::Average => (f64::NEG_INFINITY, f64::INFINITY),
    };
    vec![IsoRange { lo, hi }]
}

/// A layer as the camera sees it.
struct SeenLayer<'a> {
    layer: &'a Layer,
    view: View,
    shape: FootprintShape,
}

impl<'a> SeenLayer<'a> {
    fn new(layer: &'a Layer, all: &[&Layer], scene: &Scene) -> Result<Self, PlanError> {
        if let Shading::Phong(phong) = layer.shading {
            phong.checked()?;
        }
        let grid = layer.volume.grid();
        let center = Grid::center_of_all(all.iter().map(|layer| layer.volume.grid()));
        let view = View::about(center, grid, &scene.camera, &scene.image)?;
        let shape = FootprintShape::new(grid, view.axes());
        Ok(Self { layer, view, shape })
    }

    fn depths(&self, radius: f64) -> Depths {
        let grid = self.layer.volume.grid();
        let of_voxels = self.view.from_index(grid).depth_range(grid);
        Depths { of_voxels, half_depth: radius * self.shape.half_depth }
    }
}

/// The shortest voxel step of any layer.
fn least_unit(layers: &[&Layer]) -> Option<f64> {
    layers.iter().map(|layer| layer.volume.grid().unit()).reduce(f64::min)
}

#[cfg(test)]
mod tests;
