//! The method `post-classified`, as model §8 has it: every voxel that is not NaN is splatted into every
//! sheet that it meets, two a slab, and what lies between the densities that come of it is classified.

use super::between_sheets::{Between, InSheet};
use super::classified_part::part;
use super::isosurfaces::{Crossing, crossings};
use super::mesh::{Surfaces, mean_of_samples, share_before};
use super::region::{PLACE_OF_A_PLANE, RegionOnRay, normal_by_faces, splitting};
use super::statistic::{self, OneForAll};
use super::view::View;
use super::{
    Cut, Hierarchy, Kernel, KernelInView, Premultiplied, ReferenceImage, SheetSums,
    shaded_by_normals,
};
use rayon::prelude::*;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Compositing, Isosurface, Layer, Light, Mode, Normalization, Scene, Statistic,
};

/// A gradient counts in full from this part of the range of values on, per `unit`.
const FAINT_GRADIENT: f64 = 1.0 / 256.0;

/// Places of a part at which it is lit, counted from its middle.
const LIT_AT: [f64; 4] = [-0.375, -0.125, 0.125, 0.375];

/// What all pixels have in common.
struct Frame<'a> {
    layer: &'a Layer,
    lights: &'a [Light],
    /// What parts are composited by, and how regions split them.
    compositing: Compositing,
    /// What is shown of densities.
    mode: Mode,
    image_size: [usize; 2],
    background: [f64; 4],
    view: View,
    surfaces: Surfaces<'a>,
    kernel: KernelInView,
    unit: f64,
    /// That of a sheet, half a slab's, in `unit`s.
    width: f64,
    voxels: Vec<Voxel>,
    /// Between these all values lie, those of infinities, too.
    ends: [f64; 2],
    /// Front faces of the sheets, in world units.
    fronts: Vec<f64>,
    /// Below this, per world unit, a gradient does not count in full.
    faint_gradient: f64,
}

struct Voxel {
    center_in_view: DVec3,
    value: f64,
}

/// What lies between the middles of two sheets, at one pixel.
struct PartOfRay {
    between: Between,
    /// What the region leaves of it.
    share: f64,
    ends: [f64; 2],
    /// What that shows, if no surface is before its end.
    whole: Premultiplied,
}

/// `ΣH` and `ΣH·v` of a pixel of a sheet.
#[derive(Clone, Copy, Default)]
struct Sum {
    length: f64,
    weighted: f64,
}

/// Where parts begin and end: in the middles of sheets.
pub(super) fn part_faces(scene: &Scene) -> Vec<[f64; 2]> {
    let frame = Frame::new(scene);
    (1..frame.fronts.len()).map(|sheet| [sheet - 1, sheet].map(|it| frame.middle(it))).collect()
}

/// The picture of `scene`.
pub(super) fn render(scene: &Scene) -> ReferenceImage {
    let frame = Frame::new(scene);
    let sums = frame.sums();
    let (width, height) = (scene.image.width, scene.image.height);
    let pixels = frame.pixels().map(|at| frame.pixel(at, &sums, Moved::default())).collect();
    ReferenceImage { width, height, pixels }
}

/// The pixels, row by row, that show another colour if what renderers round were a bit more or less.
pub(super) fn undecided_isosurfaces(scene: &Scene) -> Vec<bool> {
    let frame = Frame::new(scene);
    let sums = frame.sums();
    let value = VALUE_OF_A_SURFACE * (frame.ends[1] - frame.ends[0]);
    let plane = PLACE_OF_A_PLANE * frame.unit;
    let is_undecided = |at: [i64; 2]| {
        let moved = |value, plane| frame.pixel(at, &sums, Moved { value, plane });
        let pixel = moved(0.0, 0.0);
        let others = [moved(value, 0.0), moved(-value, 0.0), moved(0.0, plane), moved(0.0, -plane)];
        let differs = |other: &[f64; 4]| (0..4).any(|i| ANOTHER < (other[i] - pixel[i]).abs());
        others.iter().any(differs)
    };
    frame.pixels().map(is_undecided).collect()
}

/// By how much of the range of values renderers may disagree on a density.
const VALUE_OF_A_SURFACE: f64 = 1e-5;

/// Half of what pictures that agree may differ by.
const ANOTHER: f64 = 5e-4;

/// By how much densities of surfaces and the planes of regions are not where they are.
#[derive(Clone, Copy, Default)]
struct Moved {
    value: f64,
    /// Outwards, in world units.
    plane: f64,
}

/// The sums of all pixels in all sheets.
struct Sums {
    of_pixels: Vec<Vec<Sum>>,
    n_columns: usize,
}

impl Sums {
    /// Of a pixel of the image, or of one beside it.
    fn of(&self, [x, y]: [i64; 2]) -> &[Sum] {
        &self.of_pixels[(y + 1) as usize * self.n_columns + (x + 1) as usize]
    }
}

impl<'a> Frame<'a> {
    fn new(scene: &'a Scene) -> Self {
        let [layer] = &scene.layers[..] else {
            panic!("the densities of {} layers are not defined", scene.layers.len());
        };
        let settings = &scene.settings;
        let volume = &layer.volume;
        let grid = volume.grid();
        let view = View::new(&scene.camera, &scene.image);
        let plain = Hierarchy { normalization: Normalization::None, base_width: 0.5 };
        let kernel = KernelInView::new(Kernel::named(&settings.kernel), plain, grid, &view.axes);
        let finite: Vec<f64> =
            (0..grid.n_voxels()).map(|i| volume.value(i)).filter(|v| v.is_finite()).collect();
        let range = ends(finite.iter().copied());
        let mut frame = Self {
            layer,
            lights: &scene.lights,
            compositing: splitting(settings.mode),
            mode: settings.mode,
            image_size: [scene.image.width, scene.image.height].map(|side| side as usize),
            background: scene.image.background.map(f64::from),
            view,
            surfaces: Surfaces::new(scene, &view),
            kernel,
            unit: grid.unit(),
            width: 0.5 * settings.slab_width,
            voxels: voxels(layer, &view, value_ends(layer, settings.mode, range)),
            ends: value_ends(layer, settings.mode, range),
            fronts: Vec::new(),
            faint_gradient: (FAINT_GRADIENT * (range[1] - range[0]).max(0.0) / grid.unit())
                .max(f64::MIN_POSITIVE),
        };
        frame.fronts = frame.sheets(view.view_from_world(grid.center_in_world()).z);
        frame
    }

    /// Sheets from one that no kernel meets to another, so that each that matters has neighbours.
    fn sheets(&self, center_depth: f64) -> Vec<f64> {
        let thickness = self.width * self.unit;
        let [near, far] = ends(self.voxels.iter().map(|v| v.center_in_view.z));
        let sheet_at = |depth: f64| ((depth - center_depth) / thickness).floor() as i64;
        if self.voxels.is_empty() {
            return Vec::new();
        }
        let first = sheet_at(near - self.kernel.depth_reach) - 3;
        let last = sheet_at(far + self.kernel.depth_reach) + 3;
        (first..=last).map(|n| center_depth + n as f64 * thickness).collect()
    }

    /// The pixels, row by row.
    fn pixels(&self) -> impl Iterator<Item = [i64; 2]> {
        let [width, height] = self.image_size.map(|side| side as i64);
        (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]))
    }

    fn sums(&self) -> Sums {
        // Gradients reach a pixel beyond the image.
        let [n_columns, n_rows] = self.image_size.map(|side| side + 2);
        let of_pixel = |idx: usize| {
            let at = [idx % n_columns, idx / n_columns].map(|c| c as i64 - 1);
            self.fronts.iter().map(|&front| self.sum(at, front)).collect()
        };
        let of_pixels = (0..n_columns * n_rows).into_par_iter().map(of_pixel).collect();
        Sums { of_pixels, n_columns }
    }

    /// The premultiplied RGBA of a pixel.
    fn pixel(&self, at: [i64; 2], sums: &Sums, moved: Moved) -> [f64; 4] {
        let [x, y] = at;
        let (here, right, left) = (sums.of(at), sums.of([x + 1, y]), sums.of([x - 1, y]));
        let (up, down) = (sums.of([x, y - 1]), sums.of([x, y + 1]));
        let in_sheet = |sheet: usize| {
            if here[sheet].length <= 0.0 {
                return InSheet::default();
            }
            let density = here[sheet].weighted / here[sheet].length;
            let pixel_size = self.view.pixel_size(self.middle(sheet));
            let slope = |after: &Sum, before: &Sum| {
                difference(&here[sheet], density, after, before) / pixel_size
            };
            InSheet {
                length: here[sheet].length,
                density,
                slopes: [slope(&right[sheet], &left[sheet]), slope(&up[sheet], &down[sheet])],
            }
        };
        let sheets: Vec<InSheet> = (0..here.len()).map(in_sheet).collect();
        let region = RegionOnRay::moved(&self.layer.region, &self.view, at, moved.plane);
        let hits = self.surfaces.hits(&self.view, at);
        let of_all = match (self.mode.statistic(), self.mode) {
            (Some(statistic), _) => self.one_for_all(statistic, &sheets, &region),
            (None, Mode::Isosurfaces) => self.isosurfaces(at, &sheets, &region, moved.value),
            (None, _) => {
                let parts = self.parts(at, &sheets, &region);
                let up_to = |depth| self.composited(at, &parts, depth);
                return mean_of_samples(&hits, self.background, up_to);
            }
        };
        mean_of_samples(&hits, self.background, |_| of_all)
    }

    /// The parts of a ray that hold anything, from front to back.
    fn parts(&self, at: [i64; 2], sheets: &[InSheet], region: &RegionOnRay) -> Vec<PartOfRay> {
        let part = |(before, six): (usize, &[InSheet; 6])| {
            let ends = [before + 2, before + 3].map(|sheet| self.middle(sheet));
            let (between, share) = (Between::new(six), region.share(self.compositing, ends));
            PartOfRay { whole: self.classified(at, &between, share, ends), between, share, ends }
        };
        let sixes = sheets.array_windows().enumerate();
        let hold = |six: &[InSheet; 6]| 0.0 < six[2].length || 0.0 < six[3].length;
        sixes.filter(|(_, six)| hold(six)).map(part).collect()
    }

    /// What a ray that ends at a depth, or nowhere, composites of parts.
    fn composited(&self, at: [i64; 2], parts: &[PartOfRay], depth: Option<f64>) -> Premultiplied {
        let mut pixel = Premultiplied::default();
        for PartOfRay { between, share, ends, whole } in parts {
            let before = depth.map_or(1.0, |depth| share_before(self.compositing, *ends, depth));
            if before == 1.0 {
                pixel.lay_over(*whole);
            } else if 0.0 < before {
                pixel.lay_over(self.classified(at, between, share * before, *ends));
            }
        }
        pixel
    }

    /// The surfaces on a ray, from front to back (model §12).
    fn isosurfaces(
        &self,
        at: [i64; 2],
        sheets: &[InSheet],
        region: &RegionOnRay,
        moved: f64,
    ) -> Premultiplied {
        let Layer { isosurfaces, transfer, shading, .. } = self.layer;
        let mut pixel = Premultiplied::default();
        for (before, six) in sheets.array_windows().enumerate() {
            let lengths = [six[2].length, six[3].length];
            if lengths[0] <= 0.0 || lengths[1] <= 0.0 {
                continue;
            }
            let between = Between::of_nodes(six);
            let [front, back] = [before + 2, before + 3].map(|sheet| self.middle(sheet));
            for Crossing { place, surface } in crossings(isosurfaces, &between, self.ends, moved) {
                let lerp = |from: f64, to: f64| from + place * (to - from);
                if !region.holds(lerp(front, back)) {
                    continue;
                }
                let surface = isosurfaces[surface];
                let color = surface.color().unwrap_or_else(|| transfer.color(surface.value()));
                let normals = [(self.normal(at, between.slopes(place)), 1.0)];
                let color = shaded_by_normals(
                    (shading, self.lights),
                    color,
                    &normals,
                    self.view.axes.forward,
                );
                let there_is =
                    (4.0 * lerp(lengths[0], lengths[1]) / self.width - 1.5).clamp(0.0, 1.0);
                let opacity = there_is * surface.opacity();
                pixel.lay_over(Premultiplied { color: color.map(|c| opacity * c), opacity });
            }
        }
        pixel
    }

    /// The density that stands for all, classified (model §12).
    fn one_for_all(
        &self,
        statistic: Statistic,
        sheets: &[InSheet],
        region: &RegionOnRay,
    ) -> Premultiplied {
        let thickness = self.width * self.unit;
        let shares: Vec<f64> = self
            .fronts
            .iter()
            .map(|&front| region.share(self.compositing, [front, front + thickness]))
            .collect();
        let full_length = self.width / 16.0;
        let found = statistic::of_sheets(statistic, sheets, &shares, self.ends, full_length);
        let Some(OneForAll { density, counting }) = found else {
            return Premultiplied::default();
        };
        let opacity = counting * self.layer.transfer.opacity(density);
        let color = self.layer.transfer.color(density).map(|channel| opacity * channel);
        Premultiplied { color, opacity }
    }

    fn middle(&self, sheet: usize) -> f64 {
        self.fronts[sheet] + 0.5 * self.width * self.unit
    }

    /// The sum of one pixel in the sheet behind `front`.
    fn sum(&self, at: [i64; 2], front: f64) -> Sum {
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
        for voxel in &self.voxels {
            let center = voxel.center_in_view;
            let offset = [x - center.x, y - center.y];
            let is_far = reach < offset[0].hypot(offset[1])
                || self.kernel.depth_reach + 0.5 * thickness < (center.z - middle).abs();
            if !is_far {
                let weight = self.kernel.stretched_weight(cut, offset, center.z, stretch);
                sum.length += weight;
                sum.weighted += weight * voxel.value;
            }
        }
        sum
    }

    /// The part of a ray between two sheets, in which the density goes from one end to the other, and of
    /// which the region leaves a share.
    fn classified(
        &self,
        at: [i64; 2],
        between: &Between,
        share: f64,
        [front, back]: [f64; 2],
    ) -> Premultiplied {
        let Layer { transfer, shading, region, .. } = self.layer;
        let mut sums = SheetSums::new(self.compositing);
        let densities = between.ends.map(|end| end.density);
        let Some(part) = part(transfer, self.compositing, densities) else {
            return Premultiplied::default();
        };
        // What is seen lies evenly around its mean, as far as the part goes on both sides.
        let seen = 2.0 * part.place.min(1.0 - part.place);
        // What goes through the quarters before counts, where what a sheet sums hides any of itself.
        let through = match self.compositing {
            Compositing::Extinction => (-0.25 * between.length * part.weight).exp(),
            Compositing::Separate | Compositing::Associated => 1.0,
        };
        let quarters = [0, 1, 2, 3].map(|quarter| {
            let place = part.place + seen * LIT_AT[quarter];
            let normal = self.normal(at, between.slopes(place));
            let in_world = self.view.ray_in_world(at, front + place * (back - front));
            let normal = normal_by_faces(region, self.unit, in_world, normal);
            (normal, through.powi(quarter as i32))
        });
        let color = shaded_by_normals(
            (shading, self.lights),
            part.color,
            &quarters,
            self.view.axes.forward,
        );
        sums.add_weighted(share * between.length, part.weight, color);
        sums.finish()
    }

    /// In world space, shorter than 1 where there is next to no slope.
    fn normal(&self, at: [i64; 2], slopes: DVec3) -> DVec3 {
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
