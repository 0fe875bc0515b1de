//! What to draw, decided and checked.

use slabsplat_core::{
    Compositing, ImageDesc, IsoRange, Shading, SlabGrid, SliceOrder, TransferFunction, View, Volume,
};
use slabsplat_kernel::{
    CubicSectionTable, FootprintShape, FootprintTable, SectionLevels, SectionTable,
};
use std::sync::Arc;

/// One frame, ready to be executed. Made by a [`Planner`](crate::Planner).
#[derive(Clone, Debug)]
pub struct FramePlan<'a> {
    /// Whose voxels are drawn. A volume never changes, so that a backend may keep what it made of it
    /// for as long as plans hold the same one ([`Arc::ptr_eq`]).
    pub volume: &'a Arc<Volume>,
    /// Which voxels are drawn: those with values within these ranges, which are disjoint and rise. For
    /// [`Splats::Densities`], which densities are drawn; all voxels count for those.
    pub relevant: Vec<IsoRange>,
    /// Their opacity and colour.
    pub transfer: &'a TransferFunction,
    /// What light does to that colour.
    pub shading: Shading,
    /// View space and pixels.
    pub view: View,
    /// Size and background of the picture.
    pub image: ImageDesc,
    /// The kernel's radius in index space.
    pub radius: f64,
    /// The kernel's ball as the view sees it.
    pub shape: FootprintShape,
    /// What a sheet sums, and how that becomes a pixel.
    pub compositing: Compositing,
    /// Opacity from which a pixel counts as full.
    pub opacity_cutoff: f32,
    /// What is splatted, and into which sheets.
    pub splats: Splats,
}

/// A permission, which a backend need not make use of: what lies beyond the faces that a voxel's level spares is
/// folded onto its first and its last section (`docs/algorithm.md`, "Sections by opacity").
#[derive(Clone, Debug)]
pub struct FewerSections {
    /// Which faces cut a voxel's kernel, by its extinction.
    pub levels: SectionLevels,
    /// Folded sections: a slab as wide as the kernel cuts all that lies before or behind a face.
    pub table: Arc<SectionTable>,
    /// By how much any channel of a pixel may differ for it.
    pub tolerance: f64,
}

/// What is splatted, and into which sheets (SPEC §4).
#[derive(Clone, Debug)]
pub enum Splats {
    /// `image-aligned`: sections, into the slabs that they come from.
    Sections {
        /// The slabs.
        slabs: SlabGrid,
        /// The sections.
        table: Arc<SectionTable>,
        /// How few of them a backend may splat for a voxel, and the sections that it needs for that.
        fewer: Option<FewerSections>,
    },
    /// `axis-aligned`: whole footprints, into the grid's slices.
    Slices {
        /// The slices.
        order: SliceOrder,
        /// The footprint.
        table: Arc<FootprintTable>,
    },
    /// `every-sample`: whole footprints, each a sheet of its own.
    Voxels {
        /// The footprint.
        table: Arc<FootprintTable>,
    },
    /// `post-classified`: sections, into the slabs that they come from; each adds its weight, and its weight
    /// times the voxel's value.
    Densities {
        /// The slabs.
        slabs: SlabGrid,
        /// The sections, smooth enough for differences between pixels.
        table: Arc<CubicSectionTable>,
    },
}
