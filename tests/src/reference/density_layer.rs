//! The densities of one layer (model §8): every voxel that is not NaN is splatted into every sheet that it
//! meets, two a slab, and what lies between the densities that come of it is classified and lit.

use super::between_sheets::{Between, InSheet};
use super::classified_part::part;
use super::region::normal_by_faces;
use super::sheet::through_a_quarter;
use super::slabs::Slabs;
use super::view::View;
use super::{Cut, Hierarchy, Kernel, KernelInView, shaded_by_normals};
use rayon::prelude::*;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Compositing, Isosurface, Layer, Light, Mode, Normalization, Scene, TransferFunction,
};

/// A gradient counts in full from this part of the range of values on, per `unit`.
const FAINT_GRADIENT: f64 = 1.0 / 256.0;

/// Positions of a part at which it is lit, counted from its middle.
const LIT_AT: [f64; 4] = [-0.375, -0.125, 0.125, 0.375];

/// A layer as the camera sees it.
pub(super) struct DensityLayer<'a> {
    pub(super) layer: &'a Layer,
    lights: &'a [Light],
    compositing: Compositing,
    view: View,
    kernel: KernelInView,
    pub(super) unit: f64,
    /// That of a sheet, in `unit`s of this layer.
    pub(super) width: f64,
    voxels: Vec<Voxel>,
    /// Between these all values lie, those of infinities, too.
    pub(super) ends: [f64; 2],
    /// Below this, per world unit, a gradient does not count in full.
    faint_gradient: f64,
}

struct Voxel {
    center_in_view: DVec3,
    value: f64,
}

/// What a layer shows of a part of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClassifiedPart {
    /// `ℓ`.
    pub(super) length: f64,
    /// `W`.
    pub(super) weight: f64,
    /// Lit.
    pub(super) color: [f64; 3],
}

/// `ΣH` and `ΣH·v` of a pixel of a sheet.
#[derive(Clone, Copy, Default)]
struct Sum {
    length: f64,
    weighted: f64,
}

/// The sums of all pixels in all sheets.
pub(super) struct Sums {
    of_pixels: Vec<Vec<Sum>>,
    n_columns: usize,
}

impl Sums {
    /// Of a pixel of the image, or of one beside it.
    fn of(&self, [x, y]: [i64; 2]) -> &[Sum] {
        &self.of_pixels[(y + 1) as usize * self.n_columns + (x + 1) as usize]
    }
}

impl<'a> DensityLayer<'a> {
    /// Of sheets as wide as `sheets`, which are those of all layers; parts are weighted by `compositing`.
    pub(super) fn new(
        layer: &'a Layer,
        scene: &'a Scene,
        view: View,
        sheets: &Slabs,
        compositing: Compositing,
    ) -> Self {
        let settings = &scene.settings;
        let volume = &layer.volume;
        let grid = volume.grid();
        let plain = Hierarchy { normalization: Normalization::None, base_width: 0.5 };
        let kernel = KernelInView::new(Kernel::named(&settings.kernel), plain, grid, &view.axes);
        let finite: Vec<f64> =
            (0..grid.n_voxels()).map(|i| volume.value(i)).filter(|v| v.is_finite()).collect();
        let range = ends(finite.iter().copied());
        let value_ends = value_ends(layer, settings.mode, range);
        Self {
            layer,
            lights: &scene.lights,
            compositing,
            view,
            kernel,
            unit: grid.unit(),
            width: sheets.width_in(grid.unit()),
            voxels: voxels(layer, &view, value_ends),
            ends: value_ends,
            faint_gradient: (FAINT_GRADIENT * (range[1] - range[0]).max(0.0) / grid.unit())
                .max(f64::MIN_POSITIVE),
        }
    }

    /// The least of the densities that decide in a maximum, and the largest of those in a minimum; and how
    /// far beyond they count at all.
    pub(super) fn deciding(&self) -> ([f64; 2], f64) {
        let [first, last] = shown_ends(&self.layer.transfer);
        let extent = self.ends[1] - self.ends[0];
        let rise = if extent == 0.0 { 1.0 } else { extent / 128.0 };
        ([first.max(self.ends[0]), last.min(self.ends[1])], rise)
    }

    /// The depths that its kernels meet; from +∞ to −∞ if there are none.
    pub(super) fn depths(&self) -> [f64; 2] {
        let [near, far] = ends(self.voxels.iter().map(|v| v.center_in_view.z));
        [near - self.kernel.depth_reach, far + self.kernel.depth_reach]
    }

    /// Its sums in sheets with those front faces.
    pub(super) fn sums(&self, image_size: [usize; 2], fronts: &[f64]) -> Sums {
        // Gradients reach a pixel beyond the image.
        let [n_columns, n_rows] = image_size.map(|side| side + 2);
        let met: Vec<Vec<&Voxel>> = fronts.iter().map(|&front| self.met_by(front)).collect();
        let of_pixel = |idx: usize| {
            let at = [idx % n_columns, idx / n_columns].map(|c| c as i64 - 1);
            fronts.iter().zip(&met).map(|(&front, met)| self.sum(at, front, met)).collect()
        };
        let of_pixels = (0..n_columns * n_rows).into_par_iter().map(of_pixel).collect();
        Sums { of_pixels, n_columns }
    }

    /// The ray of a pixel in each sheet.
    pub(super) fn in_sheets(&self, at: [i64; 2], sums: &Sums, fronts: &[f64]) -> Vec<InSheet> {
        let [x, y] = at;
        let (here, right, left) = (sums.of(at), sums.of([x + 1, y]), sums.of([x - 1, y]));
        let (up, down) = (sums.of([x, y - 1]), sums.of([x, y + 1]));
        let in_sheet = |sheet: usize| {
            if here[sheet].length <= 0.0 {
                return InSheet::default();
            }
            let density = here[sheet].weighted / here[sheet].length;
            let middle = fronts[sheet] + 0.5 * self.width * self.unit;
            let pixel_size = self.view.pixel_size(middle);
            let slope = |after: &Sum, before: &Sum| {
                difference(&here[sheet], density, after, before) / pixel_size
            };
            InSheet {
                length: here[sheet].length,
                density,
                slopes: [slope(&right[sheet], &left[sheet]), slope(&up[sheet], &down[sheet])],
            }
        };
        (0..here.len()).map(in_sheet).collect()
    }

    /// The voxels whose kernels meet the sheet behind `front`.
    fn met_by(&self, front: f64) -> Vec<&Voxel> {
        let half = 0.5 * self.width * self.unit;
        let is_met = |voxel: &&Voxel| {
            (voxel.center_in_view.z - (front + half)).abs() <= self.kernel.depth_reach + half
        };
        self.voxels.iter().filter(is_met).collect()
    }

    /// The sum of one pixel in the sheet behind `front`, over the voxels that it meets.
    fn sum(&self, at: [i64; 2], front: f64, met: &[&Voxel]) -> Sum {
        let thickness = self.width * self.unit;
        if !self.view.draws_slab([front, front + thickness], self.unit) {
            return Sum::default();
        }
        let middle = front + 0.5 * thickness;
        let [x, y] = self.view.ray_in_view(at, middle);
        let stretch = (self.view.pixel_size(middle) / self.unit).max(1.0);
        let reach = stretch * self.kernel.reach;
        let cut = Cut::Slab { front, width: self.width };
        let mut sum = Sum::default();
        for voxel in met {
            let center = voxel.center_in_view;
            let offset = [x - center.x, y - center.y];
            if offset[0] * offset[0] + offset[1] * offset[1] <= reach * reach {
                let weight = self.kernel.stretched_weight(cut, offset, center.z, stretch);
                sum.length += weight;
                sum.weighted += weight * voxel.value;
            }
        }
        sum
    }

    /// What is seen of the part of a ray between the middles of two sheets, if anything is.
    pub(super) fn classified(
        &self,
        at: [i64; 2],
        between: &Between,
        [front, back]: [f64; 2],
    ) -> Option<ClassifiedPart> {
        let Layer { transfer, region, .. } = self.layer;
        let densities = between.ends.map(|end| end.density);
        let part = part(transfer, self.compositing, densities)?;
        // What is seen lies evenly around its mean, as far as the part goes on both sides.
        let seen = 2.0 * part.position.min(1.0 - part.position);
        // What goes through the quarters before counts.
        let through = through_a_quarter(self.compositing, between.length, part.weight);
        let quarters = [0, 1, 2, 3].map(|quarter| {
            let position = part.position + seen * LIT_AT[quarter];
            let normal = self.normal(at, between.slopes(position));
            let in_world = self.view.ray_in_world(at, front + position * (back - front));
            let normal = normal_by_faces(region, self.unit, in_world, normal);
            (normal, through.powi(quarter as i32))
        });
        let color = self.lit(part.color, &quarters);
        Some(ClassifiedPart { length: between.length, weight: part.weight, color })
    }

    /// A colour under the mean light of some normals.
    pub(super) fn lit(&self, color: [f64; 3], normals: &[(DVec3, f64)]) -> [f64; 3] {
        let light = (&self.layer.shading, self.lights);
        shaded_by_normals(light, color, normals, self.view.axes.forward)
    }

    /// In world space, shorter than 1 where there is next to no slope.
    pub(super) fn normal(&self, at: [i64; 2], slopes: DVec3) -> DVec3 {
        let gradient = self.gradient(at, slopes);
        -gradient / gradient.length().max(self.faint_gradient)
    }

    /// In world space, from slopes to the right, upwards, and from sheet to sheet along the ray.
    fn gradient(&self, at: [i64; 2], slopes: DVec3) -> DVec3 {
        // The way from a pixel to itself one world unit of depth farther.
        let [near, far] = [1.0, 2.0].map(|depth| self.view.ray_in_view(at, depth));
        let slant = [far[0] - near[0], far[1] - near[1]];
        let along_ray = slopes.z / (self.width * self.unit);
        let along_depth = along_ray - slant[0] * slopes.x - slant[1] * slopes.y;
        let axes = &self.view.axes;
        slopes.x * axes.right + slopes.y * axes.up + along_depth * axes.forward
    }
}

/// The ends of the densities from the first to the last that the transfer function shows: a point of it,
/// unless it shows all beyond.
fn shown_ends(transfer: &TransferFunction) -> [f64; 2] {
    let points = transfer.opacity_points().points();
    let is_shown = |(_, [opacity]): &(f64, [f64; 1])| 0.0 < *opacity;
    let first = match points.iter().position(is_shown) {
        Some(0) => f64::NEG_INFINITY,
        Some(idx) => points[idx - 1].0,
        None => f64::INFINITY,
    };
    let last = match points.iter().rposition(is_shown) {
        Some(idx) => points.get(idx + 1).map_or(f64::INFINITY, |point| point.0),
        None => f64::NEG_INFINITY,
    };
    [first, last]
}

/// The least and the largest of all finite values and of the transfer function's points, or isosurfaces.
fn value_ends(layer: &Layer, mode: Mode, finite: [f64; 2]) -> [f64; 2] {
    let of_values = finite.into_iter().filter(|v| v.is_finite());
    match mode {
        Mode::Isosurfaces => ends(of_values.chain(layer.isosurfaces.iter().map(Isosurface::value))),
        _ => ends(of_values.chain(layer.transfer.positions())),
    }
}

/// All that are not NaN. An infinite one counts as one of the ends.
fn voxels(layer: &Layer, view: &View, [lo, hi]: [f64; 2]) -> Vec<Voxel> {
    let volume = &layer.volume;
    let grid = volume.grid();
    let voxel = |voxel_idx: usize| {
        let center = DVec3::from_array(grid.voxel_coords(voxel_idx).map(|c| c as f64));
        let center_in_view = view.view_from_world(grid.world_from_index().transform_point3(center));
        Voxel { center_in_view, value: volume.value(voxel_idx).clamp(lo, hi) }
    };
    (0..grid.n_voxels()).filter(|&i| !volume.value(i).is_nan()).map(voxel).collect()
}

fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)])
}

/// The mean of the changes from `before` to here and from here to `after`, each by how much there is of it.
fn difference(here: &Sum, density: f64, after: &Sum, before: &Sum) -> f64 {
    let forward = after.weighted - after.length * density;
    let backward = before.length * density - before.weighted;
    (forward + backward) / (after.length + before.length).max(here.length)
}
