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
    /// The world direction towards the light, of length 1.
    Direction(DVec3),
}

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
        let unit = direction.try_normalize().ok_or(ShadingError::BadLight(direction))?;
        Ok(Self::Direction(unit))
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
        assert_eq!(Light::towards(DVec3::X * 9.0), Ok(Light::Direction(DVec3::X)));
        assert!(Light::towards(DVec3::ZERO).is_err());
        assert!(Light::towards(DVec3::NAN).is_err());
    }
}
