//! What is drawn in which sheet, by each of the three methods (model §4).

use super::sheet::MAX_OPACITY;
use super::view::View;
use super::{Cut, Hierarchy, Kernel, KernelInView, gradient_in_world, merge, shaded_color};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Compositing, Grid, Method, Scene, Volume};

/// All that the pixels of a picture have in common.
pub(super) struct Frame {
    pub(super) view: View,
    pub(super) kernel: KernelInView,
    pub(super) unit: f64,
    pub(super) compositing: Compositing,
    pub(super) background: [f64; 4],
    pub(super) voxels: Vec<Voxel>,
    /// From front to back.
    pub(super) sheets: Vec<Sheet>,
}

/// A voxel whose opacity is above 0.
pub(super) struct Voxel {
    coords: [usize; 3],
    pub(super) center_in_view: DVec3,
    pub(super) opacity: f64,
    pub(super) color: [f64; 3],
}

/// Voxels whose sections are added up before they are composited.
pub(super) struct Sheet {
    pub(super) splats: Vec<SheetSplat>,
    /// Where rays meet its footprints; `None` where each is met at its voxel's own depth.
    pub(super) plane_depth: Option<f64>,
}

/// What a sheet has of a voxel.
#[derive(Clone, Copy)]
pub(super) struct SheetSplat {
    /// Index into [`Frame::voxels`].
    pub(super) voxel_idx: usize,
    pub(super) cut: Cut,
}

/// Depths that differ by less than this many `unit`s count as equal in `every-sample`.
const DEPTH_STEP: f64 = 1.0 / (1 << 20) as f64;

impl Voxel {
    /// `μ`.
    pub(super) fn extinction(&self) -> f64 {
        -(1.0 - self.opacity.min(MAX_OPACITY)).ln()
    }
}

impl Frame {
    /// The exact picture, or what `tolerance` makes of it.
    pub(super) fn new(volume: &Volume, scene: &Scene, tolerance: f64) -> Self {
        let (grid, settings) = (volume.grid(), &scene.settings);
        let view = View::new(&scene.camera, &scene.image);
        let hierarchy = Hierarchy {
            normalization: settings.normalization,
            base_width: settings.base_slab_width,
        };
        let kernel = Kernel::named(&settings.kernel);
        let mut frame = Self {
            view,
            kernel: KernelInView::new(kernel, hierarchy, grid, &view.axes),
            unit: grid.unit(),
            compositing: settings.compositing,
            background: scene.image.background.map(f64::from),
            voxels: visible_voxels(volume, scene, &view),
            sheets: Vec::new(),
        };
        frame.sheets = match settings.method {
            Method::ImageAligned if merge::applies(settings, tolerance) => {
                merge::merged_slabs(&frame, grid, settings, tolerance)
            }
            Method::ImageAligned => frame.slabs(grid, settings.slab_width),
            Method::AxisAligned => frame.slices(grid),
            Method::EverySample => frame.single_voxels(grid),
            Method::PostClassified => panic!("its sheets hold densities: see `density`"),
        };
        frame
    }

    /// Slabs `n` from `z_c + n·w·unit`, as far as there are voxels.
    fn slabs(&self, grid: &Grid, width: f64) -> Vec<Sheet> {
        let center_depth = self.view.view_from_world(grid.center_in_world()).z;
        let world_width = width * self.unit;
        let slab_at = |depth: f64| ((depth - center_depth) / world_width).floor();
        let depths = || self.voxels.iter().map(|v| v.center_in_view.z);
        let nearest = depths().fold(f64::INFINITY, f64::min) - self.kernel.depth_reach;
        let farthest = depths().fold(f64::NEG_INFINITY, f64::max) + self.kernel.depth_reach;
        if self.voxels.is_empty() {
            return Vec::new();
        }
        let slab_numbers = slab_at(nearest) as i64..=slab_at(farthest) as i64;
        let slabs = slab_numbers.filter_map(|n| {
            let front = center_depth + n as f64 * world_width;
            let middle = front + 0.5 * world_width;
            if !self.view.draws_slab(front, front + world_width, self.unit) {
                return None;
            }
            let reach = self.kernel.depth_reach + 0.5 * world_width;
            let meets = |&i: &usize| (self.voxels[i].center_in_view.z - middle).abs() <= reach;
            let cut = Cut::Slab { front, width };
            let voxels = (0..self.voxels.len()).filter(meets);
            let splats = voxels.map(|voxel_idx| SheetSplat { voxel_idx, cut }).collect();
            Some(Sheet { splats, plane_depth: Some(middle) })
        });
        slabs.collect()
    }

    /// The grid's slices along the axis most parallel to the view.
    fn slices(&self, grid: &Grid) -> Vec<Sheet> {
        let steps = grid.world_from_index().matrix3;
        let cosines = [steps.x_axis, steps.y_axis, steps.z_axis]
            .map(|step| step.normalize().dot(self.view.axes.forward));
        let mut axis = 0;
        for other in 1..3 {
            if cosines[axis].abs() < cosines[other].abs() {
                axis = other;
            }
        }
        let mut slice_numbers: Vec<usize> = (0..grid.dims()[axis]).collect();
        if cosines[axis] < 0.0 {
            slice_numbers.reverse();
        }
        let in_slice = |slice: usize| {
            self.drawn_whole().filter(|&i| self.voxels[i].coords[axis] == slice).collect()
        };
        slice_numbers.into_iter().map(|slice| whole_footprints(in_slice(slice))).collect()
    }

    /// Voxels by depth; those at one depth from the bottom to the top and from left to right.
    fn single_voxels(&self, grid: &Grid) -> Vec<Sheet> {
        let center = self.view.view_from_world(grid.center_in_world());
        let rounded = |i: usize| {
            let steps = (self.voxels[i].center_in_view - center) / (self.unit * DEPTH_STEP);
            let [x, y, z] = steps.to_array().map(|v| v.round() as i64);
            [z, y, x]
        };
        let mut order: Vec<usize> = self.drawn_whole().collect();
        order.sort_by_key(|&i| rounded(i));
        order.into_iter().map(|i| whole_footprints(vec![i])).collect()
    }

    /// The voxels that are not before the near depth.
    fn drawn_whole(&self) -> impl Iterator<Item = usize> {
        let near_depth = self.view.near_depth(self.unit);
        (0..self.voxels.len()).filter(move |&i| near_depth <= self.voxels[i].center_in_view.z)
    }
}

fn whole_footprints(voxel_indices: Vec<usize>) -> Sheet {
    let splat = |voxel_idx| SheetSplat { voxel_idx, cut: Cut::Whole };
    Sheet { splats: voxel_indices.into_iter().map(splat).collect(), plane_depth: None }
}

fn visible_voxels(volume: &Volume, scene: &Scene, view: &View) -> Vec<Voxel> {
    let grid = volume.grid();
    let voxel = |voxel_idx: usize| {
        let value = volume.value(voxel_idx);
        let opacity = scene.transfer.opacity(value);
        if value.is_nan() || opacity <= 0.0 {
            return None;
        }
        let coords = grid.voxel_coords(voxel_idx);
        let center_in_index = DVec3::from_array(coords.map(|c| c as f64));
        let center_in_world = grid.world_from_index().transform_point3(center_in_index);
        let gradient = gradient_in_world(volume, coords);
        let color = scene.transfer.color(value);
        Some(Voxel {
            coords,
            center_in_view: view.view_from_world(center_in_world),
            opacity,
            color: shaded_color(&scene.shading, color, gradient, view.axes.forward),
        })
    };
    (0..grid.n_voxels()).filter_map(voxel).collect()
}
