//! How far a voxel may be from another whose value it shares a pixel with.

use super::rays::Rays;
use crate::footprints::raster::Raster;
use slabsplat_backend::LayerPlan;
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{Grid, SlabGrid};
use std::ops::RangeInclusive;

/// The steps between voxels of which the one makes something show at a point, and the other adds to a density
/// there or to one of those that its gradient is taken from.
///
/// The way from one to the other leads from a voxel to a point within its kernel, along the slab, to the
/// next pixel and some sheets on, and to a voxel within whose kernel that is: through two balls of index
/// space, and along three lines of the world. What depends on the view is bounded for all directions, so
/// that turning the camera leaves the selection as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reach {
    /// The most steps along each axis.
    pub(super) margin: [usize; 3],
    /// An ellipsoid, `x·form·x ≤ 1`, that holds all steps. The box of `margin` is twice as large.
    pub(super) form: DMat3,
}

/// Steps of which only the first component differs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) x: RangeInclusive<isize>,
    pub(super) y: isize,
    pub(super) z: isize,
}

/// Kernels are tossed by rounded positions; a hundredth is far more than the rounding.
const ROUNDING: f64 = 0.01;

/// From a sheet that makes something show between the two behind it, to the second one behind these, which
/// the slope at the last of them is taken from.
const FARTHEST_SHEET: f64 = 4.0;

/// As far as it matters: the outer ones of these sheets count for a tenth in a slope, and for a 24th in what
/// shows.
const FARTHEST_TO_MATTER: f64 = 2.0;

/// Parts of a voxel's shortest step in which lengths are counted that depend on the view, lest the selection
/// be another in every frame.
const PARTS: f64 = 16.0;

/// Rows of a box, at most, whose ellipsoid is looked for: every row of a volume is joined from as many. Where
/// a picture is so small that voxels reach further, nearly all of them do.
const MOST_ROWS: isize = 1000;

impl Reach {
    /// None but the voxel itself.
    #[cfg(test)]
    pub(super) fn none() -> Self {
        Self { margin: [0; 3], form: 1e6 * DMat3::IDENTITY }
    }

    /// For sheets as thick as `slabs`; of all that matters at all, if the picture shall be exact.
    pub(super) fn of(
        layer: &LayerPlan<'_>,
        raster: &Raster,
        slabs: &SlabGrid,
        is_exact: bool,
    ) -> Self {
        let grid = layer.volume.grid();
        let farthest = slabs.middle(slabs.n_slabs() - 1).max(raster.near.into());
        let scale = layer.view.pixels_per_world(farthest);
        let stretched = 2.0 * (layer.view.stretch(scale) - 1.0) * layer.radius * longest(grid);
        let n_sheets = if is_exact { FARTHEST_SHEET } else { FARTHEST_TO_MATTER };
        let step = n_sheets * slabs.thickness() * slant(layer) + 1.0 / scale;
        let parts = PARTS * (slabs.thickness() + step + stretched) / grid.unit();
        let length = parts.ceil() * grid.unit() / PARTS;
        let in_index = grid.index_from_world().matrix3;
        Self::new(2.0 * layer.radius + ROUNDING, length, &in_index, grid.dims())
    }

    /// Of a way of up to `radius` index units and `length` world units.
    fn new(radius: f64, length: f64, index_from_world: &DMat3, dims: [usize; 3]) -> Self {
        let per_world = [0, 1, 2].map(|axis| index_from_world.row(axis).length());
        let margin = [0, 1, 2].map(|axis| {
            let margin = radius + length * per_world[axis];
            (margin as usize).min(dims[axis])
        });
        // Of the ellipsoids around the sum of a ball and an ellipsoid, `x·Q⁻¹·x ≤ 1`, that of the least
        // trace: https://doi.org/10.1007/978-1-4612-0277-6, section 2.2.
        let ball = DMat3::from_diagonal(DVec3::splat(radius * radius));
        let lines = *index_from_world * length;
        let lines = lines * lines.transpose();
        let ratio = (trace(&ball) / trace(&lines)).sqrt();
        let form = (ball * (1.0 + 1.0 / ratio) + lines * (1.0 + ratio)).inverse();
        Self { margin, form }
    }

    /// Rows of the steps within the ellipsoid, of which those that go equally far follow each other; none if
    /// there would be too many.
    pub(super) fn rows(&self) -> Vec<Row> {
        let [x_end, y_end, z_end] = self.margin.map(|steps| steps as isize);
        let n_rows = (2 * y_end).saturating_add(1).saturating_mul((2 * z_end).saturating_add(1));
        if MOST_ROWS < n_rows {
            return Vec::new();
        }
        let rows = (-z_end..=z_end).flat_map(|z| (-y_end..=y_end).map(move |y| (z, y)));
        let row = |(z, y)| {
            // Of next to flat voxels, the ellipsoid may be as long as one likes, and the grid is not.
            let x = steps_along_x(&self.form, y, z)?;
            let x = -x_end.min(-*x.start())..=x_end.min(*x.end());
            (!x.is_empty()).then_some(Row { x, y, z })
        };
        let mut rows: Vec<Row> = rows.filter_map(row).collect();
        rows.sort_by_key(|row| (*row.x.start(), *row.x.end()));
        rows
    }
}

/// The steps `x` within an ellipsoid at `y` and `z`, if there are any.
fn steps_along_x(form: &DMat3, y: isize, z: isize) -> Option<RangeInclusive<isize>> {
    let rest = DVec3::new(0.0, y as f64, z as f64);
    let across = *form * rest;
    let [a, half_b, c] = [form.x_axis.x, across.x, rest.dot(across) - 1.0];
    let squared = half_b * half_b - a * c;
    // The rounding of the squares is far less than what kernels have more than they need.
    let half = (0.0 <= squared).then(|| squared.sqrt() / a)?;
    let middle = -half_b / a;
    let x = (middle - half).ceil() as isize..=(middle + half).floor() as isize;
    (!x.is_empty()).then_some(x)
}

fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// Length of the ray through a corner of the image over one unit of depth.
fn slant(layer: &LayerPlan<'_>) -> f64 {
    let per_depth = Rays::new(&layer.view, 0).right_per_depth;
    let [width, height] = layer.view.image_size().map(f64::from);
    DVec3::new(0.5 * width * per_depth, 0.5 * height * per_depth, 1.0).length()
}

/// How long a step of length 1 in index space may be in the world, at most.
fn longest(grid: &Grid) -> f64 {
    DVec3::from_array(grid.spacing()).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    fn direction(rng: &mut fastrand::Rng) -> DVec3 {
        loop {
            let v = DVec3::from_array([0; 3].map(|_| 2.0 * rng.f64() - 1.0));
            if 0.01 < v.length() && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }

    fn holds(rows: &[Row], step: DVec3) -> bool {
        let [x, y, z] = step.to_array().map(|steps| steps as isize);
        rows.iter().any(|row| [row.y, row.z] == [y, z] && row.x.contains(&x))
    }

    /// Every step that is a way through a ball and along a line of the world, on grids however long or
    /// sheared.
    #[test]
    fn reach_has_all_steps() {
        for_each_seed(1, |mut rng| {
            let mut n_steps = 0;
            for _ in 0..100 {
                let mut column = || direction(&mut rng) * (0.2 + 2.0 * rng.f64());
                let matrix = DMat3::from_cols(column(), column(), column());
                let (radius, length) = (0.5 + 4.0 * rng.f64(), 0.1 + 3.0 * rng.f64());
                let reach = Reach::new(radius, length, &matrix, [99; 3]);
                let rows = reach.rows();
                if rows.is_empty() {
                    continue;
                }
                for _ in 0..200 {
                    let line = matrix * direction(&mut rng) * length;
                    let step = (line + radius * direction(&mut rng)).round();
                    if (step - line).length() <= radius {
                        assert!(holds(&rows, step), "{step}: {radius}, {length}, {matrix}");
                        n_steps += 1;
                    }
                }
            }
            assert!(5000 < n_steps, "{n_steps}");
        });
    }

    /// On a cubic grid it is a ball, of half the volume of its box.
    #[test]
    fn reach_is_a_ball() {
        let reach = Reach::new(4.0, 2.0, &DMat3::IDENTITY, [99; 3]);
        let n_steps: usize = reach.rows().iter().map(|row| row.x.clone().count()).sum();
        let is_within = |x: i32, y: i32, z: i32| x * x + y * y + z * z <= 36;
        let all =
            (-6..=6).flat_map(|z| (-6..=6).flat_map(move |y| (-6..=6).map(move |x| (x, y, z))));
        assert_eq!(n_steps, all.filter(|&(x, y, z)| is_within(x, y, z)).count());
        assert_eq!(reach.margin, [6; 3]);
    }

    /// Voxels so flat that they reach further than the grid is long: a row of bits as long as that was asked
    /// for once.
    #[test]
    fn reach_ends_with_the_grid() {
        let flat = DMat3::from_diagonal(DVec3::new(1e8, 0.1, 0.1));
        let rows = Reach::new(4.0, 2.0, &flat, [7; 3]).rows();
        assert!(!rows.is_empty() && rows.iter().all(|row| row.x == (-7..=7)), "{rows:?}");
    }

    /// However far voxels reach, the work is bounded.
    #[test]
    fn reach_has_few_rows() {
        for length in [20.0, 1e6, f64::INFINITY] {
            let reach = Reach::new(4.0, length, &DMat3::IDENTITY, [999; 3]);
            assert_eq!(reach.rows(), []);
        }
    }
}
