//! Merged sections (model §7): what a tolerance leaves of the slab faces.
//!
//! A face that has little of a voxel's extinction beyond it does not split the voxel's kernel: what is
//! beyond is *merged* into the section before it, and drawn in that section's slab.

use super::frame::{LayerInView, SheetSplat, Voxel};
use super::slabs::{Slabs, SplatsBySlab};
use super::view::View;
use super::{Cut, GaussLegendre, Kernel};
use slabsplat_core::{Mode, Normalization, RenderSettings};
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Whether these settings make use of a tolerance.
pub(super) fn applies(settings: &RenderSettings, tolerance: f64) -> bool {
    0.0 < tolerance
        && settings.mode == Mode::Extinction
        && settings.normalization == Normalization::None
}

/// What slabs have of a layer that may be off by `tolerance`.
pub(super) fn merged_splats(
    layer: &LayerInView,
    slabs: &Slabs,
    view: &View,
    tolerance: f64,
) -> SplatsBySlab {
    let levels = Levels::new(layer, view, tolerance);
    let slab_width = slabs.width_in(layer.unit);
    let mut splats = SplatsBySlab::new();
    for (voxel_idx, voxel) in layer.voxels.iter().enumerate() {
        let drawn = match levels.doublings(voxel, slab_width) {
            0 => sections(layer, slabs, voxel, levels.reach(voxel)),
            n => vec![whole_in_thick_slab(layer, slabs, voxel, n)],
        };
        for (slab, cut) in drawn {
            splats.entry(slab).or_default().push(SheetSplat { voxel_idx, cut });
        }
    }
    splats
}

/// All of a voxel, in the slab behind the middle of the one that is 2ⁿ times as thick.
fn whole_in_thick_slab(layer: &LayerInView, slabs: &Slabs, voxel: &Voxel, n: u32) -> (i64, Cut) {
    let (depth, reach) = (voxel.center_in_view.z, layer.kernel.depth_reach);
    let [first, last] = [slabs.at(depth - reach), slabs.at(depth + reach)];
    let width = (last + 1 - first) as f64 * slabs.width_in(layer.unit);
    let whole = Cut::Slab { front: slabs.face(first), width };
    let side = 1_i64 << n;
    (home(slabs, layer, depth).div_euclid(side) * side + side / 2, whole)
}

/// The slab that holds the centre of a voxel: the one behind if it lies on a face, or so little before
/// it that rounding in 32 bits might.
fn home(slabs: &Slabs, layer: &LayerInView, depth: f64) -> i64 {
    slabs.at(depth + slabs.width_in(layer.unit) * layer.unit / 1024.0)
}

/// The sections of a voxel, each with the slab in which it is drawn.
/// It is cut by the faces that are nearer to its centre than `cut_reach`.
fn sections(layer: &LayerInView, slabs: &Slabs, voxel: &Voxel, cut_reach: f64) -> Vec<(i64, Cut)> {
    let (depth, reach) = (voxel.center_in_view.z, layer.kernel.depth_reach);
    let home = home(slabs, layer, depth);
    let met: RangeInclusive<i64> = slabs.at(depth - reach)..=slabs.at(depth + reach);
    let is_cut = |&face: &i64| (slabs.face(face) - depth).abs() < cut_reach;
    let mut starts = vec![*met.start()];
    starts.extend((*met.start() + 1..=*met.end()).filter(is_cut));
    let ends = starts[1..].iter().copied().chain([*met.end() + 1]);
    let section = |(&start, end): (&i64, i64)| {
        // The nearest to the voxel's centre of the slabs that the section covers.
        let slab = home.clamp(start, end - 1);
        let width = (end - start) as f64 * slabs.width_in(layer.unit);
        (slab, Cut::Slab { front: slabs.face(start), width })
    };
    starts.iter().zip(ends).map(section).collect()
}

/// How far from a voxel's centre faces cut, by its extinction.
struct Levels {
    /// `λ·T` at 33 distances from the centre to the kernel's end.
    merged: Vec<f64>,
    layer_depth: f64,
    depth_reach: f64,
    steepest_ray: f64,
    tolerance: f64,
    /// Voxels along an edge of what is drawn.
    cell_side: f64,
    /// Whether a region or a mesh cuts the layer.
    is_cut: bool,
}

impl Levels {
    fn new(layer: &LayerInView, view: &View, tolerance: f64) -> Self {
        let (kernel, depth_reach) = (layer.kernel.kernel(), layer.kernel.depth_reach);
        let layer_depth = depth_reach / (kernel.radius() * layer.unit);
        let beyond = |level: u32| fraction_beyond(kernel, kernel.radius() * share(level));
        Self {
            layer_depth,
            merged: (0..=32).map(|level| layer_depth * beyond(level)).collect(),
            depth_reach,
            steepest_ray: view.steepest_ray(),
            tolerance,
            cell_side: layer.stretch.side(),
            is_cut: layer.is_cut,
        }
    }

    /// By how many doublings the slab is thicker into which a voxel goes whole; 0 if faces may cut it.
    fn doublings(&self, voxel: &Voxel, slab_width: f64) -> u32 {
        let is_allowed = |n: &u32| {
            let n_slabs = f64::from(1 << n);
            let n_others = if self.is_cut { n_slabs - 1.0 } else { 0.5 * n_slabs };
            // Of cells, those of their voxels, of which each has its share.
            let layers = self.cell_side * (slab_width * n_others + self.layer_depth);
            let extinction = voxel.extinction() / self.cell_side.powi(2);
            self.steepest_ray == 0.0 && extinction * layers <= self.tolerance
        };
        (1..=2).rev().find(is_allowed).unwrap_or(0)
    }

    /// The first of the distances beyond which there is little enough.
    fn reach(&self, voxel: &Voxel) -> f64 {
        let is_voxel = self.cell_side == 1.0;
        let extinction = if is_voxel { voxel.extinction() } else { 0.0 }.max(self.steepest_ray);
        let is_little = |merged: &f64| extinction * merged <= self.tolerance / 2.0;
        let level = self.merged.iter().position(is_little).unwrap_or(32);
        share(level as u32) * self.depth_reach
    }
}

fn share(level: u32) -> f64 {
    f64::from(level) / 32.0
}

/// `T(δ)`: how much of the kernel lies beyond a plane at the distance `δ` from its centre. A shell of
/// radius `r` has the share `(1 − δ/r)/2` of its area there.
pub fn fraction_beyond(kernel: Kernel, distance: f64) -> f64 {
    let shell = |r: f64| 2.0 * PI * r * (r - distance) * kernel.at(r);
    let end = kernel.radius().max(distance);
    // Where the two pieces of crawfis-max meet.
    let joint = 0.88_f64.clamp(distance.min(end), end);
    let rule = GaussLegendre::new(24);
    rule.integrate(distance, joint, shell) + rule.integrate(joint, end, shell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merge_half_a_kernel_lies_beyond_its_center() {
        for kernel in [Kernel::Gaussian, Kernel::CrawfisMax] {
            let half = fraction_beyond(kernel, 0.0);
            assert!((half - 0.5).abs() < 1e-3, "{kernel:?}: {half}");
            assert_eq!(fraction_beyond(kernel, kernel.radius()), 0.0);
        }
    }
}
