//! Blinn–Phong on cells (model §16): their voxels face many ways, of which a cell knows the mean normal and
//! the share that has none.
//!
//! ```text
//! d = 1 − share without normal      r = |n|/d              how much alike those that have one point
//! m = n·l/d                         v = q·(1 − m²)         mean and variance of their products with a light,
//! q = (1 − r²)/(3 − r²)                                    as if they were spread evenly around the mean,
//! v = lᵀMl/d − m²                                          or, where second moments are known, as they are
//! a = √(m² + ¾·v·v/(v + ½·m²))                             mean of |n·l|, for two-sided light
//! (a + m)/2, (a + m)/2a                                    mean of max(n·l, 0), and the share that faces it
//! f = r/(r + s·(1 − r))             y = n·h/|n|            how much broader highlights become
//! (1 + f·s)/(1 + s)·(r²·y^(f·s) + (1 − r²)·e^(−f·s·(1 − y)))               mean of highlights
//! ```
//!
//! `a` is exact for `m` = 0 and for `v` = 0, and elsewhere off by 0.02 at most, found by sampling.
//! With `r` = 1 all are those of one voxel, with `r` = 0 those of directions that are all alike likely: ½ and
//! ¼. `v` is that of a von Mises–Fisher distribution whose concentration is `r(3 − r²)/(1 − r²)` (Banerjee,
//! Dhillon, Ghosh & Sra, JMLR 6, 2005), and highlights are Toksvig's ("Mipmapping Normal Maps", Journal of
//! Graphics Tools 10(3), 2005), as a power where normals are alike and as an exponential, which has no kink
//! at a right angle, where they are not: off by 0.024 to 0.036 in the mean of squares, without that by 0.05.
//!
//! All goes sixteen cells at a time, without branches on cells.

use crate::Cells16;
use crate::blinn_phong::BlinnPhong8;
use crate::cells::along;

/// Cells that are lit at once.
const N: usize = Cells16::N;

/// What the lights of cells have in common: what there is of directions among their voxels.
struct Facing<'a> {
    cells: &'a Cells16,
    /// `d`, and one over it.
    directed: [f32; N],
    per_directed: [f32; N],
    /// `r`.
    alike: [f32; N],
    /// `q`.
    spread: [f32; N],
}

/// The least of what is divided by: where there is no direction at all, all that depends on one is 0 times
/// something finite.
const LEAST: f32 = 1e-12;

impl<'a> Facing<'a> {
    #[inline(always)]
    fn new(cells: &'a Cells16) -> Self {
        let Cells16 { normals: [x, y, z], undirected, .. } = cells;
        let (mut directed, mut per_directed) = ([0.0; N], [0.0; N]);
        let (mut alike, mut spread) = ([0.0; N], [0.0; N]);
        for i in 0..N {
            let length = (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt();
            // Rounding may have made a normal longer than what has one.
            let d = larger(1.0 - undirected[i], length);
            directed[i] = lesser(d, 1.0);
            per_directed[i] = 1.0 / larger(d, LEAST);
            let r = length * per_directed[i];
            alike[i] = r;
            spread[i] = (1.0 - r * r) / (3.0 - r * r);
        }
        Self { cells, directed, per_directed, alike, spread }
    }

    /// `m`, −1 … 1.
    #[inline(always)]
    fn means(&self, direction: [f32; 3]) -> [f32; N] {
        let [x, y, z] = &self.cells.normals;
        let mut means = [0.0; N];
        for i in 0..N {
            let product = x[i] * direction[0] + y[i] * direction[1] + z[i] * direction[2];
            means[i] = lesser(larger(product * self.per_directed[i], -1.0), 1.0);
        }
        means
    }

    /// `v`, for directions whose means are those.
    #[inline(always)]
    fn variances(&self, means: &[f32; N], direction: [f32; 3]) -> [f32; N] {
        let mut variances = [0.0; N];
        match &self.cells.moments {
            None => {
                for i in 0..N {
                    variances[i] = self.spread[i] * (1.0 - means[i] * means[i]);
                }
            }
            Some([xx, yy, zz, xy, xz, yz]) => {
                for i in 0..N {
                    let square = along([xx[i], yy[i], zz[i], xy[i], xz[i], yz[i]], direction);
                    variances[i] = larger(square * self.per_directed[i] - means[i] * means[i], 0.0);
                }
            }
        }
        variances
    }

    /// The mean of `|n·l|` times `d`, or of its positive part where light is one-sided, and the share of
    /// directions that face the light.
    #[inline(always)]
    fn diffuse(&self, to_light: [f32; 3], two_sided: bool) -> [[f32; N]; 2] {
        let means = self.means(to_light);
        let variances = self.variances(&means, to_light);
        let (mut n_l, mut shares) = ([0.0; N], [1.0; N]);
        for i in 0..N {
            let (m, v) = (means[i], variances[i]);
            let beyond = 0.75 * v * v / larger(v + 0.5 * m * m, LEAST);
            let both_sides = larger(m * m + beyond, LEAST).sqrt();
            let one_side = 0.5 * (both_sides + m);
            n_l[i] = self.directed[i] * if two_sided { both_sides } else { one_side };
            shares[i] = if two_sided { 1.0 } else { one_side / both_sides };
        }
        [n_l, shares]
    }

    /// The mean of highlights, times `d`.
    #[inline(always)]
    fn highlights(&self, halfway: [f32; 3], shininess: f32, two_sided: bool) -> [f32; N] {
        let n_h = self.means(halfway);
        let mut highlights = [0.0; N];
        for i in 0..N {
            let r = self.alike[i];
            let product = lesser(larger(n_h[i] / larger(r, LEAST), -1.0), 1.0);
            let product = if two_sided { product.abs() } else { product };
            let sharper = r / larger(r + shininess * (1.0 - r), LEAST);
            let exponent = sharper * shininess;
            let factor = (1.0 + exponent) / (1.0 + shininess);
            let of_many = exp2_of_negative(larger(exponent * LOG2_E * (product - 1.0), -125.0));
            let of_one = power(larger(product, 0.0), exponent);
            let highlight = factor * (r * r * of_one + (1.0 - r * r) * of_many);
            highlights[i] = self.directed[i] * highlight;
        }
        highlights
    }
}

impl BlinnPhong8 {
    /// Red, green and blue of sixteen cells under this light.
    #[inline(always)]
    pub fn on_cells(&self, cells: &Cells16) -> [[f32; N]; 3] {
        let facing = Facing::new(cells);
        let mut diffuse = [[self.ambient; N]; 3];
        let mut specular = [[0.0; N]; 3];
        for (diffuse, of_all) in diffuse.iter_mut().zip(self.undirected) {
            for (diffuse, undirected) in diffuse.iter_mut().zip(cells.undirected) {
                *diffuse += of_all * undirected;
            }
        }
        let shininess = self.shininess.exponent();
        for light in self.lights() {
            let [n_l, shares] = facing.diffuse(light.to_light, self.two_sided);
            let highlights = facing.highlights(light.halfway, shininess, self.two_sided);
            for channel in 0..3 {
                for i in 0..N {
                    diffuse[channel][i] += light.diffuse[channel] * n_l[i];
                    specular[channel][i] += light.specular[channel] * (shares[i] * highlights[i]);
                }
            }
        }
        let mut lit = [[0.0; N]; 3];
        for channel in 0..3 {
            for i in 0..N {
                let color = cells.colors[channel][i];
                lit[channel][i] = lesser(color * diffuse[channel][i] + specular[channel][i], 1.0);
            }
        }
        lit
    }
}

/// The larger of two numbers, the second if the first is none, as processors have it.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if b < a { a } else { b }
}

/// The lesser, the same way.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// `base^exponent` for bases of 0 … 1, to 2·10⁻⁵ for exponents of up to 100. 0 counts as 2⁻¹²⁷.
#[inline(always)]
fn power(base: f32, exponent: f32) -> f32 {
    exp2_of_negative((exponent * log2(base)).max(-125.0))
}

const LOG2_E: f32 = std::f32::consts::LOG2_E;

/// Fitted to `log2(1 + t)/t` and `(2^t − 1)/t`, `t` in 0 … 1, by least squares.
const LOG2: [f32; 7] = [
    1.442_664,
    -0.720_515_5,
    0.473_113_34,
    -0.324_616_4,
    0.192_385_05,
    -0.078_158_21,
    0.015_127_916,
];
const EXP2: [f32; 5] = [0.693_152_55, 0.240_152_44, 0.055_836_6, 0.008_972_899, 0.001_885_403_8];

#[inline(always)]
fn log2(number: f32) -> f32 {
    let bits = number.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let t = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000) - 1.0;
    exponent as f32 + t * LOG2.iter().rev().fold(0.0, |sum, factor| sum * t + factor)
}

/// Of −125 … 0.
///
/// Adding 2²³ rounds to whole numbers and leaves them in the low bits; a cast takes each number by itself.
#[inline(always)]
fn exp2_of_negative(number: f32) -> f32 {
    let rounded = (number + 126.5) + 8_388_608.0;
    let t = number + 127.0 - (rounded - 8_388_608.0);
    f32::from_bits(rounded.to_bits() << 23)
        * (1.0 + t * EXP2.iter().rev().fold(0.0, |sum, factor| sum * t + factor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CellValues;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{BlinnPhong, Light, LightInView, Phong};
    use slabsplat_seeds::for_each_seed;
    use std::array::from_fn;

    #[test]
    fn power_is_a_power() {
        let (mut worst, mut n) = (0.0_f64, 0);
        for exponent in [0.0_f32, 0.01, 0.5, 1.0, 5.0, 24.0, 100.0] {
            for base in (1..=1000_u16).map(|k| f32::from(k) / 1000.0) {
                let expected = f64::from(base).powf(exponent.into());
                worst = worst.max((f64::from(power(base, exponent)) - expected).abs());
                n += 1;
            }
        }
        assert!(n == 7000 && worst < 2e-5, "{worst}");
        assert_eq!(
            [power(0.0, 20.0), power(1.0, 20.0), power(0.0, 0.0)].map(f32::round),
            [0.0, 1.0, 1.0]
        );
    }

    fn random_direction(rng: &mut fastrand::Rng) -> DVec3 {
        DVec3::new(rng.f64() - 0.5, rng.f64() - 0.5, rng.f64() - 0.5).normalize()
    }

    fn random_light(rng: &mut fastrand::Rng) -> BlinnPhong {
        let phong = Phong::default()
            .ambient(0.3 * rng.f64())
            .diffuse(rng.f64())
            .zero_gradient(rng.f64())
            .specular(0.5 * rng.f64())
            .shininess([0.0, 3.0, 20.0, 50.0][rng.usize(..4)])
            .two_sided(rng.bool());
        let mut light = || match rng.bool() {
            true => Light::default(),
            false => Light::towards(random_direction(rng)).unwrap().color([0.5, 1.0, 0.25]),
        };
        let lights = [light(), light()];
        let forward = random_direction(rng);
        BlinnPhong { phong, lights: lights.map(|light| LightInView::new(light, forward)).to_vec() }
    }

    fn sixteen(cells: &[CellValues; N], moments: Option<[[f32; 6]; N]>) -> Cells16 {
        Cells16 {
            extinctions: cells.map(|cell| cell.extinction),
            colors: from_fn(|channel| cells.map(|cell| cell.color[channel])),
            normals: from_fn(|axis| cells.map(|cell| cell.normal[axis])),
            undirected: cells.map(|cell| cell.undirected),
            moments: moments.map(|of_cells| from_fn(|which| of_cells.map(|of| of[which]))),
        }
    }

    /// The definition of model §16, in 64 bits.
    fn naive(light: &BlinnPhong, cell: &CellValues, moments: Option<[f32; 6]>) -> [f64; 3] {
        let Phong { ambient, diffuse, zero_gradient, specular, shininess: s, two_sided, .. } =
            light.phong;
        let n = DVec3::from_array(cell.normal.map(f64::from));
        let undirected = f64::from(cell.undirected);
        let d = (1.0 - undirected).max(n.length());
        let r = n.length() / d.max(1e-12);
        let q = (1.0 - r * r) / (3.0 - r * r);
        let color = DVec3::from_array(cell.color.map(f64::from));
        let (mut of_color, mut added) = (DVec3::splat(ambient), DVec3::ZERO);
        for LightInView { to_light, halfway, color } in &light.lights {
            let m = n.dot(*to_light) / d.max(1e-12);
            let v = match moments {
                None => q * (1.0 - m * m),
                Some(moments) => {
                    let [xx, yy, zz, xy, xz, yz] = moments.map(f64::from);
                    let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(DVec3::from);
                    let square = to_light.dot(DVec3::from(rows.map(|row| row.dot(*to_light))));
                    (square / d.max(1e-12) - m * m).max(0.0)
                }
            };
            let both = (m * m + 0.75 * v * v / (v + 0.5 * m * m).max(1e-12)).max(1e-12).sqrt();
            let one = 0.5 * (both + m);
            let n_l = d * if two_sided { both } else { one };
            of_color += diffuse * *color * (n_l + zero_gradient * undirected);
            let share = if two_sided { 1.0 } else { one / both };
            let y = n.dot(*halfway) / n.length().max(1e-12);
            let y = if two_sided { y.abs() } else { y }.clamp(-1.0, 1.0);
            let f = r / (r + s * (1.0 - r)).max(1e-12);
            let of_one = y.clamp(2_f64.powi(-127), 1.0).powf(f * s);
            let highlight = r * r * of_one + (1.0 - r * r) * (f * s * (y - 1.0)).exp();
            added += specular * *color * d * share * (1.0 + f * s) / (1.0 + s) * highlight;
        }
        (color * of_color + added).min(DVec3::ONE).to_array()
    }

    #[test]
    fn cell_light_is_the_definition() {
        for_each_seed(1, |mut rng| {
            for _ in 0..200 {
                let light = random_light(&mut rng);
                let cells = [0; N].map(|_| {
                    let undirected = [0.0, 1.0, 0.5, rng.f32()][rng.usize(..4)];
                    let length = (1.0 - undirected) * [0.0, 1.0, rng.f32()][rng.usize(..3)];
                    let normal = (random_direction(&mut rng) * f64::from(length)).as_vec3();
                    let color = [0; 3].map(|_| rng.f32());
                    CellValues { extinction: 1.0, color, normal: normal.to_array(), undirected }
                });
                // Of a random matrix, whether it can be that of normals or not.
                let moments = rng.bool().then(|| [0; N].map(|_| [0; 6].map(|_| 0.5 * rng.f32())));
                let lit = BlinnPhong8::new(&light).on_cells(&sixteen(&cells, moments));
                for (idx, cell) in cells.iter().enumerate() {
                    let expected = naive(&light, cell, moments.map(|of| of[idx]));
                    for (channel, expected) in lit.iter().zip(expected) {
                        let off = (f64::from(channel[idx]) - expected).abs();
                        assert!(off < 1e-4, "{off}: {cell:?} {:?}", light.phong);
                    }
                }
            }
        });
    }

    /// Of one direction it is a voxel's light, and of many nearly the mean of theirs.
    #[test]
    fn cell_light_is_near_the_mean_of_its_voxels() {
        let mut worst = [0.0_f64; 3];
        for_each_seed(1, |mut rng| {
            for _ in 0..100 {
                let any = random_light(&mut rng);
                let phong = Phong::default().two_sided(any.phong.two_sided);
                let light = BlinnPhong { phong, lights: any.lights[..1].to_vec() };
                let mean = random_direction(&mut rng);
                let width = [0.0, 0.2, 0.5, 1.0, 3.0][rng.usize(..5)];
                let voxels: Vec<DVec3> = (0..64)
                    .map(|_| (mean + width * rng.f64() * random_direction(&mut rng)).normalize())
                    .collect();
                let color = DVec3::splat(0.5);
                let expected = voxels.iter().map(|&n| light.lit(color, n)).sum::<DVec3>() / 64.0;
                let normal = (voxels.iter().sum::<DVec3>() / 64.0).as_vec3().to_array();
                let color = color.as_vec3().to_array();
                let cell = CellValues { extinction: 1.0, color, normal, undirected: 0.0 };
                let mut moments = [0.0; 6];
                for n in &voxels {
                    let of_voxel =
                        [n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.x * n.z, n.y * n.z];
                    moments.iter_mut().zip(of_voxel).for_each(|(sum, it)| *sum += it as f32 / 64.0);
                }
                let light8 = BlinnPhong8::new(&light);
                for (is_known, moments) in [(false, None), (true, Some([moments; N]))] {
                    let lit = light8.on_cells(&sixteen(&[cell; N], moments));
                    let off = (DVec3::from_array(lit.map(|of| of[0].into())) - expected).abs();
                    let kind = if width == 0.0 { 0 } else { 1 + usize::from(is_known) };
                    worst[kind] = worst[kind].max(off.max_element());
                }
            }
        });
        let [of_one, of_many, with_moments] = worst;
        println!("off by {of_one:.1e} for one direction, {of_many:.3}, {with_moments:.3} for many");
        assert!(of_one < 1e-4 && of_many < 0.05 && with_moments < 0.03, "{worst:?}");
    }
}
