//! The regular grid of a volume and its position in the world. Does not hold samples.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::ops::Range;
use thiserror::Error;

/// A grid of `nx × ny × nz` voxels, placed in the world by an affine map that may rotate, scale,
/// mirror and shear.
///
/// The map can always be inverted, and the number of voxels fits 32 bits, but for grids that are only there
/// to be [cropped](Grid::cropped) ([`Grid::new_large`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    dims: [usize; 3],
    world_from_index: DAffine3,
    cropped_of: Option<Uncropped>,
}

/// The grid that another one has some of the voxels of.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Uncropped {
    dims: [usize; 3],
    origin: DVec3,
    /// The first of those voxels.
    first: [usize; 3],
    /// Whether cells are those of all voxels.
    has_cells_of_whole: bool,
}

/// Why a grid cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum GridError {
    /// An axis has no voxels.
    #[error("the grid is empty: its dimensions are {0:?}")]
    Empty([usize; 3]),
    /// More voxels than a 32-bit index can name.
    #[error("the grid has too many voxels: {0:?} is more than 4294967295 in all")]
    TooLarge([usize; 3]),
    /// A column has a length below 10⁻¹² or above 10¹², the columns lie (almost) in one plane, or the
    /// origin is more than 10¹⁰ steps away.
    #[error(
        "the grid's matrix cannot be inverted: its voxel steps, {:?}, {:?} and {:?} long, are too short, \
         too long, in one plane, or too far from the origin",
        x.length(), y.length(), z.length()
    )]
    Singular {
        /// World step along the first axis.
        x: DVec3,
        /// World step along the second axis.
        y: DVec3,
        /// World step along the third axis.
        z: DVec3,
    },
}

/// Smallest volume of the parallelepiped that the normalised columns may span.
const MIN_SKEW: f64 = 1e-6;

/// From here on a voxel's index is no 64-bit float any more.
const MOST_VOXELS: u64 = 1 << 53;

/// Voxel steps from the world's origin from which on positions between voxels are lost to rounding.
const MAX_STEPS_FROM_ORIGIN: f64 = 1e10;

/// Cells along each side of a brick ([model §16](crate::model)), and voxels along that of what backends round
/// together.
pub(crate) const BRICK_SIDE: usize = 8;

/// Lengths of a voxel step whose squares and quotients still fit 32-bit floats, with room to spare.
const STEP_LENGTHS: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

impl Grid {
    /// A grid of `dims` voxels whose voxel `(i, j, k)` sits at `world_from_index · (i, j, k)`.
    ///
    /// # Errors
    /// If an axis is empty, there are more than 2³²−1 voxels, or the map cannot be inverted within the
    /// precision of 64 bits.
    pub fn new(dims: [usize; 3], world_from_index: DAffine3) -> Result<Self, GridError> {
        let grid = Self::new_large(dims, world_from_index)?;
        if grid.is_large() { Err(GridError::TooLarge(dims)) } else { Ok(grid) }
    }

    /// The same of as many voxels as there may be, up to 2⁵³: what is in memory, as a
    /// [`Volume`](crate::Volume), has some of them alone, whose grid is [`cropped`](Self::cropped) of this.
    ///
    /// # Errors
    /// As [`Grid::new`], from 2⁵³ voxels on.
    pub fn new_large(dims: [usize; 3], world_from_index: DAffine3) -> Result<Self, GridError> {
        if dims.contains(&0) {
            return Err(GridError::Empty(dims));
        }
        let n_voxels = dims.iter().try_fold(1_usize, |n, &d| n.checked_mul(d));
        if n_voxels.is_none_or(|n| MOST_VOXELS <= n as u64) {
            return Err(GridError::TooLarge(dims));
        }
        let m = world_from_index.matrix3;
        if !is_invertible(m) || !is_reachable(world_from_index) {
            return Err(GridError::Singular { x: m.x_axis, y: m.y_axis, z: m.z_axis });
        }
        Ok(Self { dims, world_from_index, cropped_of: None })
    }

    /// Whether it has more voxels than 32 bits count, so that it can only be cropped.
    pub fn is_large(&self) -> bool {
        u64::from(u32::MAX) < self.n_voxels() as u64
    }

    /// An axis-parallel grid with voxel `(0, 0, 0)` at the world's origin.
    ///
    /// # Errors
    /// As [`Grid::new`]; a spacing of zero cannot be inverted.
    pub fn with_spacing(dims: [usize; 3], spacing: [f64; 3]) -> Result<Self, GridError> {
        Self::new(dims, DAffine3::from_scale(DVec3::from_array(spacing)))
    }

    /// An axis-parallel grid whose middle is the world's origin.
    ///
    /// # Errors
    /// As [`Grid::with_spacing`].
    pub fn centered(dims: [usize; 3], spacing: [f64; 3]) -> Result<Self, GridError> {
        let grid = Self::with_spacing(dims, spacing)?;
        let centered = DAffine3 { translation: -grid.center_in_world(), ..grid.world_from_index };
        Self::new(dims, centered)
    }

    /// The grid of some of the voxels, where they are: views round their positions as those of all.
    ///
    /// # Panics
    /// If there is none, or one of them is not in the grid.
    #[must_use]
    pub fn cropped(&self, voxels: &[Range<usize>; 3]) -> Self {
        for (range, n) in voxels.iter().zip(self.dims) {
            assert!(range.start < range.end && range.end <= n, "{range:?} of {n} voxels");
        }
        let (whole, mut first) = (self.uncropped(), self.first_voxel());
        first.iter_mut().zip(voxels).for_each(|(first, range)| *first += range.start);
        let at =
            whole.world_from_index.transform_point3(DVec3::from_array(first.map(|c| c as f64)));
        let origin = whole.world_from_index.translation;
        Self {
            dims: voxels.each_ref().map(Range::len),
            world_from_index: DAffine3 { translation: at, ..self.world_from_index },
            cropped_of: Some(Uncropped {
                dims: whole.dims,
                origin,
                first,
                has_cells_of_whole: false,
            }),
        }
    }

    /// The same grid of some of the voxels of another one, of which all are drawn, in
    /// [parts](crate::model): [cells](Self::of_cells) are those of the other grid.
    #[must_use]
    pub fn with_cells_of_whole(self) -> Self {
        let has_cells = |whole| Uncropped { has_cells_of_whole: true, ..whole };
        Self { cropped_of: self.cropped_of.map(has_cells), ..self }
    }

    /// The grid whose [cells](Self::of_cells) it has: the one that it was cropped of, if it is drawn
    /// [as part of that](Self::with_cells_of_whole), or itself.
    #[must_use]
    pub fn whole(&self) -> Self {
        if self.is_in_whole() { self.uncropped() } else { *self }
    }

    /// The index of the first voxel in [the whole](Self::whole).
    pub fn first_in_whole(&self) -> [usize; 3] {
        if self.is_in_whole() { self.first_voxel() } else { [0; 3] }
    }

    /// Whether [the whole](Self::whole) is another grid.
    pub fn is_in_whole(&self) -> bool {
        self.cropped_of.is_some_and(|whole| whole.has_cells_of_whole)
    }

    /// The grid that this one was cropped of, or itself.
    #[must_use]
    pub fn uncropped(&self) -> Self {
        self.cropped_of.map_or(*self, |Uncropped { dims, origin, .. }| Self {
            dims,
            world_from_index: DAffine3 { translation: origin, ..self.world_from_index },
            cropped_of: None,
        })
    }

    /// The index of the first voxel in the grid that this one was cropped of.
    pub fn first_voxel(&self) -> [usize; 3] {
        self.cropped_of.map_or([0; 3], |whole| whole.first)
    }

    /// The grid of cells that each hold `2^level` voxels along every axis, those at the ends perhaps fewer: a
    /// cell is where the middle of so many voxels is ([model §16](crate::model)). If it is part of a
    /// [whole](Self::whole), it is the grid of those cells of the whole that are in the same bricks of 8³
    /// cells as its voxels.
    ///
    /// # Errors
    /// As [`Grid::new`], if its steps are too long.
    pub fn of_cells(&self, level: u32) -> Result<Self, GridError> {
        if level == 0 {
            return Ok(*self);
        }
        let whole = self.whole();
        let side = 1_usize << level;
        let middle = DVec3::splat(0.5 * (side as f64 - 1.0));
        let voxel_from_cell = DAffine3::from_scale_rotation_translation(
            DVec3::splat(side as f64),
            DQuat::IDENTITY,
            middle,
        );
        let dims = whole.dims.map(|n| n.div_ceil(side));
        let cells = Self::new_large(dims, whole.world_from_index * voxel_from_cell)?;
        let is_in_whole = self.is_in_whole();
        Ok(if is_in_whole {
            cells.cropped(&self.cells(level)).with_cells_of_whole()
        } else {
            cells
        })
    }

    /// The cells of a level, among those of [the whole](Self::whole), in whole bricks.
    fn cells(&self, level: u32) -> [Range<usize>; 3] {
        let (first, dims) = (self.first_in_whole(), self.whole().dims);
        [0, 1, 2].map(|axis| {
            let side = BRICK_SIDE << level;
            let bricks = first[axis] / side..(first[axis] + self.dims[axis]).div_ceil(side);
            let n_cells = dims[axis].div_ceil(1 << level);
            bricks.start * BRICK_SIDE..n_cells.min(bricks.end * BRICK_SIDE)
        })
    }

    /// How many steps of theirs the first and the last cells of each axis lie further out than where
    /// [`of_cells`](Self::of_cells) puts them, so that the grid ends where its voxels do
    /// ([model §16](crate::model)); 0 where [the whole](Self::whole) goes on.
    pub fn ends_of_cells(&self, level: u32) -> [[f64; 2]; 3] {
        let side = 1_usize << level;
        let (dims, cells) = (self.whole().dims, self.cells(level));
        [0, 1, 2].map(|axis| {
            let (n, cells) = (dims[axis], &cells[axis]);
            let is_last = cells.end == n.div_ceil(side);
            let n_in_ends =
                [(cells.start == 0).then_some(side), is_last.then_some((n - 1) % side + 1)];
            n_in_ends.map(|n| n.map_or(0.0, |n| end_of_cells(side, n)))
        })
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Number of voxels, at least 1, and below 2³² unless the grid [is large](Self::is_large).
    pub fn n_voxels(&self) -> usize {
        self.dims.iter().product()
    }

    /// Takes index space to world space.
    pub fn world_from_index(&self) -> DAffine3 {
        self.world_from_index
    }

    /// Takes world space to index space.
    pub fn index_from_world(&self) -> DAffine3 {
        self.world_from_index.inverse()
    }

    /// World length of a step along each axis.
    pub fn spacing(&self) -> [f64; 3] {
        let m = self.world_from_index.matrix3;
        [m.x_axis.length(), m.y_axis.length(), m.z_axis.length()]
    }

    /// The world length of one voxel step: the shortest column of the matrix ([model §1](crate::model)). Slab
    /// widths and opacities are per unit.
    pub fn unit(&self) -> f64 {
        self.spacing().into_iter().fold(f64::INFINITY, f64::min)
    }

    /// How long in the world a step of whatever direction can be that is one step long in index space: the
    /// longest step where axes are at right angles, and no more than a bound elsewhere (Gershgorin's, of the
    /// matrix times its transpose).
    pub fn longest_in_world(&self) -> f64 {
        let m = self.world_from_index.matrix3;
        let products = m.transpose() * m;
        let row_sum = |axis: usize| products.row(axis).abs().element_sum();
        [0, 1, 2].map(row_sum).into_iter().fold(0.0, f64::max).sqrt()
    }

    /// The middle of the grid in index space.
    pub fn center_in_index(&self) -> DVec3 {
        DVec3::from_array(self.dims.map(|n| (n as f64 - 1.0) / 2.0))
    }

    /// The middle of the grid in world space.
    pub fn center_in_world(&self) -> DVec3 {
        self.world_from_index.transform_point3(self.center_in_index())
    }

    /// The middle of several grids: their own, if there is one, else that of the world's box around the
    /// corner voxels of all.
    pub fn center_of_all<'a>(grids: impl IntoIterator<Item = &'a Self> + Clone) -> DVec3 {
        let mut alone = grids.clone().into_iter();
        if let (Some(only), None) = (alone.next(), alone.next()) {
            return only.center_in_world();
        }
        let corners = grids.into_iter().flat_map(Self::corners_in_world);
        let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [min, max] = corners.fold(nothing, |[min, max], at| [min.min(at), max.max(at)]);
        min.midpoint(max)
    }

    /// Where the eight corner voxels are in world space.
    pub fn corners_in_world(&self) -> impl Iterator<Item = DVec3> + use<> {
        let (last, world_from_index) = (2.0 * self.center_in_index(), self.world_from_index);
        (0..8).map(move |corner: u8| {
            let is_last = [0, 1, 2].map(|axis| f64::from(corner >> axis & 1));
            world_from_index.transform_point3(last * DVec3::from_array(is_last))
        })
    }

    /// Where voxel `(i, j, k)` is in memory.
    ///
    /// # Panics
    /// In debug builds, if a coordinate is outside the grid.
    pub fn voxel_idx(&self, [i, j, k]: [usize; 3]) -> usize {
        let [nx, ny, nz] = self.dims;
        debug_assert!(
            i < nx && j < ny && k < nz,
            "voxel ({i}, {j}, {k}) is outside {:?}",
            self.dims
        );
        (k * ny + j) * nx + i
    }

    /// The coordinates `(i, j, k)` of the voxel at `voxel_idx` in memory.
    pub fn voxel_coords(&self, voxel_idx: usize) -> [usize; 3] {
        let [nx, ny, _] = self.dims;
        let row = voxel_idx / nx;
        [voxel_idx % nx, row % ny, row / ny]
    }
}

fn is_reachable(world_from_index: DAffine3) -> bool {
    let m = world_from_index.matrix3;
    let shortest = m.x_axis.length().min(m.y_axis.length()).min(m.z_axis.length());
    let origin = world_from_index.translation;
    origin.is_finite() && origin.length() < MAX_STEPS_FROM_ORIGIN * shortest
}

fn is_invertible(m: DMat3) -> bool {
    let lengths = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::length);
    lengths.iter().all(|length| STEP_LENGTHS.contains(length))
        && MIN_SKEW < m.determinant().abs() / lengths.iter().product::<f64>()
}

/// How many cells the last one, which holds so many voxels along an axis, lies further out.
fn end_of_cells(side: usize, n_in_last: usize) -> f64 {
    let [side, n] = [side, n_in_last].map(|n| n as f64);
    let variance = (side * side - 1.0) / 12.0;
    let outwards = 0.5 * (n - side) + variance / n;
    // Hardly anything of a cell must not lie far beyond all others.
    outwards.min(variance / side) / side
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_cells_are_in_the_middle_of_their_voxels() {
        let columns = [DVec3::new(1.0, 0.2, 0.0), DVec3::new(-0.3, 2.0, 0.0), DVec3::Z];
        let [x, y, z] = columns;
        let placed = DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), DVec3::ONE);
        let grid = Grid::new([8, 9, 5], placed).unwrap();
        for level in [1, 2, 3] {
            let cells = grid.of_cells(level).unwrap();
            let side = 1 << level;
            assert_eq!(cells.dims(), [8, 9, 5].map(|n: usize| n.div_ceil(side)));
            let last = DVec3::splat(f64::from(side as u32 - 1));
            let at = |voxel| grid.world_from_index().transform_point3(voxel);
            let middle = at(DVec3::ZERO).midpoint(at(last));
            let first = cells.world_from_index().transform_point3(DVec3::ZERO);
            assert!(first.distance(middle) < 1e-12, "{level}: {first} {middle}");
            let wide = cells.spacing().map(|step| step / side as f64);
            assert!(wide.iter().zip(grid.spacing()).all(|(a, b)| (a - b).abs() < 1e-12));
        }
    }

    /// By hand. Two voxels have the variance 1/4, a part of which moves the last cell: 1/8 voxel steps.
    #[test]
    fn grid_of_cells_ends_further_out() {
        let grid = Grid::with_spacing([8, 9, 10], [1.0; 3]).unwrap();
        assert_eq!(grid.ends_of_cells(0), [[0.0; 2]; 3]);
        let [x, y, z] = grid.ends_of_cells(1);
        assert_eq!((x, z), ([0.0625; 2], [0.0625; 2]));
        assert_eq!(y, [0.0625, 0.5 * (-0.5 + 0.25)], "a voxel alone");
        let [_, y, _] = grid.ends_of_cells(3);
        assert_eq!(y, [63.0 / 768.0; 2], "not further out than a whole one");
    }

    /// By hand: of 100 × 20 × 8 voxels those from (40, 8, 0) to (71, 19, 7).
    #[test]
    fn grid_cells_of_a_whole_are_where_its_own_are() {
        let placed = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::ONE, 0.3 * DVec3::Z));
        let whole = Grid::new([100, 20, 8], placed).unwrap();
        let alone = whole.cropped(&[40..72, 8..20, 0..8]);
        let part = alone.with_cells_of_whole();
        assert_eq!((alone.whole(), alone.first_in_whole()), (alone, [0; 3]));
        assert_eq!((part.whole(), part.first_in_whole()), (whole, [40, 8, 0]));
        assert_eq!(alone.of_cells(1).unwrap().dims(), [16, 6, 4]);
        for (level, first, dims) in
            [(1, [16, 0, 0], [24, 10, 4]), (2, [8, 0, 0], [16, 5, 2]), (3, [0, 0, 0], [13, 3, 1])]
        {
            let cells = part.of_cells(level).unwrap();
            assert_eq!((cells.first_voxel(), cells.dims()), (first, dims), "{level}");
            let of_whole = whole.of_cells(level).unwrap();
            assert_eq!(cells.uncropped(), of_whole);
            let [x, y, z] = whole.ends_of_cells(level);
            let x_in_part = if level == 3 { x } else { [0.0; 2] };
            assert_eq!(part.ends_of_cells(level), [x_in_part, y, z], "{level}");
        }
    }

    /// No direction is longer, and in orthogonal axes one is as long.
    #[test]
    fn grid_knows_its_longest_step() {
        let grid = Grid::with_spacing([2; 3], [1.0, 3.0, 2.0]).unwrap();
        assert!((grid.longest_in_world() - 3.0).abs() < 1e-12);
        let columns = [DVec3::new(1.0, 0.2, 0.0), DVec3::new(-0.3, 2.0, 0.5), DVec3::Z];
        let m = DMat3::from_cols(columns[0], columns[1], columns[2]);
        let sheared = Grid::new([2; 3], DAffine3::from_mat3(m)).unwrap();
        let mut longest = 0.0_f64;
        for idx in 0..1000 {
            let (azimuth, height) = (f64::from(idx) * 2.4, f64::from(idx) / 500.0 - 0.999);
            let across = (1.0 - height * height).sqrt();
            let step = DVec3::new(across * azimuth.cos(), across * azimuth.sin(), height);
            longest = longest.max((m * step).length());
        }
        let bound = sheared.longest_in_world();
        assert!((longest..1.2 * longest).contains(&bound), "{longest} {bound}");
    }

    #[test]
    fn grid_index_round_trip() {
        let grid = Grid::with_spacing([3, 4, 5], [1.0, 2.0, 0.5]).unwrap();
        for voxel_idx in 0..grid.n_voxels() {
            assert_eq!(grid.voxel_idx(grid.voxel_coords(voxel_idx)), voxel_idx);
        }
        assert_eq!(grid.voxel_coords(1), [1, 0, 0], "x runs fastest");
    }

    #[test]
    fn grid_unit_is_shortest_column() {
        let sheared = DAffine3::from_mat3(DMat3::from_cols(
            DVec3::new(2.0, 0.0, 0.0),
            DVec3::new(0.3, 1.5, 0.0),
            DVec3::new(0.0, 0.0, -3.0),
        ));
        let grid = Grid::new([4, 4, 4], sheared).unwrap();
        assert!((grid.unit() - 1.5_f64.hypot(0.3)).abs() < 1e-12);
        let there_and_back = grid.index_from_world() * grid.world_from_index();
        assert!(there_and_back.abs_diff_eq(DAffine3::IDENTITY, 1e-12));
    }

    #[test]
    fn grid_rejects_what_cannot_be_inverted() {
        assert_eq!(Grid::with_spacing([0, 1, 1], [1.0; 3]), Err(GridError::Empty([0, 1, 1])));
        for bad in [[0.0, 1.0, 1.0], [f64::NAN, 1.0, 1.0], [f64::INFINITY, 1.0, 1.0], [1e200; 3]] {
            let err = Grid::with_spacing([2, 2, 2], bad).unwrap_err();
            assert!(matches!(err, GridError::Singular { .. }), "{bad:?}: {err}");
        }
        for huge in [[usize::MAX; 3], [1 << 16, 1 << 16, 1]] {
            assert_eq!(Grid::with_spacing(huge, [1.0; 3]), Err(GridError::TooLarge(huge)));
        }
    }

    /// What is too large for a volume may be cropped.
    #[test]
    fn grid_that_is_large_is_cropped() {
        let dims = [1 << 16, 1 << 16, 1 << 10];
        let grid = Grid::new_large(dims, DAffine3::from_scale(DVec3::splat(0.5))).unwrap();
        let cropped = grid.cropped(&[65_000..65_536, 0..2, 1023..1024]);
        assert!(grid.is_large() && !cropped.is_large() && cropped.uncropped() == grid);
        assert_eq!(cropped.world_from_index().translation, DVec3::new(32_500.0, 0.0, 511.5));
        for huge in [[usize::MAX; 3], [1 << 18, 1 << 18, 1 << 17]] {
            let large = Grid::new_large(huge, DAffine3::IDENTITY);
            assert_eq!(large, Err(GridError::TooLarge(huge)));
        }
        let volume = crate::Volume::new(grid, vec![0_u8].into(), crate::Scaling::IDENTITY);
        assert_eq!(volume.unwrap_err(), crate::VolumeError::TooLarge(dims));
    }

    #[test]
    fn grid_rejects_what_rounding_would_lose() {
        let check = |spacing: [f64; 3], shear: f64, origin: DVec3, is_good: bool| {
            let mut columns = DMat3::from_diagonal(DVec3::from_array(spacing));
            columns.y_axis.x = shear;
            let map = DAffine3 { matrix3: columns, translation: origin };
            let text = format!("{spacing:?} {shear} {origin}");
            assert_eq!(Grid::new([2; 3], map).is_ok(), is_good, "{text}");
        };
        check([1.0; 3], 0.0, DVec3::X * 0.9e10, true);
        check([1.0; 3], 0.0, DVec3::X * 1.1e10, false);
        check([100.0; 3], 0.0, DVec3::X * 0.9e12, true);
        check([100.0, 1.0, 100.0], 0.0, DVec3::X * 0.9e12, false);
        check([1.0; 3], 0.0, DVec3::NAN, false);
        check([1.0; 3], 0.0, DVec3::NEG_INFINITY, false);
        // The sine between the columns, whatever their lengths are.
        for scale in [1e-3, 1.0, 1e3] {
            check([scale; 3], 0.9e6 * scale, DVec3::ZERO, true);
            check([scale; 3], 1.1e6 * scale, DVec3::ZERO, false);
        }
        check([1.0, 1.0, 1e12], 0.0, DVec3::ZERO, true);
        check([1.0, 1.0, 1.1e12], 0.0, DVec3::ZERO, false);
    }

    #[test]
    fn grid_centered_has_its_middle_in_the_origin() {
        let grid = Grid::centered([3, 4, 5], [1.0, 0.1, 2.5]).unwrap();
        assert!(grid.center_in_world().length() < 1e-15);
        assert_eq!(grid.spacing(), [1.0, 0.1, 2.5]);
        assert!(Grid::centered([3, 0, 5], [1.0; 3]).is_err());
    }

    #[test]
    fn grid_center_is_halfway_to_the_last_voxel() {
        let map = DAffine3 { translation: DVec3::ONE, ..DAffine3::from_scale(DVec3::NEG_Z + 2.0) };
        let grid = Grid::new([3, 4, 5], map).unwrap();
        let last = grid.world_from_index().transform_point3(DVec3::new(2.0, 3.0, 4.0));
        assert_eq!(grid.center_in_world(), DVec3::ONE.midpoint(last));
    }
}
