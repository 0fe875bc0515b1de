//! A frame to be made: all of a plan that the device needs, in the shaders' own terms, so that the
//! plan can go.

use crate::classification::Classification;
use crate::depth_params::DepthSort;
use crate::frame_params::frame_params;
use crate::number::Numbers;
use crate::params::{Frame, TILE_SIDE};
use crate::samples::KeyCounts;
use crate::section_table::{Quad, footprint_quads, section_quads};
use slabsplat_backend::{ColorSplats, FramePlan, LayerPlan};
use slabsplat_core::Volume;
use slabsplat_kernel::{FootprintTable, SectionTable};
use std::sync::Arc;

/// A volume, and what one pass over all its samples finds.
#[derive(Debug)]
pub(crate) struct KnownVolume {
    pub(crate) volume: Arc<Volume>,
    pub(crate) numbers: Numbers,
    pub(crate) key_counts: KeyCounts,
}

/// The table of a plan.
#[derive(Clone, Debug)]
pub(crate) enum Table {
    Sections(Arc<SectionTable>),
    Footprint(Arc<FootprintTable>),
}

/// A frame to be made.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    pub(crate) known: Arc<KnownVolume>,
    pub(crate) classification: Classification,
    pub(crate) frame: Frame,
    /// How the list is sorted, if not by sheets.
    pub(crate) depth_sort: Option<DepthSort>,
    pub(crate) table: Table,
    /// At least as many voxels as are relevant, and at least one: a little more than are, so that the
    /// number stays where the list grows and shrinks a little.
    pub(crate) max_voxels: u64,
}

impl KnownVolume {
    pub(crate) fn new(volume: Arc<Volume>) -> Self {
        let (numbers, key_counts) = (Numbers::new(&volume), KeyCounts::new(&volume));
        Self { volume, numbers, key_counts }
    }
}

impl Table {
    /// Whether both are one table, not only alike.
    pub(crate) fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Sections(a), Self::Sections(b)) => Arc::ptr_eq(a, b),
            (Self::Footprint(a), Self::Footprint(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }

    pub(crate) fn quads(&self) -> Vec<Quad> {
        match self {
            Self::Sections(table) => section_quads(table),
            Self::Footprint(table) => footprint_quads(table),
        }
    }

    fn row_len(&self) -> u32 {
        // A quad for every two neighbours.
        match self {
            Self::Sections(table) => table.row_len() as u32 - 1,
            Self::Footprint(table) => table.row().len() as u32 - 1,
        }
    }
}

impl Job {
    /// What a plan of one layer asks for, whose splats are these, of a volume that is known. The list should
    /// stay below `most_voxels`, if it can.
    pub(crate) fn new(
        plan: &FramePlan<'_>,
        layer: &LayerPlan<'_>,
        splats: &ColorSplats,
        known: Arc<KnownVolume>,
        most_voxels: u64,
    ) -> Self {
        let table = match splats {
            ColorSplats::Sections(sections) => Table::Sections(sections.table.clone()),
            ColorSplats::Slices { table, .. } | ColorSplats::Voxels { table } => {
                Table::Footprint(table.clone())
            }
        };
        let sorts_by_depth = matches!(splats, ColorSplats::Voxels { .. });
        let classification = Classification::new(plan, layer, &known.numbers);
        let n_relevant = known.key_counts.at_most(&classification.key_ranges).max(1);
        let granule = (n_relevant / 8).next_power_of_two();
        let max_voxels = n_relevant.next_multiple_of(granule).min(most_voxels.max(n_relevant));
        Self {
            max_voxels,
            classification,
            frame: frame_params(plan, layer, splats, table.row_len()),
            depth_sort: sorts_by_depth.then(|| DepthSort::new(layer)),
            table,
            known,
        }
    }

    pub(crate) fn n_tiles(&self) -> u32 {
        self.frame.n_tiles[0] * self.frame.n_tiles[1]
    }

    /// About how many splats are tossed: each voxel, as often as a footprint at the grid's centre touches
    /// tiles. Close-ups may need more, which shows when it is too late, or far less.
    pub(crate) fn expected_splats(&self) -> u64 {
        let frame = &self.frame;
        let distance = if frame.is_perspective == 1 { frame.eye_distance.max(1.0) } else { 1.0 };
        let scale = frame.pixels_per_unit / distance;
        let pixels = scale * (1.0 / scale).max(1.0);
        let across =
            |half_extent: f32| 1.0 + 2.0 * half_extent * frame.radius * pixels / TILE_SIDE as f32;
        let per_voxel = frame.half_extent.map(across).iter().product::<f32>();
        (self.max_voxels as f64 * f64::from(per_voxel.min(MOST_TILES_EXPECTED))) as u64
    }
}

/// Of voxels with larger footprints most are outside of the picture. A guess must not cost more memory than a
/// frame needs; if it was too small, the counts tell.
const MOST_TILES_EXPECTED: f32 = 4.0;
