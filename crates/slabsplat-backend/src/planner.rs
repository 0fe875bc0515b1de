//! Makes frame plans, and keeps the tables that the next frame can use again.

use crate::layer_order::in_one_order;
use crate::meshes;
use crate::slabs::Depths;
use crate::tables::{LayerToSplat, Tables};
use crate::{DensitySplats, FramePlan, LayerPlan, ShownDensities};
use slabsplat_core::{
    BlinnPhong, Compositing, Grid, ImageError, IsoRange, Isosurface, LabelStyle, Layer, Light,
    LightError, Method, Mode, OutOfRange, RegionInView, RenderSettings, Scene, SettingsError,
    Shading, Statistic, TooManySlabs, TransferFunction, View, ViewError,
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
    /// A density is a mean over voxels, each of which has its own.
    #[error(
        "{what} shows densities, which have no {of_voxels}: use image-aligned sheets that are composited"
    )]
    OfVoxelsAlone {
        /// The method or the mode.
        what: String,
        /// What densities do not have.
        of_voxels: &'static str,
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
    /// There is no surface to draw.
    #[error("the mode isosurfaces needs a value: add --isosurface, or isosurfaces in [classify]")]
    NoIsosurfaces,
    /// Of two surfaces that are one, neither is in front.
    #[error("there are two isosurfaces of the value {0}: leave one out")]
    IsosurfaceTwice(f64),
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
        let n_layers = scene.layers.len();
        check_method(scene)?;
        // Both methods with slabs have the same densities.
        let method =
            if is_of_densities(settings.mode) { Method::PostClassified } else { settings.method };
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
                relevant: shown_ranges(layer, scene.settings.mode.into()),
                transfer: &layer.transfer,
                gradient_opacity: layer.gradient_opacity.as_ref(),
                labels: layer.labels.as_ref(),
                isosurfaces: &layer.isosurfaces,
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

/// Whether a mode shows densities, whatever the method.
fn is_of_densities(mode: Mode) -> bool {
    mode.compositing().is_none()
}

/// Whether the method can draw such a scene.
fn check_method(scene: &Scene) -> Result<(), PlanError> {
    let RenderSettings { method, mode, .. } = scene.settings;
    let has_slabs = match method {
        Method::ImageAligned | Method::PostClassified => true,
        Method::AxisAligned | Method::EverySample => false,
    };
    let n_layers = scene.layers.len();
    check_voxels(scene)?;
    if !scene.meshes.is_empty() {
        if !has_slabs {
            return Err(PlanError::NoMeshes { what: format!("the method {method}") });
        }
        if is_of_densities(mode) {
            return Err(PlanError::NoMeshes { what: format!("the mode {mode}") });
        }
    }
    if !has_slabs && scene.layers.iter().any(|layer| !layer.region.is_everywhere()) {
        return Err(PlanError::NoRegions(method));
    }
    if is_of_densities(mode) {
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

/// Whether the method can tell voxels, where these have labels or opacities of their own.
fn check_voxels(scene: &Scene) -> Result<(), PlanError> {
    let RenderSettings { method, mode, .. } = scene.settings;
    let densities = match method {
        _ if is_of_densities(mode) => Some(format!("the mode {mode}")),
        Method::PostClassified => Some(format!("the method {method}")),
        Method::ImageAligned | Method::AxisAligned | Method::EverySample => None,
    };
    for layer in &scene.layers {
        let of_voxels = [
            ("labels", layer.labels.is_some()),
            ("opacity by gradients", layer.gradient_opacity.is_some()),
        ];
        let of_voxels = of_voxels.into_iter().find_map(|(name, is_there)| is_there.then_some(name));
        if let (Some(what), Some(of_voxels)) = (&densities, of_voxels) {
            return Err(PlanError::OfVoxelsAlone { what: what.clone(), of_voxels });
        }
        if let Some(labels) = &layer.labels {
            let [labels, volume] = [labels.map().dims(), layer.volume.grid().dims()];
            if labels != volume {
                return Err(PlanError::LabelsOfAnotherGrid { labels, volume });
            }
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

/// The densities that decide what is shown of a layer.
fn shown_ranges(layer: &Layer, shown: ShownDensities) -> Vec<IsoRange> {
    let visible = visible_ranges(layer);
    match shown {
        ShownDensities::Composited => visible,
        ShownDensities::Statistic(statistic) => deciding_ranges(visible, statistic),
        ShownDensities::Isosurfaces => {
            let values = layer.isosurfaces.iter().map(Isosurface::value);
            let mut ranges: Vec<IsoRange> = values.map(|v| IsoRange { lo: v, hi: v }).collect();
            ranges.sort_by(|a, b| a.lo.total_cmp(&b.lo));
            ranges
        }
    }
}

/// The densities that decide which one stands for all, where those of some ranges are visible.
fn deciding_ranges(visible: Vec<IsoRange>, statistic: Statistic) -> Vec<IsoRange> {
    let (Some(first), Some(last)) = (visible.first(), visible.last()) else { return visible };
    // A larger density hides a visible one, or a lesser one does; into a mean all of them go.
    let (lo, hi) = match statistic {
        Statistic::Maximum => (first.lo, f64::INFINITY),
        Statistic::Minimum => (f64::NEG_INFINITY, last.hi),
        Statistic::Average => (f64::NEG_INFINITY, f64::INFINITY),
    };
    vec![IsoRange { lo, hi }]
}

/// Whether there are surfaces to draw, each of another value.
fn check_isosurfaces(layer: &Layer) -> Result<(), PlanError> {
    let mut values: Vec<f64> = layer.isosurfaces.iter().map(Isosurface::value).collect();
    if values.is_empty() {
        return Err(PlanError::NoIsosurfaces);
    }
    values.sort_by(f64::total_cmp);
    match values.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(PlanError::IsosurfaceTwice(pair[0])),
        None => Ok(()),
    }
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
        if scene.settings.mode == Mode::Isosurfaces {
            check_isosurfaces(layer)?;
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
