//! What light does to a voxel. The arithmetic is in `slabsplat-traverse`, once a voxel and frame.

use glam::DVec3;
use thiserror::Error;

/// How a voxel's colour is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shading {
    /// The transfer function's colour as it is.
    None,
    /// Blinn–Phong.
    Phong(Phong),
}

/// Blinn–Phong: `c·(k_a + k_d·n·l) + k_s·(n·h)^s`, clamped to 0 … 1 (SPEC §6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// `k_a`, light from everywhere.
    pub ambient: f64,
    /// `k_d`, light from the lamp, scattered.
    pub diffuse: f64,
    /// `k_s`, light from the lamp, mirrored.
    pub specular: f64,
    /// `s`, how sharp the highlight is.
    pub shininess: f64,
    /// Whether a surface is lit from behind too: both products by their absolute values.
    pub two_sided: bool,
    /// Where the light comes from.
    pub light: Light,
}

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

/// Why a shading cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ShadingError {
    /// A coefficient is negative, NaN or infinite.
    #[error("{name} must be a finite number of at least 0, not {value}")]
    BadCoefficient {
        /// Which coefficient.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// The light's direction is zero or not finite.
    #[error("the light's direction must be a finite vector other than zero, not {0}")]
    BadLight(DVec3),
}

impl Default for Phong {
    fn default() -> Self {
        Self {
            ambient: 0.1,
            diffuse: 0.7,
            specular: 0.2,
            shininess: 20.0,
            two_sided: true,
            light: Light::Headlight,
        }
    }
}

impl Phong {
    /// The same, if its coefficients can be used.
    ///
    /// # Errors
    /// If a coefficient is negative or not finite.
    pub fn checked(self) -> Result<Self, ShadingError> {
        let coefficients = [
            ("ambient", self.ambient),
            ("diffuse", self.diffuse),
            ("specular", self.specular),
            ("shininess", self.shininess),
        ];
        match coefficients.into_iter().find(|(_, v)| !v.is_finite() || *v < 0.0) {
            Some((name, value)) => Err(ShadingError::BadCoefficient { name, value }),
            None => Ok(self),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phong_rejects_bad_coefficients() {
        assert!(Phong::default().checked().is_ok());
        for bad in [-0.1, f64::NAN, f64::INFINITY] {
            let err = Phong { shininess: bad, ..Phong::default() }.checked().unwrap_err();
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
}
