//! Makes frame plans, and keeps the tables that the next frame can use again.

use crate::layer_order::in_one_order;
use crate::slabs::Depths;
use crate::tables::{LayerToSplat, Tables};
use crate::{DensitySplats, FramePlan, LayerPlan};
use slabsplat_core::{
    BlinnPhong, Grid, ImageError, Layer, Method, RegionInView, Scene, SettingsError, Shading,
    ShadingError, TooManySlabs, View, ViewError,
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
    Shading(#[from] ShadingError),
    /// The slabs are too thin for the volume.
    #[error(transparent)]
    TooManySlabs(#[from] TooManySlabs),
    /// There is nothing to draw.
    #[error("the scene has no layers")]
    NoLayers,
    /// Sheets of this method are not of colours in slabs, which layers could share.
    #[error("the method {method} draws one layer, not {n_layers}: image-aligned draws any number")]
    OneLayer {
        /// The method.
        method: Method,
        /// How many layers the scene has.
        n_layers: usize,
    },
    /// Sheets of this method are not of slabs, which a region could cut.
    #[error("the method {0} cuts nothing off: image-aligned and post-classified do")]
    NoRegions(Method),
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
    /// If the scene has no layers, the settings name no kernel, or their numbers cannot be used with these
    /// layers.
    pub fn plan<'a>(&mut self, scene: &'a Scene) -> Result<FramePlan<'a>, PlanError> {
        let settings = scene.settings.clone().checked()?;
        scene.image.checked()?;
        let n_layers = scene.layers.len();
        let method = settings.method;
        if 1 < n_layers && method != Method::ImageAligned {
            return Err(PlanError::OneLayer { method, n_layers });
        }
        let has_slabs = matches!(method, Method::ImageAligned | Method::PostClassified);
        if !has_slabs && scene.layers.iter().any(|layer| !layer.region.is_everywhere()) {
            return Err(PlanError::NoRegions(method));
        }
        let kernel = kernel_named(&settings.kernel.0)?;
        let layers = in_one_order(&scene.layers);
        let seen = layers.iter().map(|layer| SeenLayer::new(layer, &layers, scene));
        let seen = seen.collect::<Result<Vec<_>, _>>()?;
        let unit = least_unit(&layers).ok_or(PlanError::NoLayers)?;
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
                .slab_width(scale * width)
                .base_slab_width(scale * settings.base_slab_width)
                .tolerance(settings.tolerance / n_layers as f64);
            settings.check_hierarchy(shape.kappa)?;
            let slabs = depths.in_slabs(&slabs, &view);
            let kernel = &*kernel;
            let to_splat =
                LayerToSplat { kernel, grid, view: &view, shape: &shape, settings, slabs };
            Ok(LayerPlan {
                volume: &layer.volume,
                relevant: layer.transfer.iso_ranges(),
                transfer: &layer.transfer,
                light: match layer.shading {
                    Shading::None => None,
                    Shading::Phong(phong) => Some(BlinnPhong::new(phong, view.axes().forward)),
                },
                region: (!layer.region.is_everywhere())
                    .then(|| RegionInView::new(&layer.region, &view)),
                splats: tables.splats(to_splat),
                radius: kernel.radius(),
                half_depth: depths.half_depth,
                view,
                shape,
            })
        };
        Ok(FramePlan {
            layers: parts.map(plan).collect::<Result<_, PlanError>>()?,
            image: scene.image,
            compositing: scene.settings.compositing,
            opacity_cutoff: scene.settings.opacity_cutoff as f32,
        })
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
