//! Surfaces on which a volume's density has one value (model §12).

use thiserror::Error;

/// A surface: all points of one density, of an opacity and a colour.
///
/// ```
/// use slabsplat_core::Isosurface;
///
/// let skin = Isosurface::new(80.0, 0.4, Some([0.9, 0.7, 0.6]))?;
/// assert_eq!(skin.opacity(), 0.4);
/// assert!(Isosurface::new(f64::NAN, 1.0, None).is_err());
/// # Ok::<(), slabsplat_core::IsosurfaceError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(
    feature = "serde",
    serde(
        try_from = "crate::serialized::IsosurfaceKeys",
        into = "crate::serialized::IsosurfaceKeys"
    )
)]
pub struct Isosurface {
    value: f64,
    opacity: f64,
    color: Option<[f64; 3]>,
}

/// Why there is no such surface.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum IsosurfaceError {
    /// No density is NaN or infinite.
    #[error("an isosurface needs a finite value, not {0}")]
    BadValue(f64),
    /// The opacity is outside 0 … 1.
    #[error("the opacity of an isosurface lies between 0 and 1, not at {0}")]
    BadOpacity(f64),
    /// A channel of the colour is outside 0 … 1.
    #[error("the colour of an isosurface lies between 0 and 1, not at {0}")]
    BadColor(f64),
}

impl Isosurface {
    /// The surface of that density. Its opacity, 0 to 1, counts as it is, not per length; without a colour it
    /// has that of the transfer function.
    ///
    /// # Errors
    /// If the value is not finite, or the opacity or a channel is not within 0 to 1.
    pub fn new(value: f64, opacity: f64, color: Option<[f64; 3]>) -> Result<Self, IsosurfaceError> {
        let is_share = |number: &f64| (0.0..=1.0).contains(number);
        if !value.is_finite() {
            return Err(IsosurfaceError::BadValue(value));
        }
        if !is_share(&opacity) {
            return Err(IsosurfaceError::BadOpacity(opacity));
        }
        match color.iter().flatten().find(|channel| !is_share(channel)) {
            Some(&channel) => Err(IsosurfaceError::BadColor(channel)),
            None => Ok(Self { value, opacity, color }),
        }
    }

    /// The density on the surface.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// How much of what is behind it hides.
    pub fn opacity(&self) -> f64 {
        self.opacity
    }

    /// Red, green, blue, if they are not the transfer function's.
    pub fn color(&self) -> Option<[f64; 3]> {
        self.color
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn isosurface_errors_name_the_number() {
        let check = |value, opacity, color, expected: &str| {
            let error = Isosurface::new(value, opacity, color).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        check(f64::NAN, 1.0, None, "finite value, not NaN");
        check(f64::NEG_INFINITY, 1.0, None, "not -inf");
        check(0.0, 1.5, None, "opacity of an isosurface lies between 0 and 1, not at 1.5");
        check(0.0, f64::NAN, None, "not at NaN");
        check(
            0.0,
            1.0,
            Some([0.0, -0.25, 1.0]),
            "colour of an isosurface lies between 0 and 1, not at -0.25",
        );
        assert!(Isosurface::new(-1e300, 0.0, Some([0.0, 1.0, 0.5])).is_ok());
    }
}
