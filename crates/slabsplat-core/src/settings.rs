//! How a scene is rendered: method, compositing, slabs, tables.

use std::borrow::Cow;
use thiserror::Error;

/// Which voxels are added and which are composited (SPEC §4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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

/// How a sheet's sums become colour and opacity (SPEC §3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
pub enum Normalization {
    /// Not at all.
    None,
    /// `h_f + h_b − (2 h_b h_f + ½ h_b² h_f)`, the text taken literally.
    Paper,
    /// `√(h_f² + h_b² − ½ h_b² h_f)`: eqs. 6–8 compare products of two footprints.
    Product,
}

/// How a section's offset is looked up in the section table (§3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lookup {
    /// The nearest section, as in the paper.
    Nearest,
    /// Linearly between the two neighbouring sections.
    Linear,
}

/// The name of a kernel; `slabsplat-kernel` knows which there are.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct KernelName(pub Cow<'static, str>);

/// Everything about rendering that is neither the volume nor what it looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// What is added and what is composited.
    pub method: Method,
    /// The reconstruction kernel.
    pub kernel: KernelName,
    /// Thickness of a slab in voxel steps (`unit`), above 0.
    pub slab_width: f64,
    /// How sheets become pixels.
    pub compositing: Compositing,
    /// How thick sections are darkened.
    pub normalization: Normalization,
    /// The thinnest width of the slab hierarchy, in voxel steps.
    pub base_slab_width: f64,
    /// Sections per table, at least 2; the paper uses 128.
    pub sections: u32,
    /// Samples along the radius of a table, at least 2. What is off between them falls with their square: it
    /// is the most that backends differ by, below 10⁻³ of a pixel from the default on.
    pub radial_samples: u32,
    /// How a section is looked up.
    pub lookup: Lookup,
    /// Opacity from which a pixel counts as full, at most 1. What lies behind is left out, which
    /// changes the pixel by at most `1 − opacity_cutoff`; 1 draws everything.
    pub opacity_cutoff: f64,
    /// How far any premultiplied channel of a pixel may be from what all sections would give, at least
    /// 0 and below 1; 0 draws them all. Only `image-aligned` slabs of `extinction` without
    /// normalisation make use of it: what others show depends on every single section. Of flat walls seen exactly
    /// along, the edges may also lie up to a third of a voxel further out (`docs/numerics.md`, "Products").
    pub tolerance: f64,
}

/// Why settings cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SettingsError {
    /// A width is not a positive number of at most 10¹².
    #[error("{name} must be a positive number of at most 1e12, not {value:?}")]
    BadWidth {
        /// Which width.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A table would be too small or too large.
    #[error("{name} must be between 2 and 4096, not {value}")]
    BadCount {
        /// Which count.
        name: &'static str,
        /// What was given.
        value: u32,
    },
    /// The slab hierarchy would have too many levels or too many sections.
    #[error(
        "normalization {normalization} needs slab_width of at most {MAX_NORMALIZED_WIDTH} and \
         base_slab_width of at least {MIN_BASE_WIDTH}, not {slab_width} and {base_slab_width}"
    )]
    BadHierarchy {
        /// What was asked for.
        normalization: Normalization,
        /// The slab width given.
        slab_width: f64,
        /// The base given.
        base_slab_width: f64,
    },
    /// The cut-off is not an opacity.
    #[error("opacity_cutoff must be above 0 and at most 1, not {0}")]
    BadCutoff(f64),
    /// The tolerance is no difference between two colours.
    #[error("tolerance must be at least 0 and below 1, not {0}")]
    BadTolerance(f64),
}

/// Widest slab: much thicker than any volume, and far from infinite.
const MAX_WIDTH: f64 = 1e12;

/// A normalised table grows with the slab width, unlike a plain one: this takes a second to make.
const MAX_NORMALIZED_WIDTH: f64 = 128.0;

/// A section is joined from all the base sections within the kernel: 128 of this width.
const MIN_BASE_WIDTH: f64 = 1.0 / 32.0;

impl Default for KernelName {
    fn default() -> Self {
        Self(Cow::Borrowed("gaussian"))
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            method: Method::ImageAligned,
            kernel: KernelName::default(),
            slab_width: 1.0,
            compositing: Compositing::Extinction,
            normalization: Normalization::None,
            base_slab_width: 0.5,
            sections: 128,
            radial_samples: 256,
            lookup: Lookup::Linear,
            opacity_cutoff: 1.0 - 2e-3,
            tolerance: 0.05,
        }
    }
}

impl RenderSettings {
    /// The same, if the numbers can be used.
    ///
    /// # Errors
    /// If a width is not positive, a table too small or too large, the cut-off no opacity, or the
    /// tolerance not between 0 and 1.
    pub fn checked(self) -> Result<Self, SettingsError> {
        for (name, value) in
            [("slab_width", self.slab_width), ("base_slab_width", self.base_slab_width)]
        {
            if !value.is_normal() || !(0.0..=MAX_WIDTH).contains(&value) {
                return Err(SettingsError::BadWidth { name, value });
            }
        }
        for (name, value) in [("sections", self.sections), ("radial_samples", self.radial_samples)]
        {
            if !(2..=4096).contains(&value) {
                return Err(SettingsError::BadCount { name, value });
            }
        }
        self.check_hierarchy(1.0)?;
        if !(0.0 < self.opacity_cutoff && self.opacity_cutoff <= 1.0) {
            return Err(SettingsError::BadCutoff(self.opacity_cutoff));
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            return Err(SettingsError::BadTolerance(self.tolerance));
        }
        Ok(self)
    }

    /// Whether the slab hierarchy can be made for rays that are `kappa` index steps long over one `unit`
    /// of depth, 1 on a cubic grid.
    ///
    /// # Errors
    /// If it would have too many levels or too many sections.
    pub fn check_hierarchy(&self, kappa: f64) -> Result<(), SettingsError> {
        let Self { normalization, slab_width, base_slab_width, .. } = *self;
        let is_normalized = normalization != Normalization::None && base_slab_width < slab_width;
        let is_too_wide = MAX_NORMALIZED_WIDTH < slab_width.max(slab_width * kappa);
        if is_normalized && (is_too_wide || base_slab_width < MIN_BASE_WIDTH) {
            return Err(SettingsError::BadHierarchy { normalization, slab_width, base_slab_width });
        }
        Ok(())
    }
}

/// Gives a fieldless enum its names, as scene files and flags spell them.
macro_rules! named {
    ($ty:ident { $($variant:ident = $name:literal),* $(,)? }) => {
        impl $ty {
            /// Every choice, in the order of SPEC.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The name that scene files and flags use.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }

            /// The choice of that name.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|choice| choice.name() == name)
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
named!(Normalization { None = "none", Paper = "paper", Product = "product" });
named!(Lookup { Nearest = "nearest", Linear = "linear" });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_names_round_trip() {
        for &m in Method::ALL {
            assert_eq!(Method::from_name(m.name()), Some(m));
        }
        assert_eq!(Compositing::from_name("extinction"), Some(Compositing::Extinction));
        assert_eq!(Normalization::from_name("both"), None);
    }

    #[test]
    fn settings_reject_bad_numbers() {
        let good = RenderSettings::default();
        assert!(good.clone().checked().is_ok());
        let plain = RenderSettings { slab_width: 1e9, base_slab_width: 1e-9, ..good.clone() };
        assert!(plain.checked().is_ok(), "only a hierarchy has limits");
        for bad in [
            RenderSettings { slab_width: 0.0, ..good.clone() },
            RenderSettings { slab_width: f64::NAN, ..good.clone() },
            RenderSettings { slab_width: 1e308, ..good.clone() },
            RenderSettings { base_slab_width: -1.0, ..good.clone() },
            RenderSettings { sections: 1, ..good.clone() },
            RenderSettings { radial_samples: 1 << 20, ..good.clone() },
            RenderSettings { opacity_cutoff: 1.5, ..good.clone() },
            RenderSettings { tolerance: -1e-9, ..good.clone() },
            RenderSettings { tolerance: 1.0, ..good.clone() },
            RenderSettings { tolerance: f64::NAN, ..good.clone() },
            RenderSettings { normalization: Normalization::Paper, slab_width: 1e9, ..good.clone() },
            RenderSettings {
                normalization: Normalization::Product,
                base_slab_width: 1e-9,
                ..good.clone()
            },
        ] {
            assert!(bad.clone().checked().is_err(), "{bad:?}");
        }
    }
}
