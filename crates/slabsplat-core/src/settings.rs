//! How a scene is rendered: method, mode, slabs, tables. A new setting is a new row.

use thiserror::Error;

use crate::settings_table::{Settings, settings};
use crate::{Interval, KernelName, Lookup, Method, Mode, Normalization, OutOfRange};

settings! {
    /// Everything about rendering that is neither the volume nor what it looks like.
    ///
    /// ```
    /// use slabsplat_core::{Method, RenderSettings};
    ///
    /// let settings = RenderSettings::default().method(Method::AxisAligned).slab_width(0.5);
    /// assert!(settings.clone().checked().is_ok());
    /// assert!(settings.tolerance(2.0).checked().is_err());
    /// ```
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub struct RenderSettings {
        /// What is summed before it is composited; post-classified has sharp edges.
        method: Method = Method::ImageAligned, choice;

        /// The reconstruction kernel.
        kernel: KernelName = KernelName::default(), kernel;

        /// Thickness of a slab, in voxel steps.
        /// A step is the grid's `unit`.
        slab_width: f64 = 1.0, number("STEPS", WIDTHS);

        /// What is shown of a ray: sheets, composited by one of three models, one density, or isosurfaces.
        /// The largest, the least or the mean density is one of slabs parallel to the image, and isosurfaces
        /// are found between such slabs; a layer lists them.
        mode: Mode = Mode::Extinction, choice;

        /// How thick sections are darkened.
        normalization: Normalization = Normalization::None, choice;

        /// Thinnest width of the slab hierarchy that normalisation needs, in voxel steps.
        base_slab_width: f64 = 0.5, number("STEPS", WIDTHS);

        /// Sections in a table; the paper has 128.
        sections: u32 = 128, count(TABLE_SECTIONS);

        /// Samples along the radius of a table.
        /// What is off between them falls with their square: it is the most that backends differ by, below
        /// 10⁻³ of a pixel from the default on.
        radial_samples: u32 = 256, count(TABLE_RADII);

        /// How a section is looked up in its table.
        lookup: Lookup = Lookup::Linear, choice;

        /// Opacity from which a pixel is saturated; 1 draws everything.
        /// What lies behind is skipped, which changes the pixel by at most `1 − opacity_cutoff`.
        opacity_cutoff: f64 = 1.0 - 2e-3, number("OPACITY", Interval::above(0.0).at_most(1.0));

        /// How far a pixel may be from what all sections would give; 0 draws them all.
        /// That is any premultiplied channel. `image-aligned` slabs of `extinction` without normalisation
        /// make use of it, and `post-classified`, where a pixel next to an edge may be off by more: what
        /// others show depends on every single section. Of flat walls seen exactly along, the edges may also
        /// lie up to a third of a voxel further out ([separable footprints]).
        ///
        /// [separable footprints]: https://github.com/slabsplat/slabsplat/blob/main/docs/numerics.md
        tolerance: f64 = 0.05, number("DIFFERENCE", Interval::at_least(0.0).below(1.0));
    }
}

/// Why settings cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SettingsError {
    /// A number is outside of what its row permits.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
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
}

/// The widest slab is much thicker than any volume, and far from infinite.
const WIDTHS: Interval = Interval::above(0.0).at_most(1e12);

/// Between fewer samples a kernel is not to be recognised; the upper ends bound the time that a table takes.
const TABLE_SECTIONS: Interval = Interval::at_least(16.0).at_most(1024.0);
const TABLE_RADII: Interval = Interval::at_least(16.0).at_most(2048.0);

/// A normalised table grows with the slab width, unlike a plain one: this takes a second to make.
const MAX_NORMALIZED_WIDTH: f64 = 128.0;

/// A section is joined from all the base sections within the kernel: 128 of this width.
const MIN_BASE_WIDTH: f64 = 1.0 / 32.0;

impl RenderSettings {
    /// The same, if the numbers can be used.
    ///
    /// # Errors
    /// If a number is outside of its row's range, or the widths do not go with the normalisation.
    pub fn checked(self) -> Result<Self, SettingsError> {
        self.check_ranges()?;
        self.check_hierarchy(1.0)?;
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

impl SettingsError {
    /// The name of the setting that a person should look at.
    pub fn setting(&self) -> &'static str {
        match self {
            Self::OutOfRange(OutOfRange { name, .. }) => name,
            Self::BadHierarchy { .. } => "normalization",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_reject_bad_numbers() {
        let good = RenderSettings::default;
        assert!(good().checked().is_ok());
        let plain = good().slab_width(1e9).base_slab_width(1e-9);
        assert!(plain.checked().is_ok(), "only a hierarchy has limits");
        for (setting, bad) in [
            ("slab_width", good().slab_width(0.0)),
            ("slab_width", good().slab_width(f64::NAN)),
            ("slab_width", good().slab_width(1e308)),
            ("base_slab_width", good().base_slab_width(-1.0)),
            ("sections", good().sections(1)),
            ("radial_samples", good().radial_samples(1 << 20)),
            ("opacity_cutoff", good().opacity_cutoff(1.5)),
            ("tolerance", good().tolerance(-1e-9)),
            ("tolerance", good().tolerance(1.0)),
            ("tolerance", good().tolerance(f64::NAN)),
            ("normalization", good().normalization(Normalization::Paper).slab_width(1e9)),
            ("normalization", good().normalization(Normalization::Product).base_slab_width(1e-9)),
        ] {
            let error = bad.clone().checked().unwrap_err();
            assert_eq!(error.setting(), setting, "{bad:?}");
            assert!(error.to_string().contains(setting), "{bad:?}: {error}");
        }
    }

    #[test]
    fn settings_limit_the_slab_hierarchy() {
        let check = |slab_width: f64, base_slab_width: f64, kappa: f64, is_permitted: bool| {
            let settings = RenderSettings::default()
                .normalization(Normalization::Product)
                .slab_width(slab_width)
                .base_slab_width(base_slab_width);
            let result = settings.check_hierarchy(kappa);
            assert_eq!(result.is_ok(), is_permitted, "{slab_width} {base_slab_width} {kappa}");
        };
        check(128.0, 1.0 / 32.0, 1.0, true);
        check(128.5, 1.0 / 32.0, 1.0, false);
        check(128.0, 1.0 / 33.0, 1.0, false);
        // Slabs of the base width need no hierarchy.
        check(1e9, 1e9, 1.0, true);
        // Along these rays a slab is as thick as 1.5 times as many steps; it never counts as thinner.
        check(85.0, 0.5, 1.5, true);
        check(86.0, 0.5, 1.5, false);
        check(129.0, 0.5, 0.5, false);
    }
}
