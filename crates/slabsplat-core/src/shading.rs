//! What light does to a colour (model §6).

use std::fmt;

use glam::DVec3;
use thiserror::Error;

use crate::settings_table::{Settings, settings};
use crate::{Interval, OutOfRange, ViewAxes};

/// How a voxel's colour is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shading {
    /// The transfer function's colour as it is.
    None,
    /// Blinn–Phong.
    Phong(Phong),
}

settings! {
    /// Blinn–Phong: `c·(k_a + k_d·n·l) + k_s·(n·h)^s`, clamped to 0 … 1 (model §6).
    #[derive(Clone, Copy, Debug, PartialEq)]
    #[non_exhaustive]
    pub struct Phong {
        /// Ambient light, which comes from everywhere.
        /// `k_a`.
        ambient: f64 = 0.1, number("K", COEFFICIENTS);

        /// Diffuse light, which a surface scatters.
        /// `k_d`.
        diffuse: f64 = 0.7, number("K", COEFFICIENTS);

        /// Specular light, which a surface mirrors.
        /// `k_s`.
        specular: f64 = 0.2, number("K", COEFFICIENTS);

        /// How sharp the highlight is.
        /// The exponent `s`.
        shininess: f64 = 20.0, number("EXPONENT", COEFFICIENTS);

        /// Whether a surface is lit from behind too.
        /// The absolute values of both products then count.
        two_sided: bool = true, switch;

        /// Where the light comes from: headlight, or a direction towards it.
        light: Light = Light::Headlight, light;
    }
}

const COEFFICIENTS: Interval = Interval::at_least(0.0);

/// A light infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// It shines along the viewing direction.
    Headlight,
    /// It stays where it is in the world; made by [`Light::towards`].
    Direction(LightDirection),
}

/// The world direction towards a light; of length 1, or it would brighten what it shines on.
///
/// ```compile_fail
/// use slabsplat_core::{Light, LightDirection, glam::DVec3};
///
/// let light = Light::Direction(LightDirection(DVec3::X * 5.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightDirection(DVec3);

impl LightDirection {
    /// The direction, of length 1.
    pub fn get(self) -> DVec3 {
        self.0
    }
}

/// Why a shading cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ShadingError {
    /// A coefficient is negative, NaN or infinite.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// The light's direction is zero or not finite.
    #[error("the light's direction must be a finite vector other than zero, not {0}")]
    BadLight(DVec3),
}

impl Phong {
    /// The same, if its coefficients can be used.
    ///
    /// # Errors
    /// If a coefficient is negative or not finite.
    pub fn checked(self) -> Result<Self, ShadingError> {
        self.check_ranges()?;
        Ok(self)
    }
}

impl ShadingError {
    /// The name of the setting that a person should look at.
    pub fn setting(&self) -> &'static str {
        match self {
            Self::OutOfRange(OutOfRange { name, .. }) => name,
            Self::BadLight(_) => "light",
        }
    }
}

impl fmt::Display for Light {
    /// As a flag takes it: `headlight`, or three numbers.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Headlight => f.write_str("headlight"),
            Self::Direction(LightDirection(DVec3 { x, y, z })) => write!(f, "{x},{y},{z}"),
        }
    }
}

impl Light {
    /// A light far away in `direction` (any length).
    ///
    /// # Errors
    /// If the direction is zero or not finite.
    pub fn towards(direction: DVec3) -> Result<Self, ShadingError> {
        // Squares of very long or short vectors would leave the range of numbers.
        let scaled = direction / direction.abs().max_element();
        let unit = scaled.try_normalize().ok_or(ShadingError::BadLight(direction))?;
        Ok(Self::Direction(LightDirection(unit)))
    }

    /// `l`, the world direction towards the light, for a viewer that looks along `forward`.
    pub fn to_light(self, forward: DVec3) -> DVec3 {
        match self {
            Self::Headlight => -forward,
            Self::Direction(LightDirection(to_light)) => to_light,
        }
    }

    /// `h = (l + v)/|l + v|`, the world direction half way between light and viewer; zero if the light shines
    /// straight at the viewer.
    pub fn halfway(self, forward: DVec3) -> DVec3 {
        (self.to_light(forward) - forward).normalize_or_zero()
    }
}

/// [`Phong`] for one viewer, who is infinitely far away, as the light is. Normals are in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlinnPhong {
    /// The coefficients.
    pub phong: Phong,
    /// `l`, the direction towards the light.
    pub to_light: DVec3,
    /// `h`, half way between light and viewer; zero if the light shines straight at the viewer.
    pub halfway: DVec3,
}

impl BlinnPhong {
    /// For a viewer who looks along `forward`, of length 1.
    pub fn new(phong: Phong, forward: DVec3) -> Self {
        let (to_light, halfway) = (phong.light.to_light(forward), phong.light.halfway(forward));
        Self { phong, to_light, halfway }
    }

    /// The same light by other directions: to the right, upwards and forward.
    pub fn seen_along(&self, axes: &ViewAxes) -> Self {
        let seen = |v: DVec3| DVec3::new(v.dot(axes.right), v.dot(axes.up), v.dot(axes.forward));
        Self { phong: self.phong, to_light: seen(self.to_light), halfway: seen(self.halfway) }
    }

    /// What `color` becomes on a surface with that normal, which is no longer than 1: a faint surface has a
    /// shorter one, and gets less than the full light.
    #[inline]
    pub fn lit(&self, color: DVec3, normal: DVec3) -> DVec3 {
        let Phong { ambient, diffuse, specular, shininess, two_sided, .. } = self.phong;
        let facing = |direction: DVec3| {
            let product = normal.dot(direction);
            if two_sided { product.abs() } else { product.max(0.0) }
        };
        let n_l = facing(self.to_light);
        let highlight =
            if 0.0 < n_l { specular * facing(self.halfway).powf(shininess) } else { 0.0 };
        (color * (ambient + diffuse * n_l) + highlight).clamp(DVec3::ZERO, DVec3::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phong_rejects_bad_coefficients() {
        assert!(Phong::default().checked().is_ok());
        for bad in [-0.1, f64::NAN, f64::INFINITY] {
            let err = Phong::default().shininess(bad).checked().unwrap_err();
            assert!(err.to_string().starts_with("shininess"), "{err}");
        }
    }

    #[test]
    fn light_direction_has_length_one() {
        for length in [1e-300, 0.2, 5.0, 1e300] {
            let light = Light::towards(DVec3::X * length).unwrap();
            assert_eq!(light.to_light(DVec3::Z), DVec3::X, "{length}");
        }
        for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(Light::towards(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn light_halfway_to_the_viewer() {
        assert_eq!(Light::Headlight.to_light(DVec3::Z), DVec3::NEG_Z);
        assert_eq!(Light::Headlight.halfway(DVec3::Z), DVec3::NEG_Z);
        let aside = Light::towards(DVec3::X).unwrap().halfway(DVec3::NEG_X);
        assert_eq!(aside, DVec3::X);
        assert_eq!(Light::towards(DVec3::Z).unwrap().halfway(DVec3::Z), DVec3::ZERO);
    }

    /// The light stands to the right, and the viewer looks along −z.
    #[test]
    fn lit_adds_ambient_diffuse_and_highlight() {
        let phong = Phong::default()
            .ambient(0.1)
            .diffuse(0.5)
            .specular(0.25)
            .shininess(2.0)
            .light(Light::towards(DVec3::X).unwrap());
        let check = |two_sided: bool, normal: DVec3, expected: f64| {
            let shaded = BlinnPhong::new(phong.two_sided(two_sided), DVec3::NEG_Z);
            let lit = shaded.lit(DVec3::new(1.0, 0.5, 0.0), normal);
            let highlight = shaded.lit(DVec3::ZERO, normal).x;
            let colored = expected - highlight;
            let expected = DVec3::new(expected, 0.5 * colored + highlight, highlight);
            assert!(lit.abs_diff_eq(expected, 1e-12), "{two_sided} {normal}: {lit} {expected}");
        };
        // h lies half way between x and z, and cos² 45° is a half.
        check(false, DVec3::X, 0.1 + 0.5 + 0.25 * 0.5);
        check(false, DVec3::X * 0.5, 0.1 + 0.25 + 0.25 * 0.125);
        check(false, DVec3::new(1.0, 0.0, 1.0).normalize(), 0.1 + 0.5 * 0.5_f64.sqrt() + 0.25);
        // No light falls on it, so none is reflected.
        check(false, DVec3::Z, 0.1);
        check(true, DVec3::Z, 0.1);
        check(false, DVec3::NEG_X, 0.1);
        check(true, DVec3::NEG_X, 0.1 + 0.5 + 0.25 * 0.5);
        let bright = BlinnPhong::new(phong.ambient(3.0), DVec3::NEG_Z);
        assert_eq!(bright.lit(DVec3::ONE, DVec3::X), DVec3::ONE);
    }

    #[test]
    fn shading_names_what_to_look_at() {
        let bad_light = Light::towards(DVec3::ZERO).unwrap_err();
        let bad_diffuse = Phong::default().diffuse(-1.0).checked().unwrap_err();
        assert_eq!([bad_light, bad_diffuse].map(|err| err.setting()), ["light", "diffuse"]);
        let light = Light::towards(DVec3::new(0.0, -2.0, 0.0)).unwrap();
        assert_eq!(
            [Light::Headlight, light].map(|light| light.to_string()),
            ["headlight", "0,-1,0"]
        );
    }
}
