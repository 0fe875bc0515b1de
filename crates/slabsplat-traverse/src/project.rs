//! Voxels to view space. What follows, the scale of the slab and the pixel, depends on the slab.
//!
//! ```text
//! once a view:   steps along x of a brick, and the starts of its 64 rows, from its first voxel     64 bits
//! once a brick:  its first voxel = M·(i, j, k) + o, as a rounded number and what rounding lost     64 bits
//! once a voxel:  first voxel + (row + step along x + what was lost)                                32 bits
//! ```
//!
//! 1. A voxel takes three vector additions instead of a matrix.
//! 2. Small numbers are added to each other first, so that a voxel is off by the rounding of its position
//!    alone, however far the grid's corner is from its centre.

use crate::bricks::N_ROWS;
use crate::{BRICK_SIDE, Brick, BrickGrid, RelevantList, VoxelRecord};
use slabsplat_core::glam::{DVec3, Vec3};
use slabsplat_core::{Grid, View, ViewFromIndex};

/// A grid's bricks in view space: `[right, up, depth]` in world units; depth counts from the grid's
/// centre.
///
/// A brick's first voxel is transformed in 64 bits, and what a 32-bit number loses of it is stored; it goes
/// into the steps within the brick, at most 7 along each axis, whose sum is then added to the rest. So there
/// is one rounding of any weight, the last: 6·10⁻⁵ of a voxel step a thousand steps from the centre.
#[derive(Clone, Debug)]
pub struct BrickView {
    view_from_index: ViewFromIndex,
    grid: BrickGrid,
    steps_along_x: [Vec3; BRICK_SIDE],
    /// By row of the brick: steps along y and z.
    rows: [Vec3; N_ROWS],
    /// How many steps the first and the last of each axis lie further out.
    ends: [[f64; 2]; 3],
    /// How many steps of theirs the voxels of cells lie from their middles, along every axis.
    voxels_beside: f64,
}

/// The box in view space, parallel to its axes, that a brick's voxels lie in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickBounds {
    /// The middle: right, up, depth.
    pub center: [f32; 3],
    /// From the middle to the faces.
    pub half_extents: [f32; 3],
}

/// What rounding may move a point by, relative to its distance from the middle of the view.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

impl BrickView {
    /// The bricks of `grid` as `view` sees them.
    pub fn new(grid: &Grid, view: &View) -> Self {
        let view_from_index = view.from_index(grid);
        let m = view_from_index.matrix;
        let row = |row: usize| {
            m.y_axis * (row % BRICK_SIDE) as f64 + m.z_axis * (row / BRICK_SIDE) as f64
        };
        Self {
            view_from_index,
            grid: BrickGrid::new(grid),
            steps_along_x: std::array::from_fn(|x| (m.x_axis * x as f64).as_vec3()),
            rows: std::array::from_fn(|idx| row(idx).as_vec3()),
            ends: [[0.0; 2]; 3],
            voxels_beside: 0.0,
        }
    }

    /// Those of cells of a level, whose grid is `grid`, of a grid of `voxels`.
    pub fn of_cells(voxels: &Grid, level: u32, grid: &Grid, view: &View) -> Self {
        let voxels_beside = 0.5 - 0.5 / f64::from(1_u32 << level);
        Self { ends: voxels.ends_of_cells(level), voxels_beside, ..Self::new(grid, view) }
    }

    /// The bricks.
    pub fn grid(&self) -> &BrickGrid {
        &self.grid
    }

    /// Writes where each voxel of `list` is into `points`, in parallel.
    pub fn project(&self, list: &RelevantList, points: &mut Vec<[f32; 3]>) {
        points.resize(list.len(), [0.0; 3]);
        list.fill_by_brick(points, |brick, records, points| {
            self.project_brick(brick, records, points);
        });
    }

    /// Writes where voxels of one brick are into `points`; there are as many `records` as `points`.
    #[inline]
    pub fn project_brick(&self, brick: &Brick, records: &[VoxelRecord], points: &mut [[f32; 3]]) {
        let origin = self.in_view(self.grid.origin(brick.brick_idx).map(|c| c as f64));
        let rounded = origin.as_vec3();
        let lost = (origin - rounded.as_dvec3()).as_vec3();
        for (point, record) in points.iter_mut().zip(records) {
            let slot = usize::from(record.slot);
            let row = self.rows[slot / BRICK_SIDE % N_ROWS];
            *point = (rounded + (row + self.steps_along_x[slot % BRICK_SIDE] + lost)).to_array();
        }
        if self.ends != [[0.0; 2]; 3] {
            self.move_ends(brick, records, points);
        }
    }

    /// Moves the first and the last of each axis outwards.
    fn move_ends(&self, brick: &Brick, records: &[VoxelRecord], points: &mut [[f32; 3]]) {
        let origin = self.grid.origin(brick.brick_idx);
        let size = self.grid.size_at(origin);
        let m = self.view_from_index.matrix;
        for (axis, step) in [m.x_axis, m.y_axis, m.z_axis].into_iter().enumerate() {
            let shifts: [_; BRICK_SIDE] =
                std::array::from_fn(|at| (self.shift(axis, origin[axis] + at) * step).as_vec3());
            if shifts[..size[axis]].iter().all(|shift| *shift == Vec3::ZERO) {
                continue;
            }
            for (point, record) in points.iter_mut().zip(records) {
                let shift = shifts[record.coords_in_brick()[axis]];
                *point = (Vec3::from_array(*point) + shift).to_array();
            }
        }
    }

    /// How many steps of an axis what is at `at` lies further along it than its index says.
    fn shift(&self, axis: usize, at: usize) -> f64 {
        let [first, last] = self.ends[axis];
        if at == 0 {
            -first
        } else if at + 1 == self.grid.dims()[axis] {
            last
        } else {
            0.0
        }
    }

    /// A box that holds all points of the brick that [`project_brick`](Self::project_brick) gives, for
    /// relevant voxels or not.
    pub fn bounds(&self, brick: &Brick) -> BrickBounds {
        let ends_of = |axis: usize, at: [usize; 2]| at.map(|at| at as f64 + self.shift(axis, at));
        self.bounds_from(brick, ends_of)
    }

    /// The same box if it also holds the brick's voxels, and cells of finer levels, which lie nearer to its
    /// faces than its own cells do.
    pub fn bounds_of_all_levels(&self, brick: &Brick) -> BrickBounds {
        let beside = self.voxels_beside;
        let ends_of = |axis: usize, [first, last]: [usize; 2]| {
            let [before, behind] = [-self.shift(axis, first), self.shift(axis, last)];
            [first as f64 - before.max(beside), last as f64 + behind.max(beside)]
        };
        self.bounds_from(brick, ends_of)
    }

    /// The box of what lies between such ends along each axis, for the first and the last of a brick.
    #[inline(always)]
    fn bounds_from(
        &self,
        brick: &Brick,
        ends_of: impl Fn(usize, [usize; 2]) -> [f64; 2],
    ) -> BrickBounds {
        let origin = self.grid.origin(brick.brick_idx);
        let size = self.grid.size_at(origin);
        let ends =
            [0, 1, 2].map(|axis| ends_of(axis, [origin[axis], origin[axis] + size[axis] - 1]));
        let half = ends.map(|[first, last]| 0.5 * (last - first));
        let center = self.in_view(ends.map(|[first, last]| 0.5 * (first + last)));
        let m = self.view_from_index.matrix;
        let half_extents =
            m.x_axis.abs() * half[0] + m.y_axis.abs() * half[1] + m.z_axis.abs() * half[2];
        let rounding = (center.abs() + 2.0 * half_extents) * ROUNDING;
        BrickBounds {
            center: center.as_vec3().to_array(),
            half_extents: (half_extents + rounding).as_vec3().to_array(),
        }
    }

    fn in_view(&self, in_index: [f64; 3]) -> DVec3 {
        self.view_from_index.transform(DVec3::from_array(in_index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BrickRanges, RelevantList};
    use slabsplat_core::glam::{DAffine3, DMat3};
    use slabsplat_core::{Camera, ImageDesc, IsoRange, Projection, Scaling, Volume};
    use slabsplat_seeds::for_each_seed;

    fn everything(grid: Grid) -> RelevantList {
        let volume =
            Volume::new(grid, vec![1_u8; grid.n_voxels()].into(), Scaling::IDENTITY).unwrap();
        let mut list = RelevantList::default();
        list.update(&volume, &BrickRanges::new(&volume), &[IsoRange { lo: 0.0, hi: 2.0 }], None);
        list
    }

    #[test]
    fn project_measures_depth_from_grid_center() {
        let grid = Grid::with_spacing([3, 1, 1], [2.0, 1.0, 1.0]).unwrap();
        let eye = DVec3::new(-10.0, 0.0, 0.0);
        let projection = Projection::Orthographic { view_height: 5.0 };
        let camera = Camera::new(eye, DVec3::ZERO, DVec3::Z, projection).unwrap();
        let view = View::new(&grid, &camera, &ImageDesc::default()).unwrap();
        let mut points = Vec::new();
        BrickView::new(&grid, &view).project(&everything(grid), &mut points);
        assert_eq!(points, [[0.0, 0.0, -2.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
    }

    /// Long rods, so that voxels are a thousand steps from the centre; steps may be tiny or huge.
    #[test]
    fn project_is_the_definition() {
        for_each_seed(1, |mut rng| {
            for scale in [1e-6, 1.0, 1e6].repeat(10) {
                let mut dims = [1 + rng.usize(0..10), 1 + rng.usize(0..10), 2000];
                rng.shuffle(&mut dims);
                let mut column = || DVec3::new(rng.f64() - 0.5, rng.f64() - 0.5, rng.f64() - 0.5);
                let matrix = scale * DMat3::from_cols(column(), column(), column());
                let Ok(grid) = Grid::new(dims, DAffine3::from_mat3(matrix)) else { continue };
                let eye = grid.center_in_world() + column() * 900.0 * scale;
                let projection = Projection::Orthographic { view_height: 5.0 * scale };
                let up = column();
                let camera = Camera::new(eye, grid.center_in_world(), up, projection).unwrap();
                let view = View::new(&grid, &camera, &ImageDesc::default()).unwrap();
                check(&grid, &view);
            }
        });
    }

    fn check(grid: &Grid, view: &View) {
        let list = everything(*grid);
        let brick_view = BrickView::new(grid, view);
        let view_from_index = view.from_index(grid);
        let m = view_from_index.matrix;
        let longest_step = m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length());
        let mut points = vec![[0.0; 3]; 512];
        for brick in list.bricks() {
            let records = list.voxels_of(brick);
            brick_view.project_brick(brick, records, &mut points);
            let BrickBounds { center, half_extents } = brick_view.bounds(brick);
            let mut farthest = [0.0_f64; 3];
            for (&record, &point) in records.iter().zip(&points) {
                let coords = list.voxel_coords(brick, record).map(|c| c as f64);
                let expected = view_from_index.transform(DVec3::from(coords));
                let difference = DVec3::from(point.map(f64::from)) - expected;
                assert!(difference.abs().max_element() < 7e-5 * longest_step, "{difference}");
                for axis in 0..3 {
                    let from_center = f64::from(point[axis]) - f64::from(center[axis]);
                    assert!(from_center.abs() <= f64::from(half_extents[axis]), "{from_center}");
                    farthest[axis] = farthest[axis].max(from_center.abs());
                }
            }
            for (farthest, half_extent) in farthest.into_iter().zip(half_extents) {
                let beyond = f64::from(half_extent) - farthest;
                assert!(beyond < 1e-3 * longest_step, "nothing comes near a face: {beyond}");
            }
        }
    }

    /// Bricks of cells, at the ends of a grid and within it, and the voxels that they hold.
    #[test]
    fn project_bounds_hold_all_levels() {
        for_each_seed(3, |mut rng| {
            let dims = [0; 3].map(|_| rng.usize(64..150));
            let grid = Grid::with_spacing(dims, [0; 3].map(|_| 0.5 + rng.f64())).unwrap();
            let eye = DVec3::from_array([0; 3].map(|_| 900.0 * (rng.f64() - 0.5)));
            let projection = Projection::Orthographic { view_height: 5.0 };
            let camera = Camera::new(eye, DVec3::ZERO, DVec3::new(0.1, 0.3, 1.0), projection);
            let view = View::new(&grid, &camera.unwrap(), &ImageDesc::default()).unwrap();
            let view_from_index = view.from_index(&grid);
            for level in 0..4 {
                let cells = grid.of_cells(level).unwrap();
                let bricks = BrickView::of_cells(&grid, level, &cells, &view);
                for _ in 0..100 {
                    let at = dims.map(|n| rng.usize(..n));
                    let brick_idx =
                        bricks.grid().brick_idx(at.map(|at| (at >> level) / BRICK_SIDE));
                    let brick = Brick { brick_idx, first: 0, n_voxels: 0 };
                    let [all, own] = [bricks.bounds_of_all_levels(&brick), bricks.bounds(&brick)];
                    let at = view_from_index.transform(DVec3::from_array(at.map(|at| at as f64)));
                    for axis in 0..3 {
                        let from_center = at[axis] - f64::from(all.center[axis]);
                        assert!(from_center.abs() <= f64::from(all.half_extents[axis]), "{level}");
                        let beyond = (own.center[axis] - all.center[axis]).abs();
                        assert!(beyond + own.half_extents[axis] <= all.half_extents[axis] + 1e-3);
                    }
                }
            }
        });
    }
}
