//! What to draw, decided and checked.

use crate::Slabs;
use slabsplat_core::{
    BlinnPhong, Compositing, Grid, Image, ImageDesc, IsoRange, Isosurface, Labels, MeshLayer, Mode,
    PartInView, PiecewiseLinear, RegionInView, SliceOrder, Statistic, TransferFunction,
    TransferFunction2d, View, Volume, VoxelColors,
};
use slabsplat_kernel::{
    CellLimits, CubicSectionTable, ErrorBudget, FootprintShape, FootprintTable, LitDifferences,
    SectionTable, ShareByCells, SplitLevels, TiltedSections,
};
use std::sync::Arc;

/// One frame, ready to be executed. Made by a [`Planner`](crate::Planner).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FramePlan<'a> {
    /// The volumes that are drawn: only one but for [`ColorSplats::Sections`] and [`Splats::Densities`]. All
    /// splat alike, and are cut by the same slabs; they are summed in this order, which is not that of the
    /// scene. Those with one region follow each other.
    ///
    /// None where there are meshes alone.
    pub layers: Vec<LayerPlan<'a>>,
    /// The opaque meshes among them, if there are any: only for [`ColorSplats::Sections`] and
    /// [`Splats::Densities`] without a statistic, or alone.
    pub meshes: Option<MeshesPlan<'a>>,
    /// Size and background of the picture.
    pub image: ImageDesc,
    /// What a sheet sums, and how that becomes a pixel; of no meaning but for colours and for densities that
    /// are [composited](ShownDensities::Composited).
    pub compositing: Compositing,
    /// Opacity from which a pixel counts as saturated.
    pub opacity_cutoff: f32,
    /// What is drawn of it, if not all: what a slab holds at a pixel, of all layers together, is multiplied
    /// with the share of the part ([model §17](slabsplat_core::model)). Only for [`ColorSplats::Sections`],
    /// by backends that [draw parts](crate::Caps::draws_parts).
    pub part: Option<PartInView>,
    /// What lies in front of all that is drawn, premultiplied and of the picture's size: the picture begins
    /// with it. Only where there is a part.
    pub in_front: Option<&'a Image>,
}

impl FramePlan<'_> {
    /// The shortest voxel step of any layer, in world units.
    pub fn least_unit(&self) -> f64 {
        self.layers.iter().map(|layer| layer.volume.grid().unit()).fold(f64::INFINITY, f64::min)
    }
}

/// One layer of a frame.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LayerPlan<'a> {
    /// Whose voxels are drawn. A volume never changes, so that a backend may keep what it made of it
    /// for as long as plans hold the same one ([`Arc::ptr_eq`]).
    pub volume: &'a Arc<Volume>,
    /// Which voxels are drawn: those with values within these ranges, which are disjoint and rise. For
    /// [`Splats::Densities`], which densities are drawn; all voxels count for those.
    pub relevant: Vec<IsoRange>,
    /// Their opacity and colour.
    pub transfer: &'a TransferFunction,
    /// What these are by value and gradient together instead, only for [`Splats::Colors`]; `relevant` then
    /// holds what is visible of any gradient.
    pub transfer_2d: Option<&'a TransferFunction2d>,
    /// What opacity is multiplied with, by the length of a voxel's gradient per `unit`; only for
    /// [`Splats::Colors`].
    pub gradient_opacity: Option<&'a PiecewiseLinear<1>>,
    /// Colours of voxels instead, only for [`Splats::Colors`]; a label's colour comes before its voxels' own.
    pub colors: Option<&'a VoxelColors>,
    /// What changes these by the label of a voxel, only for [`Splats::Colors`]; `relevant` then holds what is
    /// visible of any label.
    pub labels: Option<&'a Labels>,
    /// What is shown instead by [`ShownDensities::Isosurfaces`]: no value twice, in any order.
    pub isosurfaces: &'a [Isosurface],
    /// What light does to that colour, if there is any.
    pub light: Option<BlinnPhong>,
    /// Where they are seen, if not everywhere: only for [`ColorSplats::Sections`] and [`Splats::Densities`].
    pub region: Option<RegionInView>,
    /// What is splatted: voxels, or from level 1 on cells that each hold `2^level` of them along every axis
    /// ([model §16](slabsplat_core::model)).
    pub level: u32,
    /// The same by cells of the next level, which a backend may draw instead: a permission, as is
    /// [`MergedSections`].
    pub coarser: Option<Box<CellsPlan<'a>>>,
    /// View space and pixels. Depths count from the centre of all layers, lengths in voxel steps of this one.
    pub view: View,
    /// The kernel's radius in index space.
    pub radius: f64,
    /// The kernel's ball as the view sees it.
    pub shape: FootprintShape,
    /// Half the thickness of a voxel's kernel along the viewing direction, in world units.
    pub half_depth: f64,
    /// What is splatted, and into which sheets.
    pub splats: Splats,
}

/// A layer by cells, and which bricks of 8³ cells may be drawn ([model §16](slabsplat_core::model)), of those
/// whose turn has come where their kernels begin ([`share_at`](Self::share_at)); all others are drawn by what
/// is finer.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CellsPlan<'a> {
    /// How they are drawn.
    pub plan: LayerPlan<'a>,
    /// Those that do not exceed these.
    pub limits: CellLimits,
    /// What light makes of differences in them.
    pub lit: LitDifferences,
}

impl CellsPlan<'_> {
    /// The share of bricks whose turn has come at a depth from the centre of all layers, not before the near
    /// depth.
    pub fn share_at(&self, depth: f64) -> ShareByCells {
        let view = &self.plan.view;
        ShareByCells::new(self.plan.level, view.stretch(view.pixels_per_world(depth)))
    }
}

impl<'a> LayerPlan<'a> {
    /// This layer, and the same by cells, level by level.
    pub fn levels(&self) -> impl Iterator<Item = &Self> + use<'_, 'a> {
        std::iter::once(self).chain(self.cells().map(|cells| &cells.plan))
    }

    /// The cells that may be drawn instead, from level 1 on.
    pub fn cells(&self) -> impl Iterator<Item = &CellsPlan<'a>> + use<'_, 'a> {
        let mut next = self.coarser.as_deref();
        std::iter::from_fn(move || {
            let cells = next?;
            next = cells.plan.coarser.as_deref();
            Some(cells)
        })
    }

    /// Where what is splatted is: the volume's grid, or that of its cells.
    pub fn grid(&self) -> Grid {
        let grid = self.volume.grid().of_cells(self.level);
        grid.expect("the planner plans no cells without a grid")
    }
}

/// The opaque meshes of a frame ([model §14](slabsplat_core::model)).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MeshesPlan<'a> {
    /// View space and pixels. Depths count from the centre of all layers, and nothing is hit before the near
    /// depth.
    pub view: View,
    /// At least one; their order has no meaning.
    pub meshes: Vec<MeshPlan<'a>>,
}

/// One mesh of a frame.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MeshPlan<'a> {
    /// Its triangles, where they are, and their colour.
    pub layer: &'a MeshLayer,
    /// What light does to that, if there is any.
    pub light: Option<BlinnPhong>,
    /// Where it is seen, if not everywhere.
    pub region: Option<RegionInView>,
}

impl<'a> MeshesPlan<'a> {
    /// These meshes, seen so.
    pub fn new(view: View, meshes: Vec<MeshPlan<'a>>) -> Self {
        Self { view, meshes }
    }
}

impl<'a> MeshPlan<'a> {
    /// A mesh in its own colours, everywhere.
    pub fn new(layer: &'a MeshLayer) -> Self {
        Self { layer, light: None, region: None }
    }
}

/// A permission, which a backend need not make use of: faces that do not split a voxel's kernel are skipped,
/// and what lies beyond them is merged into its first and its last section
/// ([model §7](slabsplat_core::model)).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MergedSections {
    /// Which faces split a voxel's kernel, by its extinction.
    pub levels: SplitLevels,
    /// Sections with all that lies before or behind a face: those of a slab as wide as the kernel.
    pub table: Arc<SectionTable>,
    /// What this and other short cuts may make a pixel differ by.
    pub budget: ErrorBudget,
}

/// What is splatted, and into which sheets ([model §4](slabsplat_core::model)).
#[derive(Clone, Debug)]
#[expect(clippy::exhaustive_enums, reason = "a backend that does not know one must not build")]
pub enum Splats {
    /// Voxels are classified and shaded, and sheets sum their colours.
    Colors(ColorSplats),
    /// Sheets sum densities, and their pixels are classified and shaded.
    Densities(Box<DensitySplats>),
}

/// Coloured splats.
#[derive(Clone, Debug)]
#[expect(clippy::exhaustive_enums, reason = "a backend that does not know one must not build")]
pub enum ColorSplats {
    /// `image-aligned`: sections, into the slabs that they come from.
    Sections(Box<SectionSplats>),
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
}

/// `image-aligned`: the sections of voxels.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SectionSplats {
    /// The slabs.
    pub slabs: Slabs,
    /// The sections.
    pub table: Arc<SectionTable>,
    /// The same without a table, where slab faces cut the rays of a footprint at different offsets, if the
    /// kernel allows it.
    pub tilted: Option<Arc<TiltedSections>>,
    /// Which of them a backend may merge, and the sections that it needs for that.
    pub merged: Option<MergedSections>,
}

/// `post-classified`: sections, into the sheets that they come from; each adds its weight, and its weight
/// times the voxel's value.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DensitySplats {
    /// What is shown of them.
    pub shown: ShownDensities,
    /// What sheets are of: halves of slabs.
    pub slabs: Slabs,
    /// The sections.
    pub table: Arc<SectionTable>,
    /// The same, smooth enough for differences between pixels.
    pub smooth: SmoothSections,
    /// What a backend may take for sections instead, and the whole footprints that it needs for that.
    pub separable: Option<SeparableDensities>,
}

/// What is shown of sheets of densities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::exhaustive_enums, reason = "a backend that does not know one must not build")]
pub enum ShownDensities {
    /// What lies between them, classified and composited.
    Composited,
    /// The density that stands for all on its ray.
    Statistic(Statistic),
    /// The surfaces on which densities have the values of [`LayerPlan::isosurfaces`].
    Isosurfaces,
}

impl From<Mode> for ShownDensities {
    fn from(mode: Mode) -> Self {
        match (mode.compositing(), mode.statistic()) {
            (Some(_), _) => Self::Composited,
            (None, Some(statistic)) => Self::Statistic(statistic),
            (None, None) => Self::Isosurfaces,
        }
    }
}

impl DensitySplats {
    /// Sheets of densities in a slab ([model §8](slabsplat_core::model)).
    pub const SHEETS_PER_SLAB: f64 = 2.0;
}

/// Sections without the kinks that a table has.
#[derive(Clone, Debug)]
#[expect(clippy::exhaustive_enums, reason = "a backend that does not know one must not build")]
pub enum SmoothSections {
    /// Of a kernel that is a product.
    Product(Arc<TiltedSections>),
    /// Of any kernel.
    Table(Arc<CubicSectionTable>),
}

/// A permission, which a backend need not make use of: sections as a function of the column times one of the
/// row.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SeparableDensities {
    /// Sections with all that lies before or behind a face: those of a slab as wide as the kernel.
    pub whole: Arc<SectionTable>,
    /// What that may make a section differ by.
    pub budget: ErrorBudget,
}
