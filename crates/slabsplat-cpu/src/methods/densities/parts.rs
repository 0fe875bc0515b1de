//! Parts of rays that may be seen: those of eight pixels at once are classified and lit.
//!
//! ```text
//! mean opacity and colour of each, and where they lie (integrals.rs)
//! at four places of what is seen of each: slopes, normal, light
//! sums = length · opacity · lit colour, which a sheet sums elsewhere
//! ```
//!
//! One place is not enough: where the density is largest, in the middle of a thin wall, normals turn round
//! within a part, and it would be as dark as if it were seen from the side.

use super::super::lit_faces::LitFaces;
use super::integrals::Integrals;
use super::nodes::Parts;
use super::rays::Rays;
use super::sheets::{Eight, LANES};
use fearless_simd::Simd;
use slabsplat_core::{Compositing, View};
use slabsplat_traverse::{BlinnPhong8, Light8};

/// Slopes of eight parts.
struct Slopes {
    /// Where they begin: to the right and upwards per world unit, along the ray per sheet.
    starts: [Eight; 3],
    /// From the start to the end.
    changes: [Eight; 3],
    /// Four times how much more they are half way than in the mean of both.
    bulges: [Eight; 3],
    /// The middle of what is seen of each, and how much of it is seen.
    middles: Eight,
    seen: Eight,
    /// How the rays are slanted.
    slants: [Eight; 2],
    lies: Lies,
}

/// Where eight parts lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lies {
    /// The first of their pixels, from the corner of the image's border.
    pub(super) first_pixel: [usize; 2],
    /// The depths between which they lie.
    pub(super) ends: [f32; 2],
}

impl Slopes {
    /// Those of parts of which what is seen lies in the mean at those places.
    #[inline(always)]
    fn of<S: Simd>(parts: &Parts<S>, places: &Eight, slants: [Eight; 2], lies: Lies) -> Self {
        let mut slopes = Self {
            starts: [[0.0; LANES]; 3],
            changes: [[0.0; LANES]; 3],
            bulges: [[0.0; LANES]; 3],
            middles: *places,
            seen: [0.0; LANES],
            slants,
            lies,
        };
        for (axis, slope) in parts.slopes.iter().enumerate() {
            let [start, end] = slope.ends;
            slopes.starts[axis] = start.into();
            slopes.changes[axis] = (end - start).into();
            slopes.bulges[axis] = (slope.bulge * 4.0).into();
        }
        for (seen, place) in slopes.seen.iter_mut().zip(places) {
            // It lies evenly around its mean, as far as the part goes on both sides.
            *seen = 2.0 * place.min(1.0 - place);
        }
        slopes
    }

    /// Where on its part, from 0 to 1, a place of what is seen is, counted from its middle.
    #[inline(always)]
    fn place(&self, lane: usize, at: f32) -> f32 {
        self.middles[lane] + self.seen[lane] * at
    }

    /// The slopes at a place of what is seen, counted from its middle.
    #[inline(always)]
    fn at(&self, at: f32) -> [Eight; 3] {
        let mut slopes = [[0.0; LANES]; 3];
        for (axis, slopes) in slopes.iter_mut().enumerate() {
            let (starts, changes) = (&self.starts[axis], &self.changes[axis]);
            for lane in 0..LANES {
                let t = self.place(lane, at);
                let curve = t * (1.0 - t) * self.bulges[axis][lane];
                slopes[lane] = starts[lane] + t * changes[lane] + curve;
            }
        }
        slopes
    }
}

/// Places of a part at which it is lit, counted from its middle: the middles of quarters.
const LIT_AT: [f32; 4] = [-0.375, -0.125, 0.125, 0.375];

/// What parts are classified and lit by.
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
    /// Faces of the region, if they are lit.
    pub(super) faces: Option<LitFaces<'a>>,
    pub(super) view: View,
    /// Pixels of the border of the image.
    pub(super) border: usize,
}

impl PartShader<'_> {
    /// What a sheet sums of parts: red, green, blue and weight; of those that may not be seen a weight of 0.
    ///
    /// A function of its own, as it takes long to compile.
    #[inline(never)]
    pub(super) fn sums<S: Simd>(&self, simd: S, parts: &Parts<S>, lies: Lies) -> [Eight; 4] {
        simd.vectorize(
            #[inline(always)]
            || self.sums_inlined(simd, parts, lies),
        )
    }

    #[inline(always)]
    fn sums_inlined<S: Simd>(&self, simd: S, parts: &Parts<S>, lies: Lies) -> [Eight; 4] {
        let [starts, ends] = parts.densities;
        let means = self.integrals.means(simd, [starts.into(), ends.into()], parts.seen);
        let lengths: Eight = parts.lengths.into();
        let mut sums = [[0.0; LANES]; 4];
        for lane in 0..LANES {
            sums[3][lane] = lengths[lane] * means.weights[lane];
        }
        let through = self.through_quarters(&sums[3]);
        let lights = self.lights_on(simd, parts, &means.places, &through, lies);
        let of_colors = if self.compositing.weights_colors() { sums[3] } else { lengths };
        for ((sums, colors), light) in sums.iter_mut().zip(&means.colors).zip(&lights) {
            let [diffuse, specular] = light;
            for lane in 0..LANES {
                let lit = colors[lane] * diffuse[lane] + specular[lane];
                let lit = if lit < 1.0 { lit } else { 1.0 };
                sums[lane] = of_colors[lane] * lit;
            }
        }
        sums
    }

    /// What each channel of parts' colours is multiplied with, and what is added to it.
    #[inline(always)]
    fn lights_on<S: Simd>(
        &self,
        simd: S,
        parts: &Parts<S>,
        places: &Eight,
        through: &Eight,
        lies: Lies,
    ) -> [[Eight; 2]; 3] {
        match &self.light {
            None => [[[1.0; LANES], [0.0; LANES]]; 3],
            Some(light) if light.is_white() => {
                [self.light_on::<S, 1>(simd, light, parts, places, through, lies)[0]; 3]
            }
            Some(light) => self.light_on::<S, 3>(simd, light, parts, places, through, lies),
        }
    }

    /// The mean of four places, weighted with how much light goes through the quarters before them.
    #[inline(always)]
    fn light_on<S: Simd, const N: usize>(
        &self,
        simd: S,
        light: &BlinnPhong8,
        parts: &Parts<S>,
        places: &Eight,
        through: &Eight,
        lies: Lies,
    ) -> [[Eight; 2]; N] {
        let slopes = Slopes::of(parts, places, self.rays.slants(lies.first_pixel), lies);
        let mut channels = [[[0.0; LANES]; 2]; N];
        let mut weights = [0.0; LANES];
        for lane in 0..LANES {
            let q = through[lane];
            weights[lane] = 1.0 / ((1.0 + q) * (1.0 + q * q));
        }
        for at in LIT_AT {
            let lights: [Light8; N] = self.light_at(simd, light, &slopes, at);
            for ([diffuse, specular], light) in channels.iter_mut().zip(&lights) {
                for lane in 0..LANES {
                    diffuse[lane] += weights[lane] * light.diffuse[lane];
                    specular[lane] += weights[lane] * light.specular[lane];
                }
            }
            for (weight, through) in weights.iter_mut().zip(through) {
                *weight *= through;
            }
        }
        channels
    }

    /// How much light goes through a quarter of each part, of which a sheet sums that.
    #[inline(always)]
    fn through_quarters(&self, weights: &Eight) -> Eight {
        if !self.compositing.sums_extinction() {
            return [1.0; LANES];
        }
        let mut through = [0.0; LANES];
        for (through, weight) in through.iter_mut().zip(weights) {
            // e^(−τ/4) as the fourth power of 1/e^(τ/16), which is a short series.
            let x = weight * (1.0 / 16.0);
            let series = 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0))));
            let root = 1.0 / (series * series);
            *through = root * root;
        }
        through
    }

    /// The light at one place of eight parts. A function of its own: four of them in one take long to
    /// compile.
    #[inline(never)]
    fn light_at<S: Simd, const N: usize>(
        &self,
        simd: S,
        light: &BlinnPhong8,
        slopes: &Slopes,
        at: f32,
    ) -> [Light8; N] {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut normals = self.normals(&slopes.at(at), &slopes.slants);
                if let Some(faces) = &self.faces {
                    self.put_faces(faces, slopes, at, &mut normals);
                }
                light.of_normals(&normals)
            },
        )
    }

    /// Puts the normals of lit faces in the place of those near them.
    #[inline(never)]
    fn put_faces(&self, faces: &LitFaces<'_>, slopes: &Slopes, at: f32, normals: &mut [Eight; 3]) {
        let Lies { first_pixel: [x, y], ends: [front, back] } = slopes.lies;
        for lane in 0..LANES {
            let pixel = [x + lane, y].map(|p| p as f64 - self.border as f64 + 0.5);
            let ray = self.view.ray(pixel);
            let depth = front + slopes.place(lane, at) * (back - front);
            let normal = normals.each_mut().map(|components| &mut components[lane]);
            if let Some(face) = faces.at(ray.start + ray.step * f64::from(depth)) {
                let lit_by = face.instead_of(normal.each_ref().map(|component| **component));
                normal.into_iter().zip(lit_by).for_each(|(own, by)| *own = by);
            }
        }
    }

    /// `−∇d/max(|∇d|, faint)`, to the right, upwards and forward.
    #[inline(always)]
    fn normals(&self, [right, up, along]: &[Eight; 3], slants: &[Eight; 2]) -> [Eight; 3] {
        let mut normals = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            // From a sheet to the next, a pixel moves with its ray.
            let depth = along[lane] * self.per_sheet
                - slants[0][lane] * right[lane]
                - slants[1][lane] * up[lane];
            let squared = right[lane] * right[lane] + up[lane] * up[lane] + depth * depth;
            let factor = -1.0 / squared.sqrt().max(self.faint);
            normals[0][lane] = right[lane] * factor;
            normals[1][lane] = up[lane] * factor;
            normals[2][lane] = depth * factor;
        }
        normals
    }
}
