//! What kind of data a volume holds, by what its file says and by its values.

use slabsplat_core::{Acquisition, Grid, Modality, Orientation};

use super::histogram::Histogram;
use super::statistics::Statistics;

/// What a volume is of, as far as that changes how it is best shown.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DataKind {
    /// All voxels have one value, or none has any.
    Flat,
    /// A few whole numbers that name what voxels belong to.
    Labels,
    /// Computed tomography whose values are Hounsfield units, plus a constant.
    Hounsfield {
        /// The value of water.
        water: f64,
    },
    /// Magnetic resonance, and what else has a body's orientation and no unit.
    Mr,
    /// Something that glows before a dark background.
    Microscopy,
    /// A smooth function, as simulations compute it.
    Field,
    /// Voxels that have colours of their own.
    Colors,
    /// Anything else that was measured.
    Scan,
}

/// Share of voxels that have an equal neighbour in maps of labels; of scans a few per cent have, but for what
/// is clipped.
const EVEN: f64 = 0.7;

/// Second differences over first ones, up to which values are a function that somebody computed. Of scans
/// that have no body's orientation it is 0.45 (a tooth) to 1.04, of simulations 0.13 to 0.79, and of noise
/// 1.5.
const SMOOTH: f64 = 0.35;
const FAIRLY_SMOOTH: f64 = 0.9;

/// What part of the variance of values lies between two things that have a value each, as a ball has and what
/// is around it; in simulations it is 0.8.
const TWO_THINGS: f64 = 0.9;

/// Millimetres of a voxel's side from which on no microscope made it.
const LARGEST_MICROSCOPIC: f64 = 0.1;

/// Millimetres of a head and what is scanned around it.
const LARGEST_HEAD: f64 = 300.0;

/// Hounsfield units of air, with the noise that it has and without, and of what bodies are mostly made of.
const AIR: [f64; 2] = [-1100.0, -850.0];
const SOFT_TISSUE: [f64; 2] = [-150.0, 120.0];

/// What is added to Hounsfield units where they are stored without a sign: DICOM's usual intercept, and none.
const OFFSETS: [f64; 2] = [0.0, 1024.0];

impl DataKind {
    /// What it is called in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flat => "one value everywhere",
            Self::Labels => "labels",
            Self::Hounsfield { .. } => "CT in Hounsfield units",
            Self::Mr => "MR or the like",
            Self::Microscopy => "microscopy",
            Self::Field => "a smooth field",
            Self::Colors => "colours",
            Self::Scan => "a scan",
        }
    }

    /// The value of water, if values are Hounsfield units and a constant.
    #[cfg(feature = "files")]
    pub(crate) fn water(self) -> Option<f64> {
        match self {
            Self::Hounsfield { water } => Some(water),
            _ => None,
        }
    }

    /// Whether it is a head or so: a scan of a body that is as small.
    pub(crate) fn is_head(self, grid: &Grid) -> bool {
        let longest = (0..3).map(|axis| grid.spacing()[axis] * grid.dims()[axis] as f64);
        matches!(self, Self::Hounsfield { .. }) && longest.fold(0.0, f64::max) < LARGEST_HEAD
    }

    pub(super) fn of(grid: &Grid, statistics: &Statistics, acquisition: Acquisition) -> Self {
        let Some(histogram) = &statistics.histogram else { return Self::Flat };
        if is_labels(statistics, histogram) {
            return Self::Labels;
        }
        if let Some(water) = water(statistics, histogram, acquisition) {
            return Self::Hounsfield { water };
        }
        match (acquisition.modality, acquisition.orientation) {
            (Some(Modality::Microscopy), _) => Self::Microscopy,
            (None, Orientation::Pictures) if is_microscopic(grid) => Self::Microscopy,
            (Some(Modality::Mr), _) | (None, Orientation::Anatomical) => Self::Mr,
            (None, Orientation::Unknown) if is_computed(grid, histogram) => Self::Field,
            _ => Self::Scan,
        }
    }
}

/// Whether values are smooth, and not those of two things with a border between; a little rougher ones may be
/// where the grid is a cube, as that of a simulation mostly is, and that of a scan hardly ever.
fn is_computed(grid: &Grid, histogram: &Histogram) -> bool {
    let roughness = histogram.roughness_from(histogram.background().last + 1);
    let [nx, ny, nz] = grid.dims();
    let limit = if nx == ny && ny == nz { FAIRLY_SMOOTH } else { SMOOTH };
    roughness < limit && histogram.separability() < TWO_THINGS
}

fn is_labels(statistics: &Statistics, histogram: &Histogram) -> bool {
    let Some(distinct) = &statistics.distinct else { return false };
    distinct.len() == 2 || EVEN <= histogram.evenness_from(1)
}

/// Voxels without a length, or such as microscopes have.
fn is_microscopic(grid: &Grid) -> bool {
    let spacing = grid.spacing();
    spacing == [1.0; 3] || spacing.iter().all(|&step| step < LARGEST_MICROSCOPIC)
}

/// The value of water, if values are Hounsfield units: there is air, there is soft tissue, and between them
/// less than of either; and nothing is too far away.
fn water(statistics: &Statistics, histogram: &Histogram, acquisition: Acquisition) -> Option<f64> {
    let [least, largest] = statistics.extremes;
    let share = |[lo, hi]: [f64; 2]| {
        let levels = [lo, hi].map(|value| histogram.scale.level_of(value).unwrap_or(0));
        histogram.share_from(levels[0]) - histogram.share_from(levels[1] + 1)
    };
    let is_it = |&offset: &f64| {
        let at = |[lo, hi]: [f64; 2]| [lo + offset, hi + offset];
        // Other scans reach such values too; but air that was measured is never even, and what says where the
        // body is mostly says what is added.
        let is_doubtful = offset != 0.0
            && (histogram.background().noise == 0.0
                || acquisition.orientation == Orientation::Anatomical);
        let is_wide = least <= AIR[1] + offset && 300.0 + offset < largest;
        let is_near = -4096.0 - AIR[0] <= least - offset || least < -2000.0;
        let [air, tissue] = [share(at(AIR)), share(at(SOFT_TISSUE))];
        let between = share(at([AIR[1] + 150.0, SOFT_TISSUE[0] - 100.0]));
        !is_doubtful
            && is_wide
            && is_near
            && 0.02 < tissue
            && 0.02 < air
            && between < air.max(tissue)
    };
    let offset = OFFSETS.iter().copied().find(is_it);
    match (offset, acquisition.modality) {
        (None, Some(Modality::Ct)) if least < AIR[1] => Some(0.0),
        (_, Some(Modality::Mr | Modality::Microscopy)) => None,
        (offset, _) => offset,
    }
}
