//! Parts of rays that may be seen: those of eight pixels at once are classified and lit.
//!
//! ```text
//! mean opacity and colour of each, and where they lie (integrals.rs)
//! at four positions of what is seen of each: slopes, normal, light
//! sums = length · opacity · lit colour, which a sheet sums elsewhere
//! ```
//!
//! One position is not enough: where the density is largest, in the middle of a thin wall, normals turn round
//! within a part, and it would be as dark as if it were seen from the side.

use super::super::lit_faces::LitFaces;
use super::integrals::Integrals;
use super::nodes::Parts;
use super::normals::{Normals, Slopes};
use super::sheets::{Eight, LANES};
use fearless_simd::Simd;
use slabsplat_core::{Compositing, View};
use slabsplat_traverse::{BlinnPhong8, Light8};

/// What is seen of eight parts.
struct Seen {
    slopes: Slopes,
    /// The middle of it, and how much of each part it is.
    middles: Eight,
    shares: Eight,
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

impl Seen {
    /// What lies in the mean at those positions.
    #[inline(always)]
    fn of<S: Simd>(parts: &Parts<S>, middles: &Eight, slants: [Eight; 2], lies: Lies) -> Self {
        let mut shares = [0.0; LANES];
        for (share, middle) in shares.iter_mut().zip(middles) {
            // It lies evenly around its mean, as far as the part reaches on both sides.
            *share = 2.0 * middle.min(1.0 - middle);
        }
        Self { slopes: Slopes::of(&parts.slopes), middles: *middles, shares, slants, lies }
    }

    /// Where on each part, from 0 to 1, a position of what is seen is, counted from its middle.
    #[inline(always)]
    fn positions(&self, at: f32) -> Eight {
        let mut positions = [0.0; LANES];
        let seen = self.middles.iter().zip(&self.shares);
        for (position, (middle, share)) in positions.iter_mut().zip(seen) {
            *position = middle + share * at;
        }
        positions
    }
}

/// Positions of a part at which it is lit, counted from its middle: the middles of quarters.
const LIT_AT: [f32; 4] = [-0.375, -0.125, 0.125, 0.375];

/// What parts are classified and lit by.
pub(super) struct PartShader<'a> {
    pub(super) integrals: &'a Integrals,
    pub(super) compositing: Compositing,
    /// By directions to the right, upwards and forward.
    pub(super) light: Option<BlinnPhong8>,
    pub(super) normals: Normals,
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
        let lights = self.lights_on(simd, parts, &means.positions, &through, lies);
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
        positions: &Eight,
        through: &Eight,
        lies: Lies,
    ) -> [[Eight; 2]; 3] {
        match &self.light {
            None => [[[1.0; LANES], [0.0; LANES]]; 3],
            Some(light) if light.is_white() => {
                [self.light_on::<S, 1>(simd, light, parts, positions, through, lies)[0]; 3]
            }
            Some(light) => self.light_on::<S, 3>(simd, light, parts, positions, through, lies),
        }
    }

    /// The mean of four positions, weighted with how much light goes through the quarters before them.
    #[inline(always)]
    fn light_on<S: Simd, const N: usize>(
        &self,
        simd: S,
        light: &BlinnPhong8,
        parts: &Parts<S>,
        positions: &Eight,
        through: &Eight,
        lies: Lies,
    ) -> [[Eight; 2]; N] {
        let seen = Seen::of(parts, positions, self.normals.slants(lies.first_pixel), lies);
        let mut channels = [[[0.0; LANES]; 2]; N];
        let mut weights = [0.0; LANES];
        for lane in 0..LANES {
            let q = through[lane];
            weights[lane] = 1.0 / ((1.0 + q) * (1.0 + q * q));
        }
        for at in LIT_AT {
            let lights: [Light8; N] = self.light_at(simd, light, &seen, at);
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

    /// The light at one position of eight parts. A function of its own: four of them in one take long to
    /// compile.
    #[inline(never)]
    fn light_at<S: Simd, const N: usize>(
        &self,
        simd: S,
        light: &BlinnPhong8,
        seen: &Seen,
        at: f32,
    ) -> [Light8; N] {
        simd.vectorize(
            #[inline(always)]
            || {
                let positions = seen.positions(at);
                let mut normals = self.normals.of(&seen.slopes.at(&positions), &seen.slants);
                if let Some(faces) = &self.faces {
                    self.put_faces(faces, seen.lies, &positions, &mut normals);
                }
                light.of_normals(&normals)
            },
        )
    }

    /// Replaces the normals near lit faces by those of the faces.
    #[inline(never)]
    fn put_faces(
        &self,
        faces: &LitFaces<'_>,
        Lies { first_pixel: [x, y], ends: [front, back] }: Lies,
        positions: &Eight,
        normals: &mut [Eight; 3],
    ) {
        for lane in 0..LANES {
            let pixel = [x + lane, y].map(|p| p as f64 - self.border as f64 + 0.5);
            let ray = self.view.ray(pixel);
            let depth = front + positions[lane] * (back - front);
            let normal = normals.each_mut().map(|components| &mut components[lane]);
            if let Some(face) = faces.at(ray.start + ray.step * f64::from(depth)) {
                let lit_by = face.instead_of(normal.each_ref().map(|component| **component));
                normal.into_iter().zip(lit_by).for_each(|(own, by)| *own = by);
            }
        }
    }
}
