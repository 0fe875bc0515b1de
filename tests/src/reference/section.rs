//! Section weights on any grid (model §2, "Section", and §5 on minification).
//!
//! A section is computed as the model defines it: the integral of the kernel, a sphere in index space,
//! over the depths that lie in the slab, per `unit`.

use super::{Hierarchy, Kernel};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, ViewAxes};

/// A kernel as it lies in one view of a grid.
#[derive(Clone, Copy, Debug)]
pub struct KernelInView {
    kernel: Kernel,
    hierarchy: Hierarchy,
    unit: f64,
    /// Steps of one world unit to the right, upwards and forward, in index space.
    right_in_index: DVec3,
    up_in_index: DVec3,
    forward_in_index: DVec3,
    /// Half the kernel's extent in depth, in world units.
    pub depth_reach: f64,
    /// No point of the kernel is farther than this from its centre, in world units.
    pub reach: f64,
}

/// Which part of a kernel is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// All of it.
    Whole,
    /// What lies in a slab.
    Slab {
        /// Depth of the slab's front face in world units.
        front: f64,
        /// Its width in `unit`s.
        width: f64,
    },
}

impl KernelInView {
    /// `kernel` on `grid` as the view along `axes` sees it.
    pub fn new(kernel: Kernel, hierarchy: Hierarchy, grid: &Grid, axes: &ViewAxes) -> Self {
        let world_from_index = grid.world_from_index().matrix3;
        let index_from_world = world_from_index.inverse();
        // The depth of `A·q` is `f·A·q`, greatest over the sphere where `q` is along `Aᵀf`.
        let depth_reach = kernel.radius() * (world_from_index.transpose() * axes.forward).length();
        let frobenius_norm = DVec3::from_array(grid.spacing()).length();
        Self {
            kernel,
            hierarchy,
            unit: grid.unit(),
            right_in_index: index_from_world * axes.right,
            up_in_index: index_from_world * axes.up,
            forward_in_index: index_from_world * axes.forward,
            depth_reach,
            reach: kernel.radius() * frobenius_norm,
        }
    }

    /// The same on cells of voxels, by kernels that are thinner in depth by a factor.
    pub(super) fn on_cells(&self, cells: &Grid, axes: &ViewAxes, thinner: f64) -> Self {
        let on_cells = Self::new(self.kernel, self.hierarchy, cells, axes);
        Self {
            forward_in_index: on_cells.forward_in_index * thinner,
            depth_reach: on_cells.depth_reach / thinner,
            ..on_cells
        }
    }

    /// The kernel in index space.
    pub(super) fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// What a voxel at depth `center_depth` weighs at the ray that passes `offset` world units to the
    /// right of and above it.
    pub fn weight(&self, cut: Cut, offset: [f64; 2], center_depth: f64) -> f64 {
        match cut {
            Cut::Whole => self.integral(offset, [-self.depth_reach, self.depth_reach]),
            Cut::Slab { front, width } => {
                let front = (front - center_depth) / self.unit;
                let plain = |front: f64, width: f64| {
                    self.integral(offset, [front * self.unit, (front + width) * self.unit])
                };
                self.hierarchy.section(&plain, front, width)
            }
        }
    }

    /// `(1/unit) ∫ h dt` over depths measured from the voxel's centre.
    fn integral(&self, [x, y]: [f64; 2], depths: [f64; 2]) -> f64 {
        let start = x * self.right_in_index + y * self.up_in_index;
        self.kernel.line_integral(start, self.forward_in_index, depths) / self.unit
    }

    /// The same for a footprint stretched in the image plane by `stretch`: its weight still sums to
    /// the same over the image.
    pub fn stretched_weight(
        &self,
        cut: Cut,
        [x, y]: [f64; 2],
        center_depth: f64,
        stretch: f64,
    ) -> f64 {
        let offset = [x / stretch, y / stretch];
        self.weight(cut, offset, center_depth) / (stretch * stretch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::Normalization;
    use slabsplat_core::glam::{DAffine3, DMat3};

    const PLAIN: Hierarchy = Hierarchy { normalization: Normalization::None, base_width: 0.5 };

    fn view(columns: [DVec3; 3], kernel: Kernel) -> KernelInView {
        let matrix = DMat3::from_cols(columns[0], columns[1], columns[2]);
        let grid = Grid::new([3, 3, 3], DAffine3::from_mat3(matrix)).unwrap();
        let forward = DVec3::new(0.48, -0.6, 0.64);
        let right = forward.cross(DVec3::Y).normalize();
        let axes = ViewAxes { right, up: right.cross(forward), forward };
        KernelInView::new(kernel, PLAIN, &grid, &axes)
    }

    const CUBIC: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];
    const SHEARED: [DVec3; 3] =
        [DVec3::new(1.1, 0.0, 0.0), DVec3::new(0.5, 1.3, 0.1), DVec3::new(-0.2, 0.3, -2.0)];

    #[test]
    fn section_sums_to_whole_footprint() {
        for (columns, kernel) in [(CUBIC, Kernel::Gaussian), (SHEARED, Kernel::CrawfisMax)] {
            let view = view(columns, kernel);
            let offset = [0.3, -0.4];
            let whole = view.weight(Cut::Whole, offset, 7.0);
            let slab = |n: i32| Cut::Slab { front: 0.37 * view.unit * f64::from(n), width: 0.37 };
            let sum: f64 = (-20..60).map(|n| view.weight(slab(n), offset, 7.0)).sum();
            assert!((sum - whole).abs() < 1e-9, "{sum} {whole}");
        }
    }

    /// The integral of a section over the image plane is a volume integral: `det A · ∫h dV / unit`
    /// world units cubed, whatever the grid and the view.
    #[test]
    fn section_integrates_to_volume() {
        let step = 0.05;
        for columns in [CUBIC, SHEARED] {
            let view = view(columns, Kernel::CrawfisMax);
            let mut sum = 0.0;
            for (i, j) in (-90..90).flat_map(|i| (-90..90).map(move |j| (i, j))) {
                let offset = [f64::from(i) * step, f64::from(j) * step];
                sum += view.weight(Cut::Whole, offset, 0.0) * step * step;
            }
            let det = DMat3::from_cols(columns[0], columns[1], columns[2]).determinant().abs();
            let expected = det / view.unit;
            assert!((sum / expected - 1.0).abs() < 1e-4, "{sum} {expected}");
        }
    }

    #[test]
    fn section_on_cubic_grid_depends_on_distance_only() {
        let view = view(CUBIC.map(|c| 2.5 * c), Kernel::Gaussian);
        let cut = Cut::Slab { front: 1.0, width: 0.8 };
        let weights = [[1.5, 2.0], [2.5, 0.0], [0.0, -2.5]].map(|p| view.weight(cut, p, 0.5));
        assert!((weights[0] - weights[1]).abs() < 1e-14 && (weights[0] - weights[2]).abs() < 1e-14);
        // The spacing cancels: per unit, the section is that of the grid of unit spacing.
        let unit_grid = Kernel::Gaussian.line_integral(DVec3::X, DVec3::Z, [0.2, 1.0]);
        assert!((weights[1] - unit_grid).abs() < 1e-14, "{weights:?} {unit_grid}");
    }

    #[test]
    fn section_reach_bounds_the_kernel() {
        let view = view(SHEARED, Kernel::Gaussian);
        for angle in 0..360 {
            let (sin, cos) = f64::from(angle).to_radians().sin_cos();
            let offset = [1.001 * view.reach * cos, 1.001 * view.reach * sin];
            assert_eq!(view.weight(Cut::Whole, offset, 0.0), 0.0);
        }
        let behind = Cut::Slab { front: 1.001 * view.depth_reach, width: 9.0 };
        assert_eq!(view.weight(behind, [0.1, 0.1], 0.0), 0.0);
    }

    #[test]
    fn section_stretch_keeps_the_sum() {
        let view = view(CUBIC, Kernel::Gaussian);
        let cut = Cut::Slab { front: -0.2, width: 1.0 };
        let sum = |stretch: f64| -> f64 {
            let steps = || (-120..=120).map(|i| f64::from(i) * 0.1);
            let at = |x, y| view.stretched_weight(cut, [x, y], 0.0, stretch) * 0.01;
            steps().map(|x| steps().map(|y| at(x, y)).sum::<f64>()).sum()
        };
        assert!((sum(1.0) - sum(3.0)).abs() < 1e-3, "{} {}", sum(1.0), sum(3.0));
    }
}
