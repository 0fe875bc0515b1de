//! What light does to a colour (model §6).

use glam::DVec3;

use crate::settings_table::{Settings, settings};
use crate::{Interval, Light, LightInView, OutOfRange};

/// How a voxel's colour is found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_enums, reason = "backends have to know each")]
pub enum Shading {
    /// The transfer function's colour as it is.
    None,
    /// Blinn–Phong.
    Phong(Phong),
}

settings! {
    /// Blinn–Phong: `c·(k_a + Σ k_d·L·(n·l + k_0·(1 − |n|))) + Σ k_s·L·(n·h)^s` over all lights, clamped to
    /// 0 … 1 ([model §6](crate::model)).
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[non_exhaustive]
    pub struct Phong {
        /// Ambient light, which comes from everywhere.
        /// `k_a`.
        ambient: f64 = 0.1, number("K", COEFFICIENTS);

        /// Diffuse light, which a surface scatters.
        /// `k_d`.
        diffuse: f64 = 0.7, number("K", COEFFICIENTS);

        /// Diffuse light where there is no gradient, as a share of what faces every light.
        /// `k_0`: 1 leaves constant regions as bright as surfaces that face the lights, 0 as dark as those
        /// that are averted.
        zero_gradient: f64 = 1.0, number("K", SHARE);

        /// Specular light, which a surface mirrors.
        /// `k_s`.
        specular: f64 = 0.2, number("K", COEFFICIENTS);

        /// How sharp the highlight is.
        /// The exponent `s`.
        shininess: f64 = 20.0, number("EXPONENT", COEFFICIENTS);

        /// Whether a surface is lit from behind too.
        /// The absolute values of both products then count.
        two_sided: bool = true, switch;
    }
}

const COEFFICIENTS: Interval = Interval::at_least(0.0);
const SHARE: Interval = Interval::at_least(0.0).at_most(1.0);

impl Phong {
    /// The same, if its coefficients can be used.
    ///
    /// # Errors
    /// If a coefficient is negative or not finite.
    pub fn checked(self) -> Result<Self, OutOfRange> {
        self.check_ranges()?;
        Ok(self)
    }
}

/// [`Phong`] under some lights, for one viewer. Normals are in world space.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "model §6 has no more")]
pub struct BlinnPhong {
    /// The coefficients.
    pub phong: Phong,
    /// The lights.
    pub lights: Vec<LightInView>,
}

impl BlinnPhong {
    /// For a viewer who looks along `forward`, of length 1.
    pub fn new(phong: Phong, lights: &[Light], forward: DVec3) -> Self {
        Self {
            phong,
            lights: lights.iter().map(|&light| LightInView::new(light, forward)).collect(),
        }
    }

    /// What `color` becomes on a surface with that normal, which is no longer than 1: what it lacks of that
    /// faces every light by the share `k_0`, and mirrors none.
    #[inline]
    pub fn lit(&self, color: DVec3, normal: DVec3) -> DVec3 {
        let Phong { ambient, diffuse, zero_gradient, specular, shininess, two_sided } = self.phong;
        let facing = |direction: DVec3| {
            let product = normal.dot(direction);
            if two_sided { product.abs() } else { product.max(0.0) }
        };
        let (mut diffuse_light, mut specular_light) = (DVec3::splat(ambient), DVec3::ZERO);
        let undirected = zero_gradient * (1.0 - normal.length()).max(0.0);
        for light in &self.lights {
            let n_l = facing(light.to_light);
            diffuse_light += diffuse * (n_l + undirected) * light.color;
            if 0.0 < n_l {
                specular_light += specular * facing(light.halfway).powf(shininess) * light.color;
            }
        }
        (color * diffuse_light + specular_light).clamp(DVec3::ZERO, DVec3::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phong_rejects_bad_coefficients() {
        assert!(Phong::default().checked().is_ok());
        assert!(Phong::default().zero_gradient(1.1).checked().is_err());
        for bad in [-0.1, f64::NAN, f64::INFINITY] {
            let err = Phong::default().shininess(bad).checked().unwrap_err();
            assert!(err.to_string().starts_with("shininess"), "{err}");
        }
    }

    /// The light stands to the right, and the viewer looks along −z.
    #[test]
    fn lit_adds_ambient_diffuse_and_highlight() {
        let phong = Phong::default().ambient(0.1).diffuse(0.5).specular(0.25).shininess(2.0);
        let light = Light::towards(DVec3::X).unwrap();
        let check = |two_sided: bool, normal: DVec3, expected: f64| {
            let shaded = BlinnPhong::new(phong.two_sided(two_sided), &[light], DVec3::NEG_Z);
            let lit = shaded.lit(DVec3::new(1.0, 0.5, 0.0), normal);
            let highlight = shaded.lit(DVec3::ZERO, normal).x;
            let colored = expected - highlight;
            let expected = DVec3::new(expected, 0.5 * colored + highlight, highlight);
            assert!(lit.abs_diff_eq(expected, 1e-12), "{two_sided} {normal}: {lit} {expected}");
        };
        // h lies half way between x and z, and cos² 45° is a half.
        check(false, DVec3::X, 0.1 + 0.5 + 0.25 * 0.5);
        check(false, DVec3::X * 0.5, 0.1 + 0.25 + 0.25 + 0.25 * 0.125);
        check(false, DVec3::ZERO, 0.1 + 0.5);
        let dark = BlinnPhong::new(phong.zero_gradient(0.0), &[light], DVec3::NEG_Z);
        assert_eq!(dark.lit(DVec3::ONE, DVec3::ZERO), DVec3::splat(0.1));
        check(false, DVec3::new(1.0, 0.0, 1.0).normalize(), 0.1 + 0.5 * 0.5_f64.sqrt() + 0.25);
        // No light falls on it, so none is reflected.
        check(false, DVec3::Z, 0.1);
        check(true, DVec3::Z, 0.1);
        check(false, DVec3::NEG_X, 0.1);
        check(true, DVec3::NEG_X, 0.1 + 0.5 + 0.25 * 0.5);
        let bright = BlinnPhong::new(phong.ambient(3.0), &[light], DVec3::NEG_Z);
        assert_eq!(bright.lit(DVec3::ONE, DVec3::X), DVec3::ONE);
    }

    #[test]
    fn lit_adds_lights_by_color() {
        let phong = Phong::default().ambient(0.1).diffuse(0.5).specular(0.0).two_sided(false);
        let [red, green] = [[0.8, 0.0, 0.0], [0.0, 0.4, 0.0]];
        let lights = [
            Light::towards(DVec3::X).unwrap().color(red),
            Light::towards(DVec3::Y).unwrap().color(green),
        ];
        let lit = BlinnPhong::new(phong, &lights, DVec3::NEG_Z).lit(DVec3::ONE, DVec3::X);
        assert!(lit.abs_diff_eq(DVec3::new(0.5, 0.1, 0.1), 1e-12), "{lit}");
        let dark = BlinnPhong::new(phong, &[], DVec3::NEG_Z).lit(DVec3::ONE, DVec3::X);
        assert_eq!(dark, DVec3::splat(0.1));
    }
}
