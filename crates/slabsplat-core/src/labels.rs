//! Labels: what the voxels of a layer belong to, and what that changes of their look (model §13).

use crate::{Grid, TransferFunction, Volume};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;
use thiserror::Error;

/// The label of each voxel of a grid: a whole number, 0 where there is none.
#[derive(PartialEq)]
pub struct LabelMap {
    dims: [usize; 3],
    /// Indices into `labels`, x fastest.
    of_voxels: Vec<u16>,
    labels: Vec<i64>,
    n_outside: usize,
}

/// A map of labels, and how voxels of each look. A copy shares both.
///
/// ```
/// use slabsplat_core::{Grid, LabelMap, LabelStyle, Labels, Scaling, Volume};
///
/// let grid = Grid::with_spacing([2, 1, 1], [1.0; 3])?;
/// let volume = Volume::new(grid, vec![0_u8, 17].into(), Scaling::IDENTITY)?;
/// let map = LabelMap::new(&volume, &grid)?;
/// assert_eq!(map.labels(), [0, 17]);
/// let red = LabelStyle::default().color([1.0, 0.0, 0.0]);
/// let labels = Labels::new(map, [(17, red)])?;
/// assert_eq!(labels.style(0), &LabelStyle::default());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Labels {
    map: Arc<LabelMap>,
    styles: Arc<BTreeMap<i64, LabelStyle>>,
}

/// What a label changes of the look of its voxels.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(
    feature = "serde",
    serde(from = "crate::serialized::LabelStyleKeys", into = "crate::serialized::LabelStyleKeys")
)]
#[non_exhaustive]
pub struct LabelStyle {
    /// The transfer function instead of the layer's.
    pub transfer: Option<TransferFunction>,
    /// The colour instead of the transfer function's: red, green and blue, 0 … 1 each, display-referred.
    pub color: Option<[f64; 3]>,
    /// What the transfer function's opacity is multiplied with, 0 … 1; at 0 the label is invisible.
    pub opacity: f64,
}

/// Why there are no such labels.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LabelError {
    /// A sample names no label.
    #[error("labels are whole numbers, but voxel {voxel_idx} has {value}")]
    NotWhole {
        /// The voxel of the label volume, x fastest.
        voxel_idx: usize,
        /// Its value.
        value: f64,
    },
    /// Too many numbers differ for labels; this may be another kind of volume.
    #[error("there are more than {} different labels", LabelMap::MAX_LABELS)]
    TooMany,
    /// A colour or an opacity is not one.
    #[error("{what} of label {label} lies outside 0 to 1")]
    BadStyle {
        /// Whose.
        label: i64,
        /// `color` or `opacity`.
        what: &'static str,
    },
}

/// Voxels of a grid that lie half way between two labels go to one side, however the half is rounded.
const TIE: f64 = 1e-6;

/// From here on not all whole numbers are a `f64`.
const LARGEST: f64 = 9_007_199_254_740_992.0;

impl LabelMap {
    /// Labels that can be told apart, 0 among them.
    pub const MAX_LABELS: usize = 1 << 16;

    /// What `labels`, whose values are whole numbers, says of the voxels of `grid`, which may be another one
    /// than its own: each has the label whose voxel is nearest along the axes of the labels' grid, and 0 more
    /// than half a voxel step outside of it.
    ///
    /// # Errors
    /// If a value is not a whole number, or there are more than [`MAX_LABELS`](Self::MAX_LABELS) of them.
    pub fn new(labels: &Volume, grid: &Grid) -> Result<Self, LabelError> {
        let numbers = distinct(labels)?;
        let idx_of =
            |label: i64| numbers.binary_search(&label).expect("it was found before") as u16;
        let [nowhere, mut last_idx] = [idx_of(0); 2];
        let mut last_value = 0.0;
        let nearest = Nearest::new(labels.grid(), grid);
        let mut of_voxels = Vec::with_capacity(grid.n_voxels());
        let mut n_outside = 0;
        nearest.for_each(|voxel_idx| {
            let Some(voxel_idx) = voxel_idx else {
                n_outside += 1;
                return of_voxels.push(nowhere);
            };
            let value = labels.value(voxel_idx);
            // Neighbours mostly have one label.
            if value != last_value {
                (last_value, last_idx) = (value, idx_of(value as i64));
            }
            of_voxels.push(last_idx);
        });
        Ok(Self { dims: grid.dims(), of_voxels, labels: numbers, n_outside })
    }

    /// Voxels along the axes of the grid.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// 0 and the labels that there are, rising; not every one need have a voxel of the grid.
    pub fn labels(&self) -> &[i64] {
        &self.labels
    }

    /// Which of the [`labels`](Self::labels) each voxel has, x fastest.
    pub fn indices(&self) -> &[u16] {
        &self.of_voxels
    }

    /// Voxels that are outside of the labels' grid, and so have the label 0.
    pub fn n_outside(&self) -> usize {
        self.n_outside
    }
}

impl fmt::Debug for LabelMap {
    /// All but the labels of voxels, of which there may be billions.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { dims, labels, .. } = self;
        f.debug_struct("LabelMap").field("dims", dims).field("n_labels", &labels.len()).finish()
    }
}

impl Labels {
    /// Labels of voxels and the looks of some; voxels of others look as the layer says.
    ///
    /// # Errors
    /// If a colour or an opacity lies outside 0 … 1.
    pub fn new(
        map: impl Into<Arc<LabelMap>>,
        styles: impl IntoIterator<Item = (i64, LabelStyle)>,
    ) -> Result<Self, LabelError> {
        let styles: BTreeMap<i64, LabelStyle> = styles.into_iter().collect();
        let is_share = |x: &f64| (0.0..=1.0).contains(x);
        for (&label, style) in &styles {
            if !is_share(&style.opacity) {
                return Err(LabelError::BadStyle { label, what: "opacity" });
            }
            if !style.color.iter().flatten().all(is_share) {
                return Err(LabelError::BadStyle { label, what: "color" });
            }
        }
        Ok(Self { map: map.into(), styles: Arc::new(styles) })
    }

    /// The same labels of voxels with other looks.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_styles(
        &self,
        styles: impl IntoIterator<Item = (i64, LabelStyle)>,
    ) -> Result<Self, LabelError> {
        Self::new(self.map.clone(), styles)
    }

    /// The labels of voxels.
    pub fn map(&self) -> &LabelMap {
        &self.map
    }

    /// How voxels of labels look that look otherwise than the layer says.
    pub fn styles(&self) -> &BTreeMap<i64, LabelStyle> {
        &self.styles
    }

    /// How voxels of that label look.
    pub fn style(&self, label: i64) -> &LabelStyle {
        self.styles.get(&label).unwrap_or(&LabelStyle::PLAIN)
    }

    /// The labels that voxels have, rising.
    pub fn of_voxels(&self) -> Vec<i64> {
        let LabelMap { of_voxels, labels, .. } = &*self.map;
        let mut is_there = vec![false; labels.len()];
        of_voxels.iter().for_each(|&idx| is_there[usize::from(idx)] = true);
        labels.iter().zip(is_there).filter_map(|(&label, is)| is.then_some(label)).collect()
    }

    /// Whether a voxel has a label that is visible.
    pub fn any_visible(&self) -> bool {
        self.of_voxels().iter().any(|&label| 0.0 < self.style(label).opacity)
    }
}

impl PartialEq for Labels {
    /// Whether they are the same map, in memory, and look alike.
    fn eq(&self, other: &Self) -> bool {
        let Self { map, styles } = other;
        Arc::ptr_eq(&self.map, map) && (Arc::ptr_eq(&self.styles, styles) || self.styles == *styles)
    }
}

impl LabelStyle {
    const PLAIN: Self = Self { transfer: None, color: None, opacity: 1.0 };

    /// The transfer function that shows voxels of this style, in a layer with that one; `None` if they are
    /// invisible.
    pub fn transfer_in<'a>(
        &'a self,
        of_layer: &'a TransferFunction,
    ) -> Option<&'a TransferFunction> {
        (0.0 < self.opacity).then(|| self.transfer.as_ref().unwrap_or(of_layer))
    }
}

impl LabelStyle {
    /// The same with a transfer function instead of the layer's.
    #[must_use]
    pub fn transfer(self, transfer: TransferFunction) -> Self {
        Self { transfer: Some(transfer), ..self }
    }

    /// The same in a colour instead of the transfer function's.
    #[must_use]
    pub fn color(self, color: [f64; 3]) -> Self {
        Self { color: Some(color), ..self }
    }

    /// The same with opacities multiplied with that, instead of what they were multiplied with.
    #[must_use]
    pub fn opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
}

impl Default for LabelStyle {
    /// As the layer says.
    fn default() -> Self {
        Self::PLAIN
    }
}

/// The labels that a volume has, and 0.
fn distinct(labels: &Volume) -> Result<Vec<i64>, LabelError> {
    let mut numbers = BTreeSet::from([0]);
    let mut last = 0.0;
    for voxel_idx in 0..labels.grid().n_voxels() {
        let value = labels.value(voxel_idx);
        if value == last {
            continue;
        }
        if value.fract() != 0.0 || LARGEST < value.abs() {
            return Err(LabelError::NotWhole { voxel_idx, value });
        }
        last = value;
        if numbers.insert(value as i64) && LabelMap::MAX_LABELS < numbers.len() {
            return Err(LabelError::TooMany);
        }
    }
    Ok(numbers.into_iter().collect())
}

/// The voxels of one grid that are nearest to those of another.
struct Nearest {
    from: Grid,
    of: Grid,
    step: DVec3,
}

impl Nearest {
    fn new(from: &Grid, of: &Grid) -> Self {
        let step = from.index_from_world().transform_vector3(of.world_from_index().matrix3.x_axis);
        Self { from: *from, of: *of, step }
    }

    /// Voxels of `from`, in the order of the voxels of `of`; `None` outside.
    fn for_each(&self, mut work: impl FnMut(Option<usize>)) {
        let [n_x, n_y, n_z] = self.of.dims();
        let from_index = self.from.index_from_world() * self.of.world_from_index();
        for (z, y) in (0..n_z).flat_map(|z| (0..n_y).map(move |y| (z, y))) {
            let start = from_index.transform_point3(DVec3::new(0.0, y as f64, z as f64));
            (0..n_x).for_each(|x| work(self.voxel_idx(start + x as f64 * self.step)));
        }
    }

    /// The voxel of `from` at a point of its index space.
    fn voxel_idx(&self, point: DVec3) -> Option<usize> {
        let [x, y, z] = (point + 0.5 + TIE).floor().to_array();
        let dims = self.from.dims();
        let is_inside = |(at, n): (f64, usize)| 0.0 <= at && at < n as f64;
        let [n_x, n_y, _] = dims;
        [x, y, z]
            .into_iter()
            .zip(dims)
            .all(is_inside)
            .then(|| (z as usize * n_y + y as usize) * n_x + x as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Samples, Scaling};
    use glam::{DAffine3, DMat3};

    fn volume(grid: Grid, samples: impl Into<Samples>) -> Volume {
        Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap()
    }

    fn on(map: &LabelMap) -> Vec<i64> {
        map.indices().iter().map(|&idx| map.labels()[usize::from(idx)]).collect()
    }

    #[test]
    fn label_map_of_the_same_grid() {
        let axes = DMat3::from_cols_array(&[0.3, 0.1, 0.0, -0.1, 0.7, 0.2, 0.05, 0.0, 1.9]);
        let world_from_index = DAffine3::from_mat3_translation(axes, DVec3::new(-120.3, 77.7, 1e4));
        let grid = Grid::new([3, 4, 5], world_from_index).unwrap();
        let samples: Vec<i16> = (0..60).map(|idx| (idx * 7 % 23) - 5).collect();
        let map = LabelMap::new(&volume(grid, samples.clone()), &grid).unwrap();
        assert_eq!(on(&map), samples.into_iter().map(i64::from).collect::<Vec<_>>());
        assert_eq!(map.labels(), (-5..18).collect::<Vec<_>>());
        assert_eq!(map.dims(), [3, 4, 5]);
    }

    /// A row of labels, two world units each, on rows of voxels one unit each that are turned round.
    #[test]
    fn label_map_of_another_grid() {
        let labels = volume(Grid::with_spacing([2, 1, 1], [2.0; 3]).unwrap(), vec![8.0_f32, -3.0]);
        let world_from_index = |x| {
            DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), x)
        };
        let check = |first: DVec3, expected: [i64; 7]| {
            let grid = Grid::new([7, 1, 1], world_from_index(first)).unwrap();
            let map = LabelMap::new(&labels, &grid).unwrap();
            assert_eq!(on(&map), expected, "{first}");
            let n_outside = expected.iter().filter(|&&label| label == 0).count();
            assert_eq!(map.n_outside(), n_outside, "{first}");
        };
        check(DVec3::X * 4.5, [0, 0, -3, -3, 8, 8, 0]);
        check(DVec3::new(4.5, 1.5, 0.0), [0; 7]);
    }

    #[test]
    fn label_map_rejects_what_is_no_label() {
        let grid = Grid::with_spacing([2, 1, 1], [1.0; 3]).unwrap();
        for value in [0.5, f64::NAN, f64::INFINITY, 1e17] {
            let error = LabelMap::new(&volume(grid, vec![1.0, value]), &grid).unwrap_err();
            assert!(matches!(error, LabelError::NotWhole { voxel_idx: 1, .. }), "{error}");
        }
        let n_voxels = LabelMap::MAX_LABELS + 1;
        let grid = Grid::with_spacing([n_voxels, 1, 1], [1.0; 3]).unwrap();
        let all: Vec<u32> = (0..n_voxels as u32).collect();
        assert_eq!(LabelMap::new(&volume(grid, all.clone()), &grid), Err(LabelError::TooMany));
        let fewer: Vec<u32> = all.iter().map(|&label| label.min(0xffff)).collect();
        assert_eq!(LabelMap::new(&volume(grid, fewer), &grid).unwrap().indices()[0xffff], 0xffff);
    }

    #[test]
    fn labels_have_styles() {
        let grid = Grid::with_spacing([1; 3], [1.0; 3]).unwrap();
        let map = Arc::new(LabelMap::new(&volume(grid, vec![7_u8]), &grid).unwrap());
        let style = |opacity| LabelStyle { opacity, ..LabelStyle::default() };
        let labels = Labels::new(map.clone(), [(7, style(0.5))]).unwrap();
        assert_eq!((labels.style(7).opacity, labels.style(8).opacity), (0.5, 1.0));
        assert_eq!(labels, Labels::new(map.clone(), [(7, style(0.5))]).unwrap());
        assert_ne!(labels, labels.with_styles([(7, style(0.25))]).unwrap());
        assert_eq!((labels.of_voxels(), labels.any_visible()), (vec![7], true));
        let invisible = labels.with_styles([(7, style(0.0)), (0, style(1.0))]).unwrap();
        assert!(!invisible.any_visible(), "no voxel has the label 0");
        let layer = TransferFunction::new(vec![(0.0, [1.0])], vec![(0.0, [1.0; 3])]).unwrap();
        assert_eq!(style(0.5).transfer_in(&layer), Some(&layer));
        assert_eq!(style(0.0).transfer_in(&layer), None);
        for opacity in [-0.1, 1.1, f64::NAN] {
            let error = Labels::new(map.clone(), [(3, style(opacity))]).unwrap_err();
            assert_eq!(error, LabelError::BadStyle { label: 3, what: "opacity" });
        }
        let gray = LabelStyle { color: Some([0.5, 2.0, 0.5]), ..LabelStyle::default() };
        let error = Labels::new(map, [(-1, gray)]).unwrap_err();
        assert_eq!(error, LabelError::BadStyle { label: -1, what: "color" });
    }
}
