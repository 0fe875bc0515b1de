//! Settings that are one of a few names: methods, modes, normalisation, lookup; and kernels, whose
//! names `slabsplat-kernel` knows.

use std::borrow::Cow;

use thiserror::Error;

/// Which voxels are added and which are composited ([model §4](crate::model)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "backends have to know each")]
pub enum Method {
    /// The paper's (§3.2): kernel sections summed in slabs parallel to the image.
    ImageAligned,
    /// The traditional sheet buffer (§3.1): whole footprints summed in the grid's slices.
    AxisAligned,
    /// The original (§1): whole footprints composited one voxel at a time.
    EverySample,
    /// Sections of density summed in slabs parallel to the image, classified and shaded pixel by pixel
    /// (Mueller, Möller & Crawfis, "Splatting Without the Blur", IEEE Visualization '99).
    PostClassified,
}

/// What a picture shows of a ray ([model §§3, 12](crate::model)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "backends have to know each")]
pub enum Mode {
    /// Sheets are composited, as [`Compositing::Separate`] does.
    Separate,
    /// Sheets are composited, as [`Compositing::Associated`] does.
    Associated,
    /// Sheets are composited, as [`Compositing::Extinction`] does.
    Extinction,
    /// The largest density on the ray.
    Maximum,
    /// The least density on the ray.
    Minimum,
    /// The mean density of the ray.
    Average,
    /// The surfaces on which densities have given values: [`Isosurface`](crate::Isosurface).
    Isosurfaces,
}

/// Which density on a ray stands for all ([model §12](crate::model)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "backends have to know each")]
pub enum Statistic {
    /// The largest: maximum intensity projection.
    Maximum,
    /// The least: minimum intensity projection.
    Minimum,
    /// The mean: an X-ray.
    Average,
}

impl Mode {
    /// How sheets are composited, if they are.
    pub fn compositing(self) -> Option<Compositing> {
        match self {
            Self::Separate => Some(Compositing::Separate),
            Self::Associated => Some(Compositing::Associated),
            Self::Extinction => Some(Compositing::Extinction),
            Self::Maximum | Self::Minimum | Self::Average | Self::Isosurfaces => None,
        }
    }

    /// Which density stands for all on its ray, if one does.
    pub fn statistic(self) -> Option<Statistic> {
        match self {
            Self::Separate | Self::Associated | Self::Extinction | Self::Isosurfaces => None,
            Self::Maximum => Some(Statistic::Maximum),
            Self::Minimum => Some(Statistic::Minimum),
            Self::Average => Some(Statistic::Average),
        }
    }
}

impl From<Compositing> for Mode {
    fn from(compositing: Compositing) -> Self {
        match compositing {
            Compositing::Separate => Self::Separate,
            Compositing::Associated => Self::Associated,
            Compositing::Extinction => Self::Extinction,
        }
    }
}

/// How a sheet's sums become colour and opacity ([model §3](crate::model)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "backends have to know each")]
pub enum Compositing {
    /// Colour and opacity are summed apart and multiplied (eqs. 4–7, Table 1).
    Separate,
    /// Opacity-weighted colour is summed (eq. 2).
    Associated,
    /// Extinction is summed: opacity does not depend on the slab width.
    Extinction,
}

/// How thick sections are darkened so that they look like the thin ones they stand for (eqs. 6–8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "tables depend on each")]
pub enum Normalization {
    /// Not at all.
    None,
    /// `h_f + h_b − (2 h_b h_f + ½ h_b² h_f)`, the text taken literally.
    Paper,
    /// `√(h_f² + h_b² − ½ h_b² h_f)`: eqs. 6–8 compare products of two footprints.
    Product,
}

/// A side from which a picture is taken, by what people call it.
///
/// Of a body ([`Orientation::Anatomical`](crate::Orientation)) left and right are its own; of all else they
/// are those of who looks at its front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "who frames a scene has to know each")]
pub enum Viewpoint {
    /// Before it.
    Front,
    /// Behind it.
    Back,
    /// On its left.
    Left,
    /// On its right.
    Right,
    /// Above it.
    Top,
    /// Below it.
    Bottom,
    /// Before it, as far to the right as above, so that all three axes are equally long.
    Iso,
}

/// What a picture is filled with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "who frames a scene has to know each")]
pub enum Fit {
    /// What is visible of it all.
    #[default]
    Visible,
    /// All of the volumes' grids, and of meshes.
    Volume,
}

/// How a section's offset is looked up in the section table (§3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "loops have to know each")]
pub enum Lookup {
    /// The nearest section, as in the paper.
    Nearest,
    /// Linearly between the two neighbouring sections.
    Linear,
}

/// Which of the two projections, without its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(clippy::exhaustive_enums, reason = "there is one for each projection")]
pub enum ProjectionKind {
    /// Depth does not change size.
    Orthographic,
    /// Rays leave the eye.
    Perspective,
}

/// The name of a kernel; `slabsplat-kernel` knows which there are.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
#[expect(clippy::exhaustive_structs, reason = "a name is a text")]
pub struct KernelName(pub Cow<'static, str>);

/// A word that is none of those to choose from.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{word:?} is not a choice here: use one of {}", choices.join(", "))]
#[non_exhaustive]
pub struct NotAChoice {
    /// What was given.
    pub word: String,
    /// What there is.
    pub choices: &'static [&'static str],
}

impl From<&str> for KernelName {
    fn from(name: &str) -> Self {
        Self(Cow::Owned(name.to_owned()))
    }
}

impl std::fmt::Display for KernelName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl Default for KernelName {
    fn default() -> Self {
        Self(Cow::Borrowed("gaussian"))
    }
}

/// Gives a fieldless enum its names, as scene files and flags spell them; it is printed and parsed by them.
macro_rules! named {
    ($ty:ident { $($variant:ident = $name:literal),* $(,)? }) => {
        impl $ty {
            /// Every choice, in the order of this documentation.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The name of every choice, in the same order.
            pub const NAMES: &[&'static str] = &[$($name),*];

            /// The name that scene files and flags use.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }
        }

        impl std::str::FromStr for $ty {
            type Err = $crate::NotAChoice;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                let is_it = |choice: &Self| choice.name() == name;
                Self::ALL.iter().copied().find(is_it).ok_or_else(|| $crate::NotAChoice {
                    word: name.to_owned(),
                    choices: Self::NAMES,
                })
            }
        }

        #[cfg(feature = "serde")]
        impl serde::Serialize for $ty {
            fn serialize<Z: serde::Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
                serializer.serialize_str(self.name())
            }
        }

        #[cfg(feature = "serde")]
        impl<'de> serde::Deserialize<'de> for $ty {
            fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                let name = <String as serde::Deserialize>::deserialize(d)?;
                name.parse().map_err(serde::de::Error::custom)
            }
        }

        impl std::fmt::Display for $ty {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

named!(Method {
    ImageAligned = "image-aligned",
    AxisAligned = "axis-aligned",
    EverySample = "every-sample",
    PostClassified = "post-classified",
});
named!(Compositing {
    Separate = "separate",
    Associated = "associated",
    Extinction = "extinction",
});
named!(Mode {
    Separate = "separate",
    Associated = "associated",
    Extinction = "extinction",
    Maximum = "maximum",
    Minimum = "minimum",
    Average = "average",
    Isosurfaces = "isosurfaces",
});
named!(Normalization { None = "none", Paper = "paper", Product = "product" });
named!(ProjectionKind { Orthographic = "orthographic", Perspective = "perspective" });
named!(Viewpoint {
    Front = "front",
    Back = "back",
    Left = "left",
    Right = "right",
    Top = "top",
    Bottom = "bottom",
    Iso = "iso",
});
named!(Fit { Visible = "visible", Volume = "volume" });
named!(Lookup { Nearest = "nearest", Linear = "linear" });

pub(crate) use named;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_round_trip() {
        for &m in Method::ALL {
            assert_eq!(m.to_string().parse(), Ok(m));
        }
        assert_eq!("extinction".parse(), Ok(Compositing::Extinction));
        for &mode in Mode::ALL {
            let of = [mode.compositing().is_some(), mode.statistic().is_some()];
            assert_eq!(of == [false; 2], mode == Mode::Isosurfaces, "{mode}");
            assert_ne!(of, [true; 2], "{mode}");
            let same = mode.compositing().map_or(mode, Mode::from);
            assert_eq!(same, mode);
        }
        for &kind in ProjectionKind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        let error = "both".parse::<Normalization>().unwrap_err().to_string();
        assert_eq!(error, "\"both\" is not a choice here: use one of none, paper, product");
    }
}
