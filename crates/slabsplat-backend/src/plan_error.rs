//! Why a scene cannot be drawn.

use crate::slabs::MAX_SLABS_OF_A_KERNEL;
use slabsplat_core::{
    Cancelled, ImageError, LightError, Method, Mode, OutOfRange, SettingsError, TooManySlabs,
    ViewError,
};
use slabsplat_kernel::UnknownKernel;
use thiserror::Error;

/// Why a scene cannot be drawn.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
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
    /// A kernel would be cut into sections without end: the steps of a volume are too unequal, or those of
    /// two layers, or slabs too thin.
    #[error(
        "a kernel of the volume with spacing {spacing} is {n_slabs:.0} slabs deep, more than \
         {MAX_SLABS_OF_A_KERNEL}: correct the spacing, or set slab_width to {wide_enough} or more"
    )]
    TooManySections {
        /// The volume's voxel steps, in world units.
        spacing: String,
        /// How many slabs a kernel would meet.
        n_slabs: f64,
        /// A slab width, as settings have it, at which it meets few enough.
        wide_enough: f64,
    },
    /// Slabs would make work out of all proportion to voxels and pixels: the steps of a volume are too
    /// unequal, or those of two layers, or slabs too thin.
    #[error(
        "a frame of {n:.1e} {of} takes too long: the volume with spacing {spacing} is cut into too many \
         slabs, as {cause}; {}",
        what_helps(*wide_enough, *is_drawn_by_every_sample)
    )]
    TooMuchWork {
        /// How many.
        n: f64,
        /// Of what there are too many.
        of: &'static str,
        /// The voxel steps of the volume that has the most part in it, in world units.
        spacing: String,
        /// What makes it so much.
        cause: String,
        /// A slab width, as settings have it, at which there are few enough of them.
        wide_enough: f64,
        /// Whether [`Method::EverySample`], which has no slabs, draws the scene as it is.
        is_drawn_by_every_sample: bool,
    },
    /// There is nothing to draw.
    #[error("the scene has no layers and no meshes")]
    NoLayers,
    /// Its sheets are not of slabs, which layers could share.
    #[error(
        "the method {method} draws one layer, not {n_layers}: image-aligned and post-classified draw any \
         number"
    )]
    OneLayer {
        /// The method.
        method: Method,
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
    /// Colours are of voxels, and of another number of them than there are.
    #[error("colours of {colors:?} voxels are not those of a volume of {volume:?}")]
    ColorsOfAnotherGrid {
        /// Of the colours, along each axis.
        colors: [usize; 3],
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
    /// What it shows of a part depends on more than what is near.
    #[error(
        "a volume is drawn in parts by image-aligned sheets that are composited, without meshes: not {what}"
    )]
    NotInParts {
        /// The method, the mode or the meshes.
        what: String,
    },
    /// The frame was cancelled before its tables were made ([`Planner::plan_for_frame`]).
    ///
    /// [`Planner::plan_for_frame`]: crate::Planner::plan_for_frame
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What makes less work of a scene, as far as it can be done to this one.
fn what_helps(wide_enough: f64, is_drawn_by_every_sample: bool) -> String {
    if is_drawn_by_every_sample {
        format!(
            "correct the spacing, set slab_width to {wide_enough} or more, or draw every-sample, which has \
             no slabs"
        )
    } else {
        format!("correct the spacing, or set slab_width to {wide_enough} or more")
    }
}
