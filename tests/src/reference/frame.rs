//! What is drawn in which sheet, by each of the three methods (model §4).

use super::cells::{self, Stretch};
use super::region::normal_by_faces;
use super::sheet::weight;
use super::slabs::{Slabs, SplatsBySlab};
use super::view::View;
use super::{
    Cut, Hierarchy, Kernel, KernelInView, gradient_in_world, gradient_length, merge, shaded_color,
};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    ColorSamples, Compositing, Grid, LabelStyle, Layer, Light, Method, Region, Scene, VoxelColors,
};

/// All that the pixels of a picture have in common.
pub(super) struct Frame {
    pub(super) view: View,
    pub(super) compositing: Compositing,
    pub(super) background: [f64; 4],
    pub(super) layers: Vec<LayerInView>,
    /// From front to back.
    pub(super) sheets: Vec<Sheet>,
}

/// A layer as the camera sees it.
pub(super) struct LayerInView {
    pub(super) grid: Grid,
    pub(super) unit: f64,
    pub(super) stretch: Stretch,
    pub(super) kernel: KernelInView,
    pub(super) voxels: Vec<Voxel>,
    pub(super) region: Region,
    /// Whether a slab may be split: by the region, or where a mesh ends rays.
    pub(super) is_cut: bool,
}

/// A voxel whose opacity is above 0.
pub(super) struct Voxel {
    pub(super) coords: [usize; 3],
    pub(super) center_in_view: DVec3,
    pub(super) opacity: f64,
    pub(super) color: [f64; 3],
    /// What it is before light, and which way it faces.
    pub(super) unlit: [f64; 3],
    pub(super) normal: DVec3,
}

/// Voxels whose sections are added up before they are composited.
pub(super) struct Sheet {
    /// Of each layer.
    pub(super) splats: Vec<Vec<SheetSplat>>,
    /// Depths of the slab's faces. Rays meet its footprints half way between; `None` where each is met at its
    /// voxel's own depth.
    pub(super) faces: Option<[f64; 2]>,
}

/// What a sheet has of a voxel.
#[derive(Clone, Copy)]
pub(super) struct SheetSplat {
    /// Index into [`LayerInView::voxels`].
    pub(super) voxel_idx: usize,
    pub(super) cut: Cut,
}

/// Depths that differ by less than this many `unit`s count as equal in `every-sample`.
const DEPTH_STEP: f64 = 1.0 / (1 << 20) as f64;

impl Voxel {
    /// `μ`.
    pub(super) fn extinction(&self) -> f64 {
        weight(Compositing::Extinction, self.opacity)
    }
}

impl Frame {
    /// The exact picture, or what `tolerance` makes of it.
    pub(super) fn new(scene: &Scene, tolerance: f64) -> Self {
        let settings = &scene.settings;
        let view = View::new(&scene.camera, &scene.image);
        let slabs = Slabs::new(scene, &view);
        let in_view = |layer| LayerInView::new(layer, scene, &slabs, &view);
        let mut layers: Vec<LayerInView> = scene.layers.iter().map(in_view).collect();
        layers.iter_mut().for_each(|layer| layer.is_cut |= !scene.meshes.is_empty());
        let sheets = match settings.method {
            Method::ImageAligned if merge::applies(settings, tolerance) => {
                let tolerance = tolerance / layers.len() as f64;
                let of_scene = layers.into_iter().zip(&scene.layers);
                let light = |of: &Layer| (of.shading, scene.lights.clone());
                let drawn = |(layer, of)| cells::within(layer, &light(of), (&view, tolerance));
                layers = of_scene.flat_map(drawn).collect();
                let merged = |layer: &_| merge::merged_splats(layer, &slabs, &view, tolerance);
                slabs.sheets(&view, &layers, merged)
            }
            Method::ImageAligned => slabs.sheets(&view, &layers, |layer| layer.in_slabs(&slabs)),
            Method::AxisAligned => only(&layers).slices(&view),
            Method::EverySample => only(&layers).single_voxels(&view),
            Method::PostClassified => panic!("its sheets hold densities: see `density`"),
        };
        let background = scene.image.background.map(f64::from);
        let compositing =
            settings.mode.compositing().expect("one density has no sheets of colours");
        Self { view, compositing, background, layers, sheets }
    }
}

/// The layer of a method that draws one, all of it.
fn only(layers: &[LayerInView]) -> &LayerInView {
    let [layer] = layers else { panic!("sheets of {} layers are not defined", layers.len()) };
    assert!(layer.region.is_everywhere(), "its sheets are no slabs that a region could cut");
    layer
}

impl LayerInView {
    fn new(layer: &Layer, scene: &Scene, slabs: &Slabs, view: &View) -> Self {
        let settings = &scene.settings;
        let grid = *layer.volume.grid();
        let hierarchy = Hierarchy {
            normalization: settings.normalization,
            base_width: slabs.in_units_of(grid.unit(), settings.base_slab_width),
        };
        let kernel = Kernel::named(&settings.kernel);
        Self {
            grid,
            unit: grid.unit(),
            stretch: Stretch::of_voxels(grid.unit()),
            kernel: KernelInView::new(kernel, hierarchy, &grid, &view.axes),
            voxels: visible_voxels(layer, &scene.lights, view),
            region: layer.region.clone(),
            is_cut: !layer.region.is_everywhere(),
        }
    }

    /// What slabs have of its voxels.
    fn in_slabs(&self, slabs: &Slabs) -> SplatsBySlab {
        let depths = || self.voxels.iter().map(|v| v.center_in_view.z);
        let nearest = depths().fold(f64::INFINITY, f64::min) - self.kernel.depth_reach;
        let farthest = depths().fold(f64::NEG_INFINITY, f64::max) + self.kernel.depth_reach;
        if self.voxels.is_empty() {
            return SplatsBySlab::new();
        }
        let in_slab = |slab: i64| {
            let [front, back] = [slab, slab + 1].map(|face| slabs.face(face));
            let (middle, reach) =
                (0.5 * (front + back), self.kernel.depth_reach + 0.5 * (back - front));
            let meets = |&i: &usize| (self.voxels[i].center_in_view.z - middle).abs() <= reach;
            let cut = Cut::Slab { front, width: slabs.width_in(self.unit) };
            let voxels = (0..self.voxels.len()).filter(meets);
            (slab, voxels.map(|voxel_idx| SheetSplat { voxel_idx, cut }).collect())
        };
        (slabs.at(nearest)..=slabs.at(farthest)).map(in_slab).collect()
    }

    /// The grid's slices along the axis most parallel to the view.
    fn slices(&self, view: &View) -> Vec<Sheet> {
        let steps = self.grid.world_from_index().matrix3;
        let cosines = [steps.x_axis, steps.y_axis, steps.z_axis]
            .map(|step| step.normalize().dot(view.axes.forward));
        let mut axis = 0;
        for other in 1..3 {
            if cosines[axis].abs() < cosines[other].abs() {
                axis = other;
            }
        }
        let mut slice_numbers: Vec<usize> = (0..self.grid.dims()[axis]).collect();
        if cosines[axis] < 0.0 {
            slice_numbers.reverse();
        }
        let in_slice = |slice: usize| {
            self.drawn_whole(view).filter(|&i| self.voxels[i].coords[axis] == slice).collect()
        };
        slice_numbers.into_iter().map(|slice| whole_footprints(in_slice(slice))).collect()
    }

    /// Voxels by depth; those at one depth from the bottom to the top and from left to right.
    fn single_voxels(&self, view: &View) -> Vec<Sheet> {
        let center = view.view_from_world(self.grid.center_in_world());
        let rounded = |i: usize| {
            let steps = (self.voxels[i].center_in_view - center) / (self.unit * DEPTH_STEP);
            let [x, y, z] = steps.to_array().map(|v| v.round() as i64);
            [z, y, x]
        };
        let mut order: Vec<usize> = self.drawn_whole(view).collect();
        order.sort_by_key(|&i| rounded(i));
        order.into_iter().map(|i| whole_footprints(vec![i])).collect()
    }

    /// The voxels that are not before the near depth.
    fn drawn_whole(&self, view: &View) -> impl Iterator<Item = usize> {
        let near_depth = view.near_depth(self.unit);
        (0..self.voxels.len()).filter(move |&i| near_depth <= self.voxels[i].center_in_view.z)
    }
}

fn whole_footprints(voxel_indices: Vec<usize>) -> Sheet {
    let splat = |voxel_idx| SheetSplat { voxel_idx, cut: Cut::Whole };
    Sheet { splats: vec![voxel_indices.into_iter().map(splat).collect()], faces: None }
}

fn visible_voxels(layer: &Layer, lights: &[Light], view: &View) -> Vec<Voxel> {
    let Layer { volume, transfer, transfer_2d, gradient_opacity, colors, shading, region, .. } =
        layer;
    let grid = volume.grid();
    let voxel = |voxel_idx: usize| {
        let value = Some(volume.value(voxel_idx)).filter(|value| !value.is_nan())?;
        let style = style(layer, voxel_idx);
        let coords = grid.voxel_coords(voxel_idx);
        let gradient = gradient_in_world(volume, coords);
        let steepness = grid.unit() * gradient_length(volume, coords);
        let (opacity, color) = match (&style.transfer, transfer_2d) {
            (None, Some(transfer_2d)) => transfer_2d.at(value, steepness),
            (own, _) => {
                let transfer = own.as_ref().unwrap_or(transfer);
                (transfer.opacity(value), transfer.color(value))
            }
        };
        let factor = gradient_opacity.as_ref().map_or(1.0, |factor| factor.at(steepness)[0]);
        let opacity = factor * style.opacity * opacity;
        if opacity <= 0.0 {
            return None;
        }
        let center_in_index = DVec3::from_array(coords.map(|c| c as f64));
        let center_in_world = grid.world_from_index().transform_point3(center_in_index);
        let normal = gradient.try_normalize().map_or(DVec3::ZERO, |uphill| -uphill);
        let normal = normal_by_faces(region, grid.unit(), center_in_world, normal);
        let own = colors.as_ref().map(|colors| own_color(colors, voxel_idx));
        let color = style.color.or(own).unwrap_or(color);
        Some(Voxel {
            coords,
            center_in_view: view.view_from_world(center_in_world),
            opacity,
            color: shaded_color((shading, lights), color, -normal, view.axes.forward),
            unlit: color,
            normal,
        })
    };
    (0..grid.n_voxels()).filter_map(voxel).collect()
}

/// The colour of a voxel, as a share of the largest that its type holds (model §15).
fn own_color(colors: &VoxelColors, voxel_idx: usize) -> [f64; 3] {
    match colors.samples() {
        ColorSamples::U8(colors) => colors[voxel_idx].map(|channel| f64::from(channel) / 255.0),
        ColorSamples::U16(colors) => colors[voxel_idx].map(|channel| f64::from(channel) / 65535.0),
        other => panic!("no colours are defined of {other:?}"),
    }
}

/// What a voxel's label changes (model §13).
fn style(layer: &Layer, voxel_idx: usize) -> LabelStyle {
    let Some(labels) = &layer.labels else { return LabelStyle::default() };
    let label_idx = labels.map().indices()[voxel_idx];
    let label = labels.map().labels()[usize::from(label_idx)];
    labels.styles().get(&label).cloned().unwrap_or_default()
}
