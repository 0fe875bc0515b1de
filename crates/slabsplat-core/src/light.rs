//! Lights infinitely far away, and how a viewer sees them (model §6).

use crate::ViewAxes;
use crate::unit_vector::is_unit;
use glam::DVec3;
use thiserror::Error;

/// A light infinitely far away.
///
/// ```
/// use slabsplat_core::Light;
///
/// let evening = Light::towards([-1.0, 0.0, 0.2])?.color([1.0, 0.6, 0.3]);
/// assert_eq!(Light::default().color([1.0; 3]), Light::default());
/// # assert_ne!(evening, Light::default());
/// # Ok::<(), slabsplat_core::LightError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Light {
    /// Where it comes from.
    #[cfg_attr(feature = "serde", serde(rename = "from"))]
    pub source: LightSource,
    /// Its red, green and blue, at least 0: with 1 it is as bright as the coefficients of shading say.
    #[cfg_attr(feature = "serde", serde(default = "crate::serialized::white"))]
    pub color: [f64; 3],
}

/// Where a light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_enums, reason = "shaders and films have to know each")]
pub enum LightSource {
    /// It shines along the viewing direction.
    Headlight,
    /// It stays where it is in the world; made by [`Light::towards`].
    Direction(LightDirection),
}

/// The world direction towards a light; of length 1, or it would brighten what it shines on.
///
/// ```compile_fail
/// use slabsplat_core::{LightDirection, LightSource, glam::DVec3};
///
/// let source = LightSource::Direction(LightDirection(DVec3::X * 5.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightDirection(DVec3);

/// Why there are no such lights.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LightError {
    /// The direction is zero or not finite.
    #[error("the light's direction must be a finite vector other than zero, not {0}")]
    BadDirection(DVec3),
    /// The colour is negative, NaN or infinite.
    #[error("the colour of a light must be three numbers of at least 0, not {0}")]
    BadColor(DVec3),
    /// Each costs time at every voxel.
    #[error("{0} lights are too many: use up to {max}", max = Light::MAX_LIGHTS)]
    TooMany(usize),
}

impl Default for Light {
    /// A white headlight.
    fn default() -> Self {
        Self { source: LightSource::Headlight, color: [1.0; 3] }
    }
}

impl LightDirection {
    /// The direction, of length 1.
    pub fn get(self) -> DVec3 {
        self.0
    }
}

impl Light {
    /// How many there may be.
    pub const MAX_LIGHTS: usize = 16;

    /// A white light far away in `direction` (any length).
    ///
    /// # Errors
    /// If the direction is zero or not finite.
    pub fn towards(direction: impl Into<DVec3>) -> Result<Self, LightError> {
        let direction = direction.into();
        if is_unit(direction) {
            let source = LightSource::Direction(LightDirection(direction));
            return Ok(Self { source, ..Self::default() });
        }
        // Squares of very long or short vectors would leave the range of numbers.
        let scaled = direction / direction.abs().max_element();
        let unit = scaled.try_normalize().ok_or(LightError::BadDirection(direction))?;
        Ok(Self { source: LightSource::Direction(LightDirection(unit)), ..Self::default() })
    }

    /// The same in another colour.
    #[must_use]
    pub fn color(self, color: [f64; 3]) -> Self {
        Self { color, ..self }
    }

    /// Whether a picture may have these lights.
    ///
    /// # Errors
    /// If there are too many, or one has a negative colour, or one that is not finite.
    pub fn check_all(lights: &[Self]) -> Result<(), LightError> {
        if Self::MAX_LIGHTS < lights.len() {
            return Err(LightError::TooMany(lights.len()));
        }
        let is_bad = |channel: &f64| !(0.0..f64::INFINITY).contains(channel);
        match lights.iter().find(|light| light.color.iter().any(is_bad)) {
            Some(light) => Err(LightError::BadColor(light.color.into())),
            None => Ok(()),
        }
    }
}

/// A light as a viewer sees it who is infinitely far away, too. Directions are in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "model §6 has no more of a light")]
pub struct LightInView {
    /// `l`, the direction towards the light.
    pub to_light: DVec3,
    /// `h = (l + v)/|l + v|`, half way between light and viewer; zero if the light shines straight at the
    /// viewer.
    pub halfway: DVec3,
    /// Red, green and blue.
    pub color: DVec3,
}

impl LightInView {
    /// For a viewer who looks along `forward`, of length 1.
    pub fn new(light: Light, forward: DVec3) -> Self {
        let (to_light, halfway) = match light.source {
            // The very same, so that who computes with one need not compute with the other.
            LightSource::Headlight => (-forward, -forward),
            LightSource::Direction(LightDirection(to_light)) => {
                (to_light, (to_light - forward).normalize_or_zero())
            }
        };
        Self { to_light, halfway, color: light.color.into() }
    }

    /// The same by other directions: to the right, upwards and forward.
    pub fn seen_along(&self, axes: &ViewAxes) -> Self {
        let seen = |v: DVec3| DVec3::new(v.dot(axes.right), v.dot(axes.up), v.dot(axes.forward));
        Self { to_light: seen(self.to_light), halfway: seen(self.halfway), color: self.color }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_direction_has_length_one() {
        for length in [1e-300, 0.2, 5.0, 1e300] {
            let light = Light::towards(DVec3::X * length).unwrap();
            assert_eq!(LightInView::new(light, DVec3::Z).to_light, DVec3::X, "{length}");
        }
        for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(Light::towards(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn light_halfway_to_the_viewer() {
        let headlight = LightInView::new(Light::default(), DVec3::Z);
        assert_eq!((headlight.to_light, headlight.halfway), (DVec3::NEG_Z, DVec3::NEG_Z));
        let towards =
            |direction, forward| LightInView::new(Light::towards(direction).unwrap(), forward);
        assert_eq!(towards(DVec3::X, DVec3::NEG_X).halfway, DVec3::X);
        assert_eq!(towards(DVec3::Z, DVec3::Z).halfway, DVec3::ZERO);
    }

    #[test]
    fn lights_are_few_and_of_some_color() {
        let of = |color| Light::check_all(&[Light::default(), Light::default().color(color)]);
        assert_eq!(of([0.0, 1.0, 7.5]), Ok(()));
        for bad in [[-0.1, 0.0, 0.0], [0.0, f64::NAN, 0.0], [0.0, 0.0, f64::INFINITY]] {
            assert!(matches!(of(bad), Err(LightError::BadColor(_))), "{bad:?}");
        }
        let most = [Light::default(); Light::MAX_LIGHTS];
        assert_eq!(Light::check_all(&most), Ok(()));
        let too_many = [Light::default(); Light::MAX_LIGHTS + 1];
        assert_eq!(Light::check_all(&too_many), Err(LightError::TooMany(17)));
    }
}
