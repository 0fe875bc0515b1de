//! One of the things that a scene shows (model §10).

use crate::{
    Isosurface, Labels, Phong, PiecewiseLinear, Region, Shading, TransferFunction,
    TransferFunction2d, Volume, VoxelColors,
};
use std::sync::Arc;

/// A volume, which of its values are visible, and what light does to them.
///
/// Two layers are equal if they hold the same volume, in memory ([`Arc::ptr_eq`]), and show it alike.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Layer {
    /// Whose voxels are shown, where they are in the world. A volume never changes, so that what was made of
    /// it for one frame may serve for the next.
    pub volume: Arc<Volume>,
    /// Which values are visible, and in which colour.
    pub transfer: TransferFunction,
    /// What decides instead, by values and gradients together.
    pub transfer_2d: Option<TransferFunction2d>,
    /// What opacities are multiplied with, 0 … 1, as a function of how fast values change there: the length
    /// of the gradient, per `unit` (Levoy 1988).
    pub gradient_opacity: Option<PiecewiseLinear<1>>,
    /// Colours of its voxels instead of the transfer function's, which then says how opaque they are (model
    /// §15); one for each.
    pub colors: Option<VoxelColors>,
    /// What its voxels belong to, if that changes how they look; a map for as many voxels along each axis.
    pub labels: Option<Labels>,
    /// What is shown instead in the mode [`Isosurfaces`](crate::Mode::Isosurfaces), in any order.
    pub isosurfaces: Vec<Isosurface>,
    /// What light does to them.
    pub shading: Shading,
    /// Where they are seen.
    pub region: Region,
}

impl Layer {
    /// What `transfer` shows of all of a volume, lit.
    pub fn new(volume: impl Into<Arc<Volume>>, transfer: TransferFunction) -> Self {
        Self {
            volume: volume.into(),
            transfer,
            transfer_2d: None,
            gradient_opacity: None,
            colors: None,
            labels: None,
            isosurfaces: Vec::new(),
            shading: Shading::Phong(Phong::default()),
            region: Region::default(),
        }
    }

    /// The same of another volume.
    #[must_use]
    pub fn volume(self, volume: impl Into<Arc<Volume>>) -> Self {
        Self { volume: volume.into(), ..self }
    }

    /// The same with other values visible.
    #[must_use]
    pub fn transfer(self, transfer: TransferFunction) -> Self {
        Self { transfer, ..self }
    }

    /// The same with what values and gradients make visible together, instead of values alone.
    #[must_use]
    pub fn transfer_2d(self, transfer_2d: impl Into<Option<TransferFunction2d>>) -> Self {
        Self { transfer_2d: transfer_2d.into(), ..self }
    }

    /// The same with opacities that depend on gradients.
    #[must_use]
    pub fn gradient_opacity(self, factor: impl Into<Option<PiecewiseLinear<1>>>) -> Self {
        Self { gradient_opacity: factor.into(), ..self }
    }

    /// The same with voxels that have colours of their own.
    #[must_use]
    pub fn colors(self, colors: impl Into<Option<VoxelColors>>) -> Self {
        Self { colors: colors.into(), ..self }
    }

    /// The same with voxels that look as their labels say.
    #[must_use]
    pub fn labels(self, labels: impl Into<Option<Labels>>) -> Self {
        Self { labels: labels.into(), ..self }
    }

    /// The same with other isosurfaces.
    #[must_use]
    pub fn isosurfaces(self, isosurfaces: Vec<Isosurface>) -> Self {
        Self { isosurfaces, ..self }
    }

    /// The same, lit otherwise.
    #[must_use]
    pub fn shading(self, shading: Shading) -> Self {
        Self { shading, ..self }
    }

    /// The same, seen nowhere else.
    #[must_use]
    pub fn region(self, region: Region) -> Self {
        Self { region, ..self }
    }
}

impl PartialEq for Layer {
    fn eq(&self, other: &Self) -> bool {
        let Self {
            volume,
            transfer,
            transfer_2d,
            gradient_opacity,
            colors,
            labels,
            isosurfaces,
            shading,
            region,
        } = other;
        Arc::ptr_eq(&self.volume, volume)
            && self.transfer == *transfer
            && self.transfer_2d == *transfer_2d
            && self.gradient_opacity == *gradient_opacity
            && self.colors == *colors
            && self.labels == *labels
            && self.isosurfaces == *isosurfaces
            && self.shading == *shading
            && self.region == *region
    }
}
