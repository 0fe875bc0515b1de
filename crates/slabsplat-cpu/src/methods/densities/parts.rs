//! Parts of rays that may be seen: eight at a time they are classified, lit and composited.
//!
//! ```text
//! for each of eight: mean opacity and colour, and where they lie (integrals.rs)
//! for all eight at once, at four places of each:
//!     slopes, normal, light
//! for each: premultiplied colour and opacity, behind what its pixel holds
//! ```
//!
//! One place is not enough: where the density is largest, in the middle of a thin wall, normals turn round
//! within a part, and it would be as dark as if it were seen from the side.

use super::integrals::{Integrals, Mean};
use super::nodes::LANES;
use super::rays::Rays;
use crate::pixels::tile::Tile;
use fearless_simd::Simd;
use slabsplat_core::Compositing;
use slabsplat_traverse::{BlinnPhong8, Light8};

/// What lies between two sheets on the ray of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Column and row in the tile.
    pub(super) pixel: [u8; 2],
    /// How much of the ray it is, in `unit`s.
    pub(super) length: f32,
    /// The scaled densities where it begins and where it ends.
    pub(super) densities: [f32; 2],
    pub(super) slopes: Slopes,
}

/// Slopes of a part: to the right and upwards per world unit, along the ray per sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slopes {
    /// Where it begins.
    pub(super) start: [f32; 3],
    /// Where it ends.
    pub(super) end: [f32; 3],
    /// How much more they are half way than in the mean of both.
    pub(super) bulge: [f32; 3],
}

/// A number for each of eight parts.
type Eight = [f32; LANES];

/// Slopes of eight parts, side by side.
#[derive(Default)]
struct EightSlopes {
    start: [Eight; 3],
    /// From the start to the end.
    change: [Eight; 3],
    /// Four times the bulge.
    bulge: [Eight; 3],
    /// The middle of what is seen of each, and how much of it is seen.
    middle: Eight,
    seen: Eight,
    /// How the rays are slanted.
    slant: [Eight; 2],
}

impl EightSlopes {
    /// Sets those of one part, of which what is seen lies in the mean at `place`.
    #[inline(always)]
    fn set(&mut self, idx: usize, slopes: &Slopes, place: f32, [right, up]: [f32; 2]) {
        for axis in 0..3 {
            self.start[axis][idx] = slopes.start[axis];
            self.change[axis][idx] = slopes.end[axis] - slopes.start[axis];
            self.bulge[axis][idx] = 4.0 * slopes.bulge[axis];
        }
        self.middle[idx] = place;
        // It lies evenly around its mean, as far as the part goes on both sides.
        self.seen[idx] = 2.0 * place.min(1.0 - place);
        (self.slant[0][idx], self.slant[1][idx]) = (right, up);
    }

    /// The slopes at a place of what is seen, counted from its middle.
    #[inline(always)]
    fn slopes_at(&self, at: f32) -> [Eight; 3] {
        let place: Eight = std::array::from_fn(|lane| self.middle[lane] + self.seen[lane] * at);
        let of_axis = |axis: usize| -> Eight {
            let (start, change, bulge) = (&self.start[axis], &self.change[axis], &self.bulge[axis]);
            std::array::from_fn(|lane| {
                let t = place[lane];
                start[lane] + t * change[lane] + t * (1.0 - t) * bulge[lane]
            })
        };
        [of_axis(0), of_axis(1), of_axis(2)]
    }
}

/// Places of a part at which it is lit, counted from its middle: the middles of quarters.
const LIT_AT: [f32; 4] = [-0.375, -0.125, 0.125, 0.375];

/// What parts are classified, lit and composited by.
pub(super) struct PartShader<'a> {
    pub(super) integrals: &'a Integrals,
    pub(super) compositing: Compositing,
    /// By directions to the right, upwards and forward.
    pub(super) light: Option<BlinnPhong8>,
    pub(super) rays: Rays,
    /// A gradient from which on surfaces are lit in full: scaled, per world unit.
    pub(super) faint: f32,
    /// Sheets in a world unit.
    pub(super) per_sheet: f32,
}

impl PartShader<'_> {
    /// Puts parts behind what their pixels hold, in their order. A function of its own, as it takes long to
    /// compile.
    #[inline(never)]
    pub(super) fn composite<S: Simd>(&self, simd: S, parts: &[Part], tile: &mut Tile) {
        simd.vectorize(
            #[inline(always)]
            || self.composite_inlined(simd, parts, tile),
        );
    }

    #[inline(always)]
    fn composite_inlined<S: Simd>(&self, simd: S, parts: &[Part], tile: &mut Tile) {
        for parts in parts.chunks(LANES) {
            let mut means = [Mean::default(); LANES];
            for (mean, part) in means.iter_mut().zip(parts) {
                *mean = self.integrals.mean(part.densities).unwrap_or_default();
            }
            let [diffuse, specular] = self.light_on(simd, parts, &means, tile);
            for (idx, (part, mean)) in parts.iter().zip(means).enumerate() {
                if 0.0 < mean.weight {
                    let lit = |channel: f32| (channel * diffuse[idx] + specular[idx]).min(1.0);
                    let behind = self.resolved(part.length, mean.weight, mean.color.map(lit));
                    tile.put_pixel_behind(part.pixel.map(usize::from), behind);
                }
            }
        }
    }

    /// World units to the right and upwards that the ray of a tile's pixel moves over one unit of depth.
    #[inline(always)]
    fn slant(&self, [column, row]: [u8; 2], tile: &Tile) -> [f32; 2] {
        let [x, y] = tile.origin;
        let pixel = [x + usize::from(column), y + usize::from(row)];
        self.rays.slant(pixel).map(|slant| slant as f32)
    }

    /// What parts' colours are multiplied with, and what is added to them.
    #[inline(always)]
    fn light_on<S: Simd>(
        &self,
        simd: S,
        parts: &[Part],
        means: &[Mean; LANES],
        tile: &Tile,
    ) -> [Eight; 2] {
        let Some(light) = &self.light else { return [[1.0; LANES], [0.0; LANES]] };
        let mut eight = EightSlopes::default();
        for (idx, (part, mean)) in parts.iter().zip(means).enumerate() {
            eight.set(idx, &part.slopes, mean.place, self.slant(part.pixel, tile));
        }
        let (mut diffuse, mut specular) = ([0.0; LANES], [0.0; LANES]);
        for at in LIT_AT {
            let light = self.light_at(simd, light, &eight, at);
            for lane in 0..LANES {
                diffuse[lane] += 0.25 * light.diffuse[lane];
                specular[lane] += 0.25 * light.specular[lane];
            }
        }
        [diffuse, specular]
    }

    /// The light at one place of eight parts. A function of its own: four of them in one take long to
    /// compile.
    #[inline(never)]
    fn light_at<S: Simd>(
        &self,
        simd: S,
        light: &BlinnPhong8,
        eight: &EightSlopes,
        at: f32,
    ) -> Light8 {
        simd.vectorize(
            #[inline(always)]
            || light.of_normals(&self.normals(&eight.slopes_at(at), &eight.slant)),
        )
    }

    /// `−∇d/max(|∇d|, faint)`, to the right, upwards and forward.
    #[inline(always)]
    fn normals(&self, [right, up, along]: &[Eight; 3], slant: &[Eight; 2]) -> [Eight; 3] {
        let mut normals = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            // From a sheet to the next, a pixel moves with its ray.
            let depth = along[lane] * self.per_sheet
                - slant[0][lane] * right[lane]
                - slant[1][lane] * up[lane];
            let squared = right[lane] * right[lane] + up[lane] * up[lane] + depth * depth;
            let factor = -1.0 / squared.sqrt().max(self.faint);
            normals[0][lane] = right[lane] * factor;
            normals[1][lane] = up[lane] * factor;
            normals[2][lane] = depth * factor;
        }
        normals
    }

    /// Premultiplied colour and opacity of a part.
    #[inline(always)]
    fn resolved(&self, length: f32, weight: f32, [r, g, b]: [f32; 3]) -> [f32; 4] {
        let of_color = if self.compositing.weights_colors() { length * weight } else { length };
        let sums = [r * of_color, g * of_color, b * of_color, length * weight];
        self.compositing.resolve(sums.map(f64::from)).map(|channel| channel as f32)
    }
}
