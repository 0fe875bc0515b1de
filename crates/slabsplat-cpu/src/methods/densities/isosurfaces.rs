//! Surfaces of a layer, on which its densities have given values (model §12).
//!
//! ```text
//! for each part between two nodes, of eight pixels at once:
//!     for each value that lies between the densities at both, in the order in which the ray passes them:
//!         the position at which a cubic has it                         (crossing.rs)
//!         fade out where the volume ends; look whether the region holds the position
//!         slopes there, normal, light                                  (normals.rs)
//! ```

use super::crossing::Way;
use super::depths::Depths;
use super::groups::{Group, groups_in};
use super::nodes::{AtNodes, Ends, Rays8};
use super::normals::{Normals, Slopes};
use super::passed::Passed;
use super::sheets::{Eight, LANES, Limits, N_BESIDE, Ring};
use crate::pixels::tile::Tile;
use crate::pixels::tile_region::TileRegion;
use crate::sections::cut::bits;
use fearless_simd::{Simd, f32x8, prelude::*};
use slabsplat_backend::densities::{FADING, ValueScale};
use slabsplat_backend::{LayerPlan, Slabs};
use slabsplat_core::{IsoRange, Isosurface};
use slabsplat_traverse::{BlinnPhong8, Light8};

/// Finds and shades the surfaces of a layer.
pub(super) struct Isosurfaces<'a> {
    /// By value, rising.
    surfaces: Vec<Surface>,
    /// By directions to the right, upwards and forward.
    light: Option<BlinnPhong8>,
    normals: Normals,
    pub(super) depths: Depths<'a>,
    pub(super) limits: Limits,
    fading: Fading,
}

#[derive(Clone, Copy, Debug)]
struct Surface {
    /// Scaled.
    value: f32,
    opacity: f32,
    color: [f32; 3],
}

/// Where volumes end, surfaces do.
#[derive(Clone, Copy, Debug)]
struct Fading {
    /// The length of the ray in a sheet, in `unit`s, from which on a surface shows.
    least: f32,
    /// By how much more it counts for a longer one.
    per_length: f32,
}

impl Fading {
    /// In sheets of that thickness, in `unit`s.
    fn new(thickness: f64) -> Self {
        let [least, most] = FADING.map(|part| part * thickness);
        Self { least: least as f32, per_length: (1.0 / (most - least)) as f32 }
    }

    /// By how much a surface counts where sheets hold so much.
    fn counts(&self, length: f32) -> f32 {
        ((length - self.least) * self.per_length).clamp(0.0, 1.0)
    }
}

/// The values that the surfaces of a layer count as, each a range.
pub(super) fn ranges(layer: &LayerPlan<'_>, scale: &ValueScale) -> Vec<IsoRange> {
    let range = |surface: &Isosurface| {
        let value = scale.value(scale.of_isosurface(surface));
        IsoRange { lo: value, hi: value }
    };
    layer.isosurfaces.iter().map(range).collect()
}

/// Parts of the rays of eight pixels, some of which pass a surface.
struct Passing<'a> {
    densities: [Eight; 2],
    slopes: Slopes,
    /// Slopes along the rays, at both ends.
    along: [Eight; 2],
    slants: [Eight; 2],
    /// How much of the rays the sheets at both ends hold.
    lengths: [Eight; 2],
    /// Which of them pass any, a bit each.
    passing: u64,
    group: Group,
    /// The depths of both ends, and what of a tile is seen.
    depths: [f32; 2],
    region: Option<&'a TileRegion>,
}

/// Where eight rays pass a surface each.
#[derive(Default)]
struct Crossings {
    positions: Eight,
    /// 0 where none is passed.
    opacities: Eight,
    colors: [Eight; 3],
}

impl<'a> Isosurfaces<'a> {
    /// Those of a layer, for values on a scale of which the finite ones have that extent.
    pub(super) fn new(
        layer: &'a LayerPlan<'_>,
        slabs: &'a Slabs,
        (scale, extent): (&ValueScale, f64),
        border: usize,
        limits: Limits,
    ) -> Self {
        let mut surfaces: Vec<Surface> =
            layer.isosurfaces.iter().map(|surface| Surface::new(surface, layer, scale)).collect();
        surfaces.sort_by(|a, b| a.value.total_cmp(&b.value));
        let thickness = slabs.grid.thickness() / layer.volume.grid().unit();
        Self {
            surfaces,
            light: layer
                .light
                .as_ref()
                .map(|light| BlinnPhong8::seen_along(light, layer.view.axes())),
            normals: Normals::new(layer, &slabs.grid, extent, border),
            depths: Depths { slabs: &slabs.grid, view: layer.view },
            limits,
            fading: Fading::new(thickness),
        }
    }

    /// Adds the surfaces that rays pass between the two sheets in the middle, if `last` is the slab of the
    /// last one.
    #[inline(never)]
    pub(super) fn find<S: Simd>(
        &self,
        simd: S,
        (last, ring): (usize, &Ring),
        (tile, region): (&Tile, Option<&TileRegion>),
        passed: &mut Vec<Passed>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.find_inlined(simd, (last, ring), (tile, region), passed),
        );
    }

    #[inline(always)]
    fn find_inlined<S: Simd>(
        &self,
        simd: S,
        (last, ring): (usize, &Ring),
        (tile, region): (&Tile, Option<&TileRegion>),
        passed: &mut Vec<Passed>,
    ) {
        let depths = self.depths.of_nodes(last);
        let sheets = ring.up_to(last);
        // What lies between a sheet and nothing has no density to go to.
        let blocks = sheets[N_BESIDE].held().and(sheets[N_BESIDE + 1].held()).and(tile.open);
        let blocks = region.map_or(blocks, |region| blocks.and(region.showing(depths)));
        let pixels = self.depths.pixel_sizes(last);
        for group in groups_in(blocks) {
            let rays = Rays8::of(simd, &sheets, group.row, group.column);
            let densities = rays.densities(Ends::Nodes);
            let passing = self.passing(simd, densities) & are_held(simd, rays.lengths());
            let passing = if passing == 0 { 0 } else { passing & group.open(tile) };
            if passing == 0 {
                continue;
            }
            let slopes = rays.slopes(simd, &sheets, group.position(), &pixels, Ends::Nodes);
            let parts = Passing {
                densities: densities.map(Into::into),
                along: slopes[2].ends.map(Into::into),
                slopes: Slopes::of(&slopes),
                slants: self.normals.slants(group.first_pixel(tile)),
                lengths: rays.lengths().map(Into::into),
                passing,
                group,
                depths,
                region,
            };
            self.add(simd, &parts, passed);
        }
    }

    /// Which of eight rays pass any surface from one density to another, a bit each.
    #[inline(always)]
    fn passing<S: Simd>(&self, simd: S, [a, b]: AtNodes<S>) -> u64 {
        let (least, largest) = (a.min(b), a.max(b));
        let of_surface = |surface: &Surface| {
            let value = f32x8::splat(simd, surface.value);
            (least.simd_lt(value) & largest.simd_ge(value)).to_bitmask()
        };
        self.surfaces.iter().map(of_surface).fold(0, |passing, more| passing | more)
    }

    /// Adds the surfaces that eight parts pass. A function of its own, as few parts need it.
    #[inline(never)]
    fn add<S: Simd>(&self, simd: S, parts: &Passing<'_>, passed: &mut Vec<Passed>) {
        for nth in 0..self.surfaces.len() {
            let Crossings { positions, opacities, mut colors } =
                parts.crossings(&self.surfaces, nth, &self.fading);
            if opacities == [0.0; LANES] {
                continue;
            }
            let lights = self.lights_at(simd, parts, &positions);
            for (colors, Light8 { diffuse, specular }) in colors.iter_mut().zip(&lights) {
                for (color, light) in colors.iter_mut().zip(diffuse.iter().zip(specular)) {
                    let lit = *color * light.0 + light.1;
                    *color = if lit < 1.0 { lit } else { 1.0 };
                }
            }
            let Passing { group, passing, .. } = *parts;
            let n_before = passed.len();
            passed.push(Passed { group, n_before, passing, positions, opacities, colors });
        }
    }

    /// The light at a position of each of eight parts, for each channel of their colours.
    #[inline(always)]
    fn lights_at<S: Simd>(&self, simd: S, parts: &Passing<'_>, positions: &Eight) -> [Light8; 3] {
        let Some(light) = &self.light else {
            return [Light8 { diffuse: [1.0; LANES], specular: [0.0; LANES] }; 3];
        };
        simd.vectorize(
            #[inline(always)]
            || {
                let normals = self.normals.of(&parts.slopes.at(positions), &parts.slants);
                if light.is_white() {
                    let [of_all] = light.of_normals(&normals);
                    return [of_all; 3];
                }
                light.of_normals(&normals)
            },
        )
    }
}

/// Of which of eight rays both sheets hold something, a bit each.
#[inline(always)]
fn are_held<S: Simd>(simd: S, [a, b]: AtNodes<S>) -> u64 {
    a.min(b).simd_gt(f32x8::splat(simd, 0.0)).to_bitmask()
}

impl Surface {
    fn new(surface: &Isosurface, layer: &LayerPlan<'_>, scale: &ValueScale) -> Self {
        let color = surface.color().unwrap_or_else(|| layer.transfer.color(surface.value()));
        Self {
            value: scale.of_isosurface(surface) as f32,
            opacity: surface.opacity() as f32,
            color: color.map(|channel| channel as f32),
        }
    }
}

impl Passing<'_> {
    /// Where they pass the surfaces that come `nth` on their way.
    fn crossings(&self, surfaces: &[Surface], nth: usize, fading: &Fading) -> Crossings {
        let mut crossings = Crossings::default();
        for lane in bits(self.passing) {
            let [start, end] = self.densities.map(|densities| densities[lane]);
            let is_rising = start < end;
            let surface = surfaces[if is_rising { nth } else { surfaces.len() - 1 - nth }];
            if (start < surface.value) == (end < surface.value) {
                continue;
            }
            let along = self.along.map(|slopes| slopes[lane]);
            let position = Way::new([start, end], along).position_of(surface.value);
            if self.region_holds(lane, position) {
                crossings.positions[lane] = position;
                crossings.opacities[lane] =
                    surface.opacity * fading.counts(self.length(lane, position));
                for (colors, channel) in crossings.colors.iter_mut().zip(surface.color) {
                    colors[lane] = channel;
                }
            }
        }
        crossings
    }

    /// How much sheets hold at a position.
    fn length(&self, lane: usize, position: f32) -> f32 {
        let [first, last] = self.lengths.map(|lengths| lengths[lane]);
        first + position * (last - first)
    }

    fn region_holds(&self, lane: usize, position: f32) -> bool {
        let [front, back] = self.depths;
        let depth = front + position * (back - front);
        self.region
            .is_none_or(|region| region.holds(self.group.row, self.group.column + lane, depth))
    }
}
