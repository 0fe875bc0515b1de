//! Levels of detail (model §16): cells of voxels, where a tolerance allows them.

use super::frame::{LayerInView, Voxel};
use super::view::View;
use super::{GaussLegendre, Kernel};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, LabelStyle, Layer, TransferFunction, extinction};
use std::collections::BTreeMap;

/// How far footprints are stretched in the image plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// Of the voxels.
    unit: f64,
    /// Voxels along an edge of what is drawn, and what its own extent adds to the variance of their kernels,
    /// over its own.
    side: f64,
    spread: f64,
}

const LEVELS: std::ops::RangeInclusive<u32> = 1..=3;

impl Stretch {
    /// Of voxels (model §5).
    pub(super) fn of_voxels(unit: f64) -> Self {
        Self { unit, side: 1.0, spread: 0.0 }
    }

    fn of_cells(self, level: u32, kernel: Kernel) -> Self {
        let side = f64::from(1 << level);
        let of_cell = (side * side - 1.0) / 12.0;
        Self { side, spread: of_cell / (side * side * variance(kernel)), ..self }
    }

    pub(super) fn at(&self, view: &View, depth: f64) -> f64 {
        let of_voxels = (view.pixel_size(depth) / self.unit).max(1.0);
        ((of_voxels / self.side).powi(2) - self.spread).max(0.25).sqrt()
    }

    /// The shortest voxel step, whatever is drawn.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }
}

/// The layer by the largest cells that it may be drawn by.
pub(super) fn within(layer: LayerInView, of: &Layer, view: &View, tolerance: f64) -> LayerInView {
    let grid = *of.volume.grid();
    let corners = grid.corners_in_world().map(|corner| view.view_from_world(corner).z);
    let nearest = corners.fold(f64::INFINITY, f64::min) - layer.kernel.depth_reach;
    let nearest = nearest.max(view.near_depth(layer.unit));
    let kernel = layer.kernel.kernel();
    let layer_depth = layer.kernel.depth_reach / (kernel.radius() * layer.unit);
    let is_allowed = |level: &u32| {
        let cells = layer.stretch.of_cells(*level, kernel);
        let depth = ((4_f64.powi(*level as i32) - 1.0) / 48.0).sqrt();
        let has_eight = grid.dims().iter().all(|&n| 8 << level <= n);
        has_eight
            && 0.95 <= cells.at(view, nearest)
            && depth * layer_depth * most_extinction(of) <= tolerance / 4.0
    };
    match LEVELS.take_while(is_allowed).last() {
        Some(level) => drawn_by(layer, &grid, level, view),
        None => layer,
    }
}

fn drawn_by(layer: LayerInView, voxels: &Grid, level: u32, view: &View) -> LayerInView {
    let side = 1_usize << level;
    let cells = voxels.of_cells(level).expect("its steps are not too long");
    let kernel = layer.kernel.on_cells(&cells, &view.axes, f64::from(1 << level));
    let mut sums: BTreeMap<[usize; 3], [f64; 4]> = BTreeMap::new();
    for voxel in &layer.voxels {
        let ([r, g, b], mu) = (voxel.color, voxel.extinction());
        let sum = sums.entry(voxel.coords.map(|at| at / side)).or_default();
        sum.iter_mut().zip([mu * r, mu * g, mu * b, mu]).for_each(|(sum, it)| *sum += it);
    }
    let cell = |(coords, [r, g, b, mu]): ([usize; 3], [f64; 4])| {
        let at = DVec3::from_array(coords.map(|at| at as f64));
        Voxel {
            coords,
            center_in_view: view.view_from_world(cells.world_from_index().transform_point3(at)),
            opacity: -(-mu / side as f64).exp_m1(),
            color: [r, g, b].map(|sum| sum / mu),
        }
    };
    LayerInView {
        stretch: layer.stretch.of_cells(level, layer.kernel.kernel()),
        unit: cells.unit(),
        grid: cells,
        kernel,
        voxels: sums.into_iter().map(cell).collect(),
        ..layer
    }
}

/// Of the most opaque voxel that there could be.
fn most_extinction(layer: &Layer) -> f64 {
    let most = |transfer: &TransferFunction| {
        let points = transfer.opacity_points().points();
        points.iter().map(|point| point.1[0]).fold(0.0, f64::max)
    };
    let styles = layer.labels.iter().flat_map(|labels| labels.styles().values());
    let own = styles.filter_map(|style: &LabelStyle| style.transfer.as_ref()).map(most);
    match layer.transfer_2d {
        Some(_) => f64::INFINITY,
        None => extinction(own.fold(most(&layer.transfer), f64::max)),
    }
}

/// Along any axis.
fn variance(kernel: Kernel) -> f64 {
    let rule = GaussLegendre::new(24);
    let moment = |power: i32| {
        // Where the two pieces of crawfis-max meet.
        let of_shell = |r: f64| kernel.at(r) * r.powi(power);
        rule.integrate(0.0, 0.88, of_shell) + rule.integrate(0.88, kernel.radius(), of_shell)
    };
    moment(4) / (3.0 * moment(2))
}
