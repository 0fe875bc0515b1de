//! The method `post-classified` and the modes of densities, as model §§8, 10 and 12 have them: what the
//! densities of all layers come to along a ray.

use super::between_sheets::{Between, InSheet};
use super::density_layer::{ClassifiedPart, DensityLayer, Sums};
use super::isosurfaces::{Crossing, crossings};
use super::mesh::{Surfaces, mean_of_samples, share_before};
use super::region::{PLACE_OF_A_PLANE, RegionOnRay};
use super::sheet::splitting;
use super::slabs::Slabs;
use super::statistic::{self, OneForAll};
use super::view::View;
use super::{Premultiplied, ReferenceImage, SheetSums};
use rayon::prelude::*;
use slabsplat_core::{Compositing, Layer, Mode, Scene, Statistic};

/// What all pixels have in common.
struct Frame<'a> {
    /// What parts are composited by, and how regions split them.
    compositing: Compositing,
    /// What is shown of densities.
    mode: Mode,
    image_size: [usize; 2],
    background: [f64; 4],
    view: View,
    surfaces: Surfaces<'a>,
    layers: Vec<DensityLayer<'a>>,
    /// Front faces of the sheets of all layers, and how far they are apart, in world units.
    fronts: Vec<f64>,
    thickness: f64,
}

/// A layer at one pixel.
struct OnRay<'a> {
    layer: &'a DensityLayer<'a>,
    sheets: Vec<InSheet>,
    region: RegionOnRay,
    moved: Moved,
}

/// What lies between the middles of two sheets, at one pixel.
struct PartOfRay {
    ends: [f64; 2],
    /// Of each layer that shows anything there, and what the region leaves of it.
    shown: Vec<(ClassifiedPart, f64)>,
}

/// Where parts begin and end: in the middles of sheets.
pub(super) fn part_faces(scene: &Scene) -> Vec<[f64; 2]> {
    let frame = Frame::new(scene);
    (1..frame.fronts.len()).map(|sheet| frame.between_middles(sheet - 1)).collect()
}

/// The picture of `scene`.
pub(super) fn render(scene: &Scene) -> ReferenceImage {
    let frame = Frame::new(scene);
    frame.image(&frame.sums())
}

/// The pixels, row by row, that show another colour if what renderers round were a bit more or less: of all
/// layers alike, or of each otherwise.
pub(super) fn undecided_isosurfaces(scene: &Scene) -> Vec<bool> {
    let frame = Frame::new(scene);
    frame.undecided(&frame.sums())
}

/// Both: the sums of sheets, which take the most time, are the same.
pub(super) fn with_undecided_isosurfaces(scene: &Scene) -> (ReferenceImage, Vec<bool>) {
    let frame = Frame::new(scene);
    let sums = frame.sums();
    (frame.image(&sums), frame.undecided(&sums))
}

/// By how much of the range of values renderers may disagree on a density.
const VALUE_OF_A_SURFACE: f64 = 1e-5;

/// Half of what pictures that agree may differ by.
const ANOTHER: f64 = 5e-4;

/// By how much densities of surfaces and the planes of regions of a layer are not where they are.
#[derive(Clone, Copy)]
struct Moved {
    /// As a part of the range of values.
    value: f64,
    /// Outwards, in `unit`s.
    plane: f64,
}

impl Moved {
    /// Of any layer.
    fn none(_: usize) -> Self {
        Self { value: 0.0, plane: 0.0 }
    }
}

impl<'a> Frame<'a> {
    fn new(scene: &'a Scene) -> Self {
        let mode = scene.settings.mode;
        let view = View::new(&scene.camera, &scene.image);
        let halves = Slabs::new(scene, &view).halves();
        let compositing = splitting(mode);
        // A layer without surfaces shows none.
        let is_shown = |layer: &&Layer| mode != Mode::Isosurfaces || !layer.isosurfaces.is_empty();
        let in_view = |layer| DensityLayer::new(layer, scene, view, &halves, compositing);
        let layers: Vec<DensityLayer<'_>> =
            scene.layers.iter().filter(is_shown).map(in_view).collect();
        Self {
            compositing,
            mode,
            image_size: [scene.image.width, scene.image.height].map(|side| side as usize),
            background: scene.image.background.map(f64::from),
            view,
            surfaces: Surfaces::new(scene, &view),
            fronts: fronts(&layers, &halves),
            thickness: halves.face(1) - halves.face(0),
            layers,
        }
    }

    fn image(&self, sums: &[Sums]) -> ReferenceImage {
        let [width, height] = self.image_size.map(|side| side as u32);
        let pixels = self.view.pixels().map(|at| self.pixel(at, sums, &Moved::none)).collect();
        ReferenceImage { width, height, pixels }
    }

    fn undecided(&self, sums: &[Sums]) -> Vec<bool> {
        let is_undecided = |at: [i64; 2]| {
            let pixel = self.pixel(at, sums, &Moved::none);
            let differs = |moved: &dyn Fn(usize) -> Moved| {
                let other = self.pixel(at, sums, moved);
                (0..4).any(|i| ANOTHER < (other[i] - pixel[i]).abs())
            };
            [-1.0, 1.0].into_iter().any(|by| {
                let value = by * VALUE_OF_A_SURFACE;
                let plane = by * PLACE_OF_A_PLANE;
                differs(&|_| Moved { value, plane: 0.0 })
                    || differs(&|_| Moved { value: 0.0, plane })
                    || 1 < self.layers.len()
                        && differs(&|layer| Moved { value: layer as f64 * value, plane: 0.0 })
            })
        };
        self.view.pixels().map(is_undecided).collect()
    }

    /// Of each layer.
    fn sums(&self) -> Vec<Sums> {
        self.layers.iter().map(|layer| layer.sums(self.image_size, &self.fronts)).collect()
    }

    /// The premultiplied RGBA of a pixel, of layers that are moved.
    fn pixel(&self, at: [i64; 2], sums: &[Sums], moved: &dyn Fn(usize) -> Moved) -> [f64; 4] {
        let on_ray = |(idx, layer)| self.on_ray(at, layer, &sums[idx], moved(idx));
        let layers: Vec<OnRay<'_>> = self.layers.iter().enumerate().map(on_ray).collect();
        let hits = self.surfaces.hits(&self.view, at);
        let of_all = match (self.mode.statistic(), self.mode) {
            (Some(statistic), _) => {
                let of_layer = |layer: &OnRay<'_>| self.one_for_all(statistic, layer);
                statistic::joined(layers.iter().filter_map(of_layer))
            }
            (None, Mode::Isosurfaces) => self.isosurfaces(at, &layers),
            (None, _) => {
                let parts = self.parts(at, &layers);
                let up_to = |depth| self.composited(&parts, depth);
                return mean_of_samples(&hits, self.background, up_to);
            }
        };
        mean_of_samples(&hits, self.background, |_| of_all)
    }

    fn on_ray<'b>(
        &self,
        at: [i64; 2],
        layer: &'b DensityLayer<'a>,
        sums: &Sums,
        moved: Moved,
    ) -> OnRay<'b> {
        let outwards = moved.plane * layer.unit;
        let region = RegionOnRay::moved(&layer.layer.region, &self.view, at, outwards);
        OnRay { layer, sheets: layer.in_sheets(at, sums, &self.fronts), region, moved }
    }

    /// The parts of a ray, from front to back.
    fn parts(&self, at: [i64; 2], layers: &[OnRay<'_>]) -> Vec<PartOfRay> {
        let part = |first: usize| {
            let ends = self.between_middles(first);
            let shown = |OnRay { layer, sheets, region, .. }: &OnRay<'_>| {
                let six = around(sheets, first);
                let holds = 0.0 < six[2].length || 0.0 < six[3].length;
                let part = holds.then(|| layer.classified(at, &Between::new(six), ends))??;
                Some((part, region.share(self.compositing, ends)))
            };
            PartOfRay { ends, shown: layers.iter().filter_map(shown).collect() }
        };
        self.parts_from().map(part).collect()
    }

    /// What a ray that ends at a depth, or nowhere, composites of parts.
    fn composited(&self, parts: &[PartOfRay], depth: Option<f64>) -> Premultiplied {
        let mut pixel = Premultiplied::default();
        for PartOfRay { ends, shown } in parts {
            let before = depth.map_or(1.0, |depth| share_before(self.compositing, *ends, depth));
            let mut sums = SheetSums::of_parts(self.compositing);
            for (ClassifiedPart { length, weight, color }, share) in shown {
                let length = before * share * length;
                sums.add_part(self.compositing, length, *weight, *color);
            }
            pixel.lay_over(sums.finish());
        }
        pixel
    }

    /// The surfaces on a ray, from front to back (model §12).
    fn isosurfaces(&self, at: [i64; 2], layers: &[OnRay<'_>]) -> Premultiplied {
        let mut pixel = Premultiplied::default();
        for first in self.parts_from() {
            let mut passed: Vec<(f64, Premultiplied)> =
                layers.iter().flat_map(|layer| self.passed(at, layer, first)).collect();
            // In their order where depths are the same.
            passed.sort_by(|(a, _), (b, _)| a.total_cmp(b));
            passed.into_iter().for_each(|(_, surface)| pixel.lay_over(surface));
        }
        pixel
    }

    /// The surfaces of a layer between the middles of a sheet and the next, and where they are: from 0 at the
    /// first to 1 at the second.
    fn passed(
        &self,
        at: [i64; 2],
        OnRay { layer, sheets, region, moved }: &OnRay<'_>,
        first: usize,
    ) -> Vec<(f64, Premultiplied)> {
        let six = around(sheets, first);
        let lengths = [six[2].length, six[3].length];
        if lengths[0] <= 0.0 || lengths[1] <= 0.0 {
            return Vec::new();
        }
        let between = Between::of_nodes(six);
        let [front, back] = self.between_middles(first);
        let isosurfaces = &layer.layer.isosurfaces;
        let moved = moved.value * (layer.ends[1] - layer.ends[0]);
        let shown = |Crossing { position, surface }: Crossing| {
            let lerp = |from: f64, to: f64| from + position * (to - from);
            if !region.holds(lerp(front, back)) {
                return None;
            }
            let surface = isosurfaces[surface];
            let color = surface.color();
            let color = color.unwrap_or_else(|| layer.layer.transfer.color(surface.value()));
            let color = layer.lit(color, &[(layer.normal(at, between.slopes(position)), 1.0)]);
            let there_is = (4.0 * lerp(lengths[0], lengths[1]) / layer.width - 1.5).clamp(0.0, 1.0);
            let opacity = there_is * surface.opacity();
            Some((position, Premultiplied { color: color.map(|c| opacity * c), opacity }))
        };
        crossings(isosurfaces, &between, layer.ends, moved).into_iter().filter_map(shown).collect()
    }

    /// The density of a layer that stands for all, classified (model §12).
    fn one_for_all(
        &self,
        statistic: Statistic,
        OnRay { layer, sheets, region, .. }: &OnRay<'_>,
    ) -> Option<Premultiplied> {
        let faces = self.fronts.iter().map(|&front| [front, front + self.thickness]);
        let shares: Vec<f64> = faces.map(|faces| region.share(self.compositing, faces)).collect();
        let full_length = layer.width / 16.0;
        let ends = layer.deciding();
        let found = statistic::of_sheets(statistic, sheets, &shares, ends, full_length);
        let OneForAll { density, counting } = found?;
        let transfer = &layer.layer.transfer;
        let opacity = counting * transfer.opacity(density);
        Some(Premultiplied { color: transfer.color(density).map(|c| opacity * c), opacity })
    }

    /// The sheets with which parts begin: those with two before them, and three behind.
    fn parts_from(&self) -> impl Iterator<Item = usize> {
        2..self.fronts.len().saturating_sub(3)
    }

    /// The depths of the middles of a sheet and the next.
    fn between_middles(&self, first: usize) -> [f64; 2] {
        [first, first + 1].map(|sheet| self.fronts[sheet] + 0.5 * self.thickness)
    }
}

/// Front faces of the sheets from one that no kernel meets to another, so that each that matters has
/// neighbours.
fn fronts(layers: &[DensityLayer<'_>], sheets: &Slabs) -> Vec<f64> {
    let depths = layers.iter().map(DensityLayer::depths).filter(|[near, far]| near <= far);
    let around = depths.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
    let Some([near, far]) = around else { return Vec::new() };
    (sheets.at(near) - 3..=sheets.at(far) + 3).map(|sheet| sheets.face(sheet)).collect()
}

/// A sheet and the next in the middle of six.
fn around(sheets: &[InSheet], first: usize) -> &[InSheet; 6] {
    sheets[first - 2..].first_chunk().expect("there are three sheets behind it")
}
