//! The slabs of a frame, and how they lie to kernels and to the eye.

use crate::PlanError;
use slabsplat_core::{Grid, SlabGrid, TooManySlabs, View};

/// Most slabs that a kernel may be deep, as seen along the longest voxel step. In a cubic grid it is four
/// slabs of a step's width, eight of densities; the bound has room for needles that are a thousand times as
/// long as they are thick. The work of a voxel grows with it.
pub(crate) const MAX_SLABS_OF_A_KERNEL: f64 = 8192.0;

/// The slabs of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Slabs {
    /// Where they are.
    pub grid: SlabGrid,
    /// The first slab whose sections are drawn: those before it lie before the near depth.
    pub first_drawn: usize,
    /// How many slabs before a slab the voxels may start whose sections it holds: a kernel that is k slabs
    /// thick meets up to ⌈k⌉ + 1 of them.
    pub n_before: usize,
}

/// The depths that a layer has a part in.
pub(crate) struct Depths {
    /// The nearest and the farthest of its voxels, from the centre of all layers.
    pub(crate) of_voxels: [f64; 2],
    /// Half the thickness of their kernels, in world units.
    pub(crate) half_depth: f64,
}

impl Depths {
    /// The slabs of that thickness, in world units, that all kernels of these depths meet.
    pub(crate) fn slabs<'a>(
        all: impl Iterator<Item = &'a Self>,
        thickness: f64,
    ) -> Result<SlabGrid, TooManySlabs> {
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for Self { of_voxels: [near, far], half_depth } in all {
            ends = [ends[0].min(near - half_depth), ends[1].max(far + half_depth)];
        }
        SlabGrid::covering(ends, thickness)
    }

    /// How a layer of these depths lies in the slabs of all.
    pub(crate) fn in_slabs(&self, slabs: &SlabGrid, view: &View) -> Slabs {
        // As backends round it: a kernel of a cubic grid is as thick from everywhere, up to rounding errors.
        let n_met = 2.0 * f64::from(self.half_depth as f32) / slabs.thickness();
        Slabs {
            grid: *slabs,
            first_drawn: first_drawn(view, slabs),
            n_before: (n_met.ceil() as usize).min(slabs.n_slabs()),
        }
    }
}

/// Refuses kernels that slabs of `thickness` world units would cut into sections without end. It does not
/// depend on the view, as a camera that turns must not meet an error on its way. That thickness comes of the
/// setting `slab_width`.
pub(crate) fn check_sections(
    grid: &Grid,
    radius: f64,
    thickness: f64,
    slab_width: f64,
) -> Result<(), PlanError> {
    let [x, y, z] = grid.spacing();
    let n_slabs = 2.0 * radius * x.max(y).max(z) / thickness;
    if n_slabs <= MAX_SLABS_OF_A_KERNEL {
        return Ok(());
    }
    let wide_enough = slab_width * n_slabs / MAX_SLABS_OF_A_KERNEL;
    Err(PlanError::TooManySections {
        spacing: format!("{x} x {y} x {z}"),
        n_slabs,
        // As it is written it must be enough, too.
        wide_enough: (100.0 * wide_enough).ceil() / 100.0,
    })
}

/// Slabs are drawn from one on.
fn first_drawn(view: &View, slabs: &SlabGrid) -> usize {
    let (mut lo, mut hi) = (0, slabs.n_slabs());
    while lo < hi {
        let middle = lo.midpoint(hi);
        if view.draws_slab(slabs.faces(middle)) {
            hi = middle;
        } else {
            lo = middle + 1;
        }
    }
    lo
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{Camera, ImageDesc, Projection};

    /// Eleven voxels of a cubic grid on the axis that the camera looks along, the middle one at depth 0.
    fn row_of_voxels(spacing: f64) -> Grid {
        Grid::with_spacing([1, 1, 11], [spacing; 3]).unwrap()
    }

    fn slabs_of(grid: &Grid, view: &View, half_depth: f64, width: f64) -> Slabs {
        let of_voxels = view.from_index(grid).depth_range(grid);
        let depths = Depths { of_voxels, half_depth };
        let slabs = Depths::slabs([&depths].into_iter(), width * grid.unit()).unwrap();
        depths.in_slabs(&slabs, view)
    }

    fn view(grid: &Grid, distance: f64, projection: Projection) -> View {
        let [eye, up] = [DVec3::Z * distance, DVec3::Y];
        let camera = Camera::new(eye, DVec3::ZERO, up, projection).unwrap();
        let image = ImageDesc::new(8, 8);
        View::new(grid, &camera, &image).unwrap()
    }

    #[test]
    fn slabs_cover_all_kernels() {
        for (spacing, width, n_before) in
            [(1.0, 1.0, 4), (3.0, 1.0, 4), (0.5, 1.6, 3), (1.0, 9.0, 1)]
        {
            let grid = row_of_voxels(spacing);
            let view = view(&grid, 99.0, Projection::Orthographic { view_height: 8.0 });
            let slabs = slabs_of(&grid, &view, 2.0 * spacing, width);
            assert_eq!(slabs.n_before, n_before, "{spacing} {width}");
            assert_eq!(slabs.grid.thickness(), spacing * width);
            let [first, last] = [0, slabs.grid.n_slabs() - 1].map(|slab| slabs.grid.faces(slab));
            let end = 7.0 * spacing;
            assert!(first[0] <= -end && -end < first[1], "{spacing} {width}: {first:?}");
            assert!(last[0] < end && end <= last[1], "{spacing} {width}: {last:?}");
        }
    }

    /// From before all slabs, through all of them, to behind them.
    #[test]
    fn slabs_are_drawn_from_the_near_depth_on() {
        let grid = row_of_voxels(1.0);
        let perspective = Projection::Perspective { fov_y_radians: 0.8 };
        let orthographic = Projection::Orthographic { view_height: 8.0 };
        for projection in [orthographic, perspective] {
            let mut firsts = Vec::new();
            for step in 1..60 {
                let view = view(&grid, 0.25 * f64::from(step), projection);
                let Slabs { grid: slabs, first_drawn, .. } = slabs_of(&grid, &view, 2.0, 0.7);
                for slab in 0..slabs.n_slabs() {
                    assert_eq!(view.draws_slab(slabs.faces(slab)), first_drawn <= slab, "{step}");
                }
                firsts.push(first_drawn);
            }
            assert!(firsts.is_sorted_by(|a, b| b <= a) && firsts[0] > 9, "{firsts:?}");
            assert_eq!(firsts.last(), Some(&0), "{firsts:?}");
        }
    }
}
