//! How a grid's matrix and a view make the kernel's ball an ellipsoid: the paper's future work on
//! grids of unequal scaling (§7), without resampled slices.
//!
//! In index space the kernel stays a ball and the rays get a new direction and a new length, so one
//! radial table serves every grid. Slab faces may then cut the rays obliquely: *tilt* says how the
//! offset of the cut changes over the footprint. Model §2 has the two forms.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, ViewAxes};

/// A kernel of radius 1 in index space, as the view sees it. World units throughout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootprintShape {
    /// `κ`: index-space length of a ray over one `unit` of depth.
    pub kappa: f64,
    /// `|d|`: index-space length of a ray over one world unit of depth.
    pub index_per_depth: f64,
    /// `ρ² = across·(X + shear·Y)² + along·Y²` at `X` to the right and `Y` above the centre. Of a kernel that
    /// is long and thin, `along` as a difference would have no digit left, and might be negative.
    pub across: f64,
    /// See [`across`](Self::across).
    pub shear: f64,
    /// See [`across`](Self::across).
    pub along: f64,
    /// `p·d̂ = tilt[0]·X + tilt[1]·Y`: by how much a slab face is cut later than at the centre.
    pub tilt: [f64; 2],
    /// Half the width and half the height of the ellipsoid.
    pub half_extent: [f64; 2],
    /// Half the ellipsoid's thickness along the viewing direction.
    pub half_depth: f64,
    /// `X` and `Y` of the ellipsoid's farthest point. Its nearest is as far on the other side.
    pub farthest: [f64; 2],
}

/// Offsets that differ by less than this over a footprint read the same section.
const NEGLIGIBLE_TILT: f64 = 1e-5;

impl FootprintShape {
    /// The shape of the kernels of `grid` seen along `axes`.
    pub fn new(grid: &Grid, axes: &ViewAxes) -> Self {
        let index_from_world = grid.index_from_world().matrix3;
        let [right, up, ray] =
            [axes.right, axes.up, axes.forward].map(|axis| index_from_world * axis);
        let along = ray.normalize();
        let across = |p: DVec3| p - along * p.dot(along);
        let (across_right, across_up) = (across(right), across(up));
        let index_from_view = grid.world_from_index().matrix3.transpose();
        let [wide, high, deep] =
            [axes.right, axes.up, axes.forward].map(|axis| index_from_view * axis);
        Self {
            kappa: grid.unit() * ray.length(),
            index_per_depth: ray.length(),
            across: across_right.length_squared(),
            shear: across_right.dot(across_up) / across_right.length_squared(),
            along: across_right.cross(across_up).length_squared() / across_right.length_squared(),
            tilt: [right.dot(along), up.dot(along)],
            half_extent: [wide.length(), high.length()],
            half_depth: deep.length(),
            farthest: [wide, high].map(|axis| axis.dot(deep) / deep.length()),
        }
    }

    /// The same of kernels that are thinner in depth by a factor: nothing changes in the image plane, but
    /// that there is as much less of them.
    #[must_use]
    pub fn thinner(self, factor: f64) -> Self {
        Self {
            kappa: self.kappa * factor,
            index_per_depth: self.index_per_depth * factor,
            half_depth: self.half_depth / factor,
            ..self
        }
    }

    /// Whether the axes of footprints are not those of the image. A cubic grid has upright circles, up to
    /// rounding errors.
    pub fn is_sheared(&self) -> bool {
        1e-9 < self.shear.abs() * (self.across / self.along).sqrt()
    }

    /// Whether slab faces cut the rays at different offsets within a footprint of `radius`.
    pub fn is_tilted(&self, radius: f64) -> bool {
        let [x, y] = self.tilt;
        let [half_width, half_height] = self.half_extent;
        NEGLIGIBLE_TILT < radius * (x.abs() * half_width + y.abs() * half_height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::{DAffine3, DMat3, DQuat};
    use slabsplat_core::{Camera, Projection};

    fn axes(eye: DVec3) -> ViewAxes {
        let projection = Projection::Orthographic { view_height: 1.0 };
        Camera::new(eye, DVec3::ZERO, DVec3::new(0.1, 1.0, 0.2), projection).unwrap().axes()
    }

    fn sheared() -> Grid {
        let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::ONE.normalize(), 0.4));
        let shear = DMat3::from_cols(
            DVec3::new(1.0, 0.0, 0.0),
            DVec3::new(0.3, 1.2, 0.0),
            DVec3::new(-0.2, 0.1, -2.0),
        );
        Grid::new([5, 5, 5], DAffine3::from_mat3(turn * shear)).unwrap()
    }

    #[test]
    fn footprint_shape_of_cubic_grid_is_a_disc() {
        let grid = Grid::with_spacing([4; 3], [0.5; 3]).unwrap();
        let shape = FootprintShape::new(&grid, &axes(DVec3::new(3.0, 1.0, 2.0)));
        assert!((shape.kappa - 1.0).abs() < 1e-12);
        assert!((shape.across - 4.0).abs() < 1e-12 && (shape.along - 4.0).abs() < 1e-12);
        assert!(shape.shear.abs() < 1e-12);
        assert!(!shape.is_tilted(2.0));
        assert!((shape.half_depth - 0.5).abs() < 1e-12);
    }

    /// As if the grid's steps along the ray were as much shorter.
    #[test]
    fn footprint_shape_of_thinner_kernels() {
        let axes = axes(DVec3::new(2.0, -1.0, 3.0));
        let thin = FootprintShape::new(&sheared(), &axes).thinner(4.0);
        let world_from_index = sheared().world_from_index().matrix3;
        let along_ray = |v: DVec3| axes.forward * axes.forward.dot(v);
        let squeezed = |v: DVec3| v - 0.75 * along_ray(v);
        let columns = [0, 1, 2].map(|axis| squeezed(world_from_index.col(axis)));
        let squeezed = DMat3::from_cols(columns[0], columns[1], columns[2]);
        let grid = Grid::new([5; 3], DAffine3::from_mat3(squeezed)).unwrap();
        let expected = FootprintShape::new(&grid, &axes);
        let units = grid.unit() / sheared().unit();
        let pairs = [
            (thin.kappa * units, expected.kappa),
            (thin.index_per_depth, expected.index_per_depth),
            (thin.across, expected.across),
            (thin.shear, expected.shear),
            (thin.along, expected.along),
            (thin.tilt[0], expected.tilt[0]),
            (thin.tilt[1], expected.tilt[1]),
            (thin.half_extent[0], expected.half_extent[0]),
            (thin.half_extent[1], expected.half_extent[1]),
            (thin.half_depth, expected.half_depth),
        ];
        for (actual, expected) in pairs {
            assert!((actual - expected).abs() < 1e-12, "{pairs:?}");
        }
    }

    /// What counts is how far a shear moves the rim of a footprint, in widths of it.
    #[test]
    fn footprint_shape_of_turned_grid_is_sheared() {
        let is_sheared = |spacing: [f64; 3], roll: f64| {
            let grid = Grid::with_spacing([4; 3], spacing).unwrap();
            let projection = Projection::Orthographic { view_height: 1.0 };
            let up = DVec3::new(roll, 1.0, 0.0);
            let camera = Camera::new(DVec3::Z, DVec3::ZERO, up, projection).unwrap();
            FootprintShape::new(&grid, &camera.axes()).is_sheared()
        };
        assert!(!is_sheared([1.0, 2.0, 3.0], 0.0));
        assert!(is_sheared([1.0, 2.0, 3.0], 0.3) && is_sheared([1.0, 2.0, 3.0], -0.3));
        assert!(is_sheared([1e-6, 1.0, 1.0], 1e-10), "a ten thousandth of the width");
        assert!(!is_sheared([1.0, 1.1, 1.0], 1e-10));
        let aside = axes(DVec3::new(3.0, 1.0, 2.0));
        let cubic = Grid::with_spacing([4; 3], [1e-6; 3]).unwrap();
        assert!(!FootprintShape::new(&cubic, &aside).is_sheared());
        assert!(FootprintShape::new(&sheared(), &aside).is_sheared());
    }

    #[test]
    fn footprint_shape_is_tilted_by_what_its_extent_makes_of_a_tilt() {
        let grid = Grid::with_spacing([4; 3], [1.0; 3]).unwrap();
        let upright = FootprintShape::new(&grid, &axes(DVec3::X));
        let check = |tilt: [f64; 2], half_extent: [f64; 2], expected: bool| {
            for [tilt, half_extent] in [[tilt, half_extent], [tilt, half_extent].map(swapped)] {
                let shape = FootprintShape { tilt, half_extent, ..upright };
                assert_eq!(shape.is_tilted(2.0), expected, "{tilt:?} {half_extent:?}");
            }
        };
        check([0.1, 0.0], [1e-4, 9.0], true);
        check([-0.1, 0.0], [1e-4, 9.0], true);
        check([0.1, 0.0], [1e-5, 9.0], false);
        check([0.1, 0.1], [4e-5, 4e-5], true);
    }

    fn swapped([a, b]: [f64; 2]) -> [f64; 2] {
        [b, a]
    }

    /// Both forms against their definition: the distance of a ray from the origin in index space,
    /// and where on the ray its nearest point is.
    #[test]
    fn footprint_shape_measures_rays_in_index_space() {
        let (grid, axes) = (sheared(), axes(DVec3::new(2.0, -1.0, 3.0)));
        let shape = FootprintShape::new(&grid, &axes);
        assert!(shape.is_tilted(2.0));
        let index_from_world = grid.index_from_world().matrix3;
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (-0.7, 2.1)] {
            let through = index_from_world * (axes.right * x + axes.up * y);
            let step = index_from_world * axes.forward;
            let t = -through.dot(step) / step.length_squared();
            let nearest = through + step * t;
            let u = x + shape.shear * y;
            let rho_squared = shape.across * u * u + shape.along * y * y;
            assert!((rho_squared - nearest.length_squared()).abs() < 1e-12);
            let offset = shape.tilt[0] * x + shape.tilt[1] * y;
            assert!((offset + t * shape.index_per_depth).abs() < 1e-12);
        }
    }

    /// The extents, against points all over the ellipsoid.
    #[test]
    fn footprint_shape_bounds_the_ellipsoid() {
        let (grid, axes) = (sheared(), axes(DVec3::new(2.0, -1.0, 3.0)));
        let shape = FootprintShape::new(&grid, &axes);
        let (mut largest, mut farthest) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..200 {
            for j in 0..400 {
                let (polar, azimuth) = (f64::from(i) / 200.0, f64::from(j) / 400.0);
                let (polar, azimuth) =
                    (polar * std::f64::consts::PI, azimuth * std::f64::consts::TAU);
                let on_ball = DVec3::new(
                    polar.sin() * azimuth.cos(),
                    polar.sin() * azimuth.sin(),
                    polar.cos(),
                );
                let at = grid.world_from_index().matrix3 * on_ball;
                let in_view = DVec3::new(at.dot(axes.right), at.dot(axes.up), at.dot(axes.forward));
                largest = largest.max(in_view.abs());
                if farthest.z < in_view.z {
                    farthest = in_view;
                }
            }
        }
        let [half_width, half_height] = shape.half_extent;
        let bounds = DVec3::new(half_width, half_height, shape.half_depth);
        assert!(
            (bounds - largest).max_element() < 2e-3 && -1e-12 < (bounds - largest).min_element()
        );
        // Where depth is largest it hardly changes from one of these points to the next.
        let [x, y] = shape.farthest;
        assert!((farthest.x - x).abs() < 0.03 && (farthest.y - y).abs() < 0.03, "{farthest}");
        assert!(0.1 < x.hypot(y), "the farthest point is not in the middle");
    }
}
