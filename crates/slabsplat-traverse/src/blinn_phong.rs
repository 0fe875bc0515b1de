//! Blinn–Phong (model §6): how much light eight normals send to the viewer.

use crate::{NORMAL_STEPS, VoxelRecord};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{BlinnPhong, Light, LightInView, Phong, ViewAxes};

/// [`BlinnPhong`], rounded for eight normals at a time.
///
/// ```
/// use slabsplat_core::{BlinnPhong, Light, Phong, glam::DVec3};
/// use slabsplat_traverse::BlinnPhong8;
///
/// let phong = Phong::default().ambient(0.1).diffuse(0.5);
/// let headlight = BlinnPhong::new(phong, &[Light::default()], DVec3::NEG_Z);
/// // All eight face the viewer, and red is as good as any channel of white light.
/// let [light] = BlinnPhong8::new(&headlight).of_normals(&[[0.0; 8], [0.0; 8], [1.0; 8]]);
/// assert!((light.diffuse[7] - 0.6).abs() < 1e-6);
/// ```
#[derive(Clone, Debug)]
pub struct BlinnPhong8 {
    pub(crate) ambient: f32,
    pub(crate) shininess: Power,
    /// Products from which there are highlights.
    least_facing: f32,
    pub(crate) two_sided: bool,
    lights: [DirectedLight; Light::MAX_LIGHTS],
    n_lights: usize,
    /// Diffuse light of all lights on what has no gradient, times red, green and blue.
    pub(crate) undirected: [f32; 3],
}

/// A light, times what a surface reflects of it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DirectedLight {
    pub(crate) to_light: [f32; 3],
    pub(crate) halfway: [f32; 3],
    /// The coefficients, times the light's red, green and blue.
    pub(crate) diffuse: [f32; 3],
    pub(crate) specular: [f32; 3],
}

/// What a channel `c` of a colour becomes: `c·diffuse + specular`, at most 1.
#[derive(Clone, Copy, Debug)]
pub struct Light8 {
    /// Ambient and diffuse light.
    pub diffuse: [f32; 8],
    /// Highlights.
    pub specular: [f32; 8],
}

/// An exponent. Highlights mostly have small whole ones, which take a few multiplications for all eight
/// instead of a call of `powf` each.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Power {
    Whole(u32),
    Real(f32),
}

/// Every squaring doubles the relative error, which begins as 10⁻⁷.
const MAX_WHOLE_POWER: f64 = 256.0;

/// Highlights below this are none. Powers far below it would pass through subnormal numbers, with which
/// processors are slow.
const LEAST_HIGHLIGHT: f64 = 1e-9;

impl BlinnPhong8 {
    /// The same light.
    pub fn new(light: &BlinnPhong) -> Self {
        Self::of(&light.phong, light.lights.iter().copied())
    }

    /// The same light by other directions: to the right, upwards and forward.
    pub fn seen_along(light: &BlinnPhong, axes: &ViewAxes) -> Self {
        Self::of(&light.phong, light.lights.iter().map(|light| light.seen_along(axes)))
    }

    fn of(phong: &Phong, lights: impl ExactSizeIterator<Item = LightInView>) -> Self {
        let n_lights = lights.len().min(Light::MAX_LIGHTS);
        let shininess = phong.shininess;
        // The planner lets no more lights through.
        let mut directed = [DirectedLight::default(); Light::MAX_LIGHTS];
        for (directed, light) in directed.iter_mut().zip(lights) {
            *directed = DirectedLight::new(phong, &light);
        }
        let mut undirected = [0.0; 3];
        for light in &directed[..n_lights] {
            undirected.iter_mut().zip(light.diffuse).for_each(|(sum, diffuse)| *sum += diffuse);
        }
        let undirected = undirected.map(|sum| phong.zero_gradient as f32 * sum);
        let is_whole = shininess.fract() == 0.0 && shininess <= MAX_WHOLE_POWER;
        Self {
            ambient: phong.ambient as f32,
            shininess: if is_whole {
                Power::Whole(shininess as u32)
            } else {
                Power::Real(shininess as f32)
            },
            least_facing: if 0.0 < shininess {
                LEAST_HIGHLIGHT.powf(1.0 / shininess) as f32
            } else {
                0.0
            },
            two_sided: phong.two_sided,
            lights: directed,
            n_lights,
            undirected,
        }
    }

    #[inline(always)]
    pub(crate) fn lights(&self) -> &[DirectedLight] {
        &self.lights[..self.n_lights]
    }

    /// Whether all light is white, so that one channel stands for all three.
    pub fn is_white(&self) -> bool {
        let is_gray = |[r, g, b]: [f32; 3]| r == g && g == b;
        self.lights().iter().all(|light| is_gray(light.diffuse) && is_gray(light.specular))
    }

    /// The light on eight voxels, in the first channels. Their normals are of length 1 or 0.
    #[inline(always)]
    pub(crate) fn on<const N: usize>(&self, records: &[VoxelRecord; 8]) -> [Light8; N] {
        let mut normals = [[0.0; 8]; 3];
        for (x, record) in records.iter().enumerate() {
            for (components, steps) in normals.iter_mut().zip(record.normal) {
                components[x] = f32::from(steps) * (1.0 / NORMAL_STEPS);
            }
        }
        let squares = squared_lengths(&normals);
        let (mut undirected, mut to_length_1) = ([0.0; 8], [0.0; 8]);
        for x in 0..8 {
            undirected[x] = if squares[x] == 0.0 { 1.0 } else { 0.0 };
            // As in [`VoxelRecord::normal_in_world`].
            to_length_1[x] = 1.5 - 0.5 * squares[x];
        }
        self.light(&normals, &to_length_1, &undirected)
    }

    /// The light on eight normals, x, y and z in world space, none longer than 1: what one lacks of that
    /// faces every light by [`Phong::zero_gradient`], and mirrors none. There are `N` channels of it, from
    /// red on.
    #[inline(always)]
    pub fn of_normals<const N: usize>(&self, normals: &[[f32; 8]; 3]) -> [Light8; N] {
        let mut undirected = squared_lengths(normals);
        for length in &mut undirected {
            let lacking = 1.0 - length.sqrt();
            *length = if 0.0 < lacking { lacking } else { 0.0 };
        }
        self.light(normals, &[1.0; 8], &undirected)
    }

    #[inline(always)]
    fn light<const N: usize>(
        &self,
        normals: &[[f32; 8]; 3],
        to_length_1: &[f32; 8],
        undirected: &[f32; 8],
    ) -> [Light8; N] {
        let mut channels = [Light8 { diffuse: [self.ambient; 8], specular: [0.0; 8] }; N];
        for (channel, of_all) in channels.iter_mut().zip(self.undirected) {
            for (diffuse, undirected) in channel.diffuse.iter_mut().zip(undirected) {
                *diffuse += of_all * undirected;
            }
        }
        for light in self.lights() {
            let n_l = self.facing(normals, to_length_1, light.to_light);
            // From the viewer both are one direction: the usual light, in half the products.
            let mut n_h = if light.halfway == light.to_light {
                n_l
            } else {
                self.facing(normals, to_length_1, light.halfway)
            };
            for n_h in &mut n_h {
                *n_h = if self.least_facing <= *n_h { *n_h } else { 0.0 };
            }
            let highlights = self.shininess.of(&n_h);
            for (idx, channel) in channels.iter_mut().enumerate() {
                let (diffuse, specular) = (light.diffuse[idx], light.specular[idx]);
                for x in 0..8 {
                    channel.diffuse[x] += diffuse * n_l[x];
                    channel.specular[x] +=
                        if 0.0 < n_l[x] { specular * highlights[x] } else { 0.0 };
                }
            }
        }
        channels
    }

    /// Products of normals and a direction, 0 … 1.
    #[inline(always)]
    fn facing(
        &self,
        [x, y, z]: &[[f32; 8]; 3],
        to_length_1: &[f32; 8],
        direction: [f32; 3],
    ) -> [f32; 8] {
        // The sign of products is dropped, or negative ones are made 0, by one maximum.
        let flipped = if self.two_sided { -1.0 } else { 0.0 };
        let mut products = [0.0; 8];
        for i in 0..8 {
            let product = x[i] * direction[0] + y[i] * direction[1] + z[i] * direction[2];
            let product = product * to_length_1[i];
            let product = if flipped * product < product { product } else { flipped * product };
            products[i] = if product < 1.0 { product } else { 1.0 };
        }
        products
    }
}

impl DirectedLight {
    fn new(phong: &Phong, light: &LightInView) -> Self {
        let color = light.color;
        let rounded = |v: DVec3| v.as_vec3().to_array();
        Self {
            to_light: rounded(light.to_light),
            halfway: rounded(light.halfway),
            diffuse: rounded(phong.diffuse * color),
            specular: rounded(phong.specular * color),
        }
    }
}

#[inline(always)]
fn squared_lengths([x, y, z]: &[[f32; 8]; 3]) -> [f32; 8] {
    let mut squares = [0.0; 8];
    for i in 0..8 {
        squares[i] = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
    }
    squares
}

impl Power {
    /// As a number.
    #[inline(always)]
    pub(crate) fn exponent(self) -> f32 {
        match self {
            Self::Whole(exponent) => exponent as f32,
            Self::Real(exponent) => exponent,
        }
    }

    #[inline(always)]
    fn of(self, bases: &[f32; 8]) -> [f32; 8] {
        let mut left = match self {
            Self::Whole(exponent) => exponent,
            Self::Real(exponent) => return bases.map(|base| base.powf(exponent)),
        };
        let (mut squares, mut result) = (*bases, [1.0; 8]);
        loop {
            if left & 1 == 1 {
                multiply(&mut result, &squares);
            }
            left >>= 1;
            if left == 0 {
                return result;
            }
            let square = squares;
            multiply(&mut squares, &square);
        }
    }
}

#[inline(always)]
fn multiply(numbers: &mut [f32; 8], by: &[f32; 8]) {
    for (number, by) in numbers.iter_mut().zip(by) {
        *number *= by;
    }
}
