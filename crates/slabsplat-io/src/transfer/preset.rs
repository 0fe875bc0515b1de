//! Transfer functions for common kinds of volumes, by name: a small file each in `presets/`.
//!
//! Those for CT are in Hounsfield units, of which every file names its sources. MR and microscopes have no
//! such scale: their presets go from 0, the background, to 1, the brightest of the object but for a few
//! voxels.

use serde::Deserialize;
use slabsplat_core::{Phong, PiecewiseLinear, Shading, TransferFunction};

use super::{TransferSource, ValueScale};
use crate::IoError;

/// A transfer function for a kind of volumes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Preset {
    /// As flags and scene files name it.
    pub name: &'static str,
    /// What it shows, in one line.
    pub about: String,
    /// For which values it is.
    pub suited: Suited,
    /// Where the values come from.
    pub sources: Vec<String>,
    /// What it is.
    pub source: TransferSource,
}

/// The values that a preset is for.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Suited {
    /// Hounsfield units: air is −1000, water 0.
    Hounsfield,
    /// Intensities without a scale, from a background to an object.
    Intensities,
    /// Any.
    Any,
}

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// The presets that [`preset`] knows, as flags and scene files name them.
        pub const PRESET_NAMES: &[&str] = &[$($name),*];

        const TEXTS: &[&str] = &[$(include_str!(concat!("presets/", $name, ".toml"))),*];
    };
}

presets![
    "ct-bone",
    "ct-skin",
    "ct-skin-bone",
    "ct-muscle",
    "ct-lung",
    "ct-vessels",
    "ct-industrial",
    "mr-t1",
    "mr-t2",
    "mr-angio",
    "microscopy",
    "xray",
    "gray",
];

/// A preset as its file spells it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PresetFile {
    about: String,
    suited: Suited,
    /// Of the scale of intensities: 1 is what so many percent of the object do not exceed.
    percentile: Option<f64>,
    opacity: Vec<[f64; 2]>,
    color: Vec<[f64; 4]>,
    gradient_opacity: Option<Vec<[f64; 2]>>,
    /// Whether light changes its colours.
    #[serde(default = "yes")]
    lit: bool,
    #[serde(default)]
    sources: Vec<String>,
}

fn yes() -> bool {
    true
}

/// The preset of that name, one of [`PRESET_NAMES`].
///
/// # Errors
/// If there is no such preset; the message lists those that there are.
pub fn preset(name: &str) -> Result<Preset, IoError> {
    let found = PRESET_NAMES.iter().zip(TEXTS).find(|(known, _)| **known == name);
    let (name, text) = found.ok_or_else(|| IoError::UnknownPreset { name: name.to_owned() })?;
    let file: PresetFile = toml::from_str(text).expect("the presets are TOML, as a test has seen");
    Ok(file.into_preset(name))
}

impl PresetFile {
    fn into_preset(self, name: &'static str) -> Preset {
        let transfer = TransferFunction::new(
            self.opacity.into_iter().map(|[value, alpha]| (value, alpha)),
            self.color.into_iter().map(|[value, r, g, b]| (value, [r, g, b])),
        );
        let by_gradient = self.gradient_opacity.map(|points| {
            let points = points.into_iter().map(|[gradient, factor]| (gradient, factor));
            PiecewiseLinear::new("gradient_opacity", points).expect(VALID)
        });
        let scale = match (self.percentile, self.suited) {
            (Some(percentile), _) => ValueScale::Object { percentile },
            (None, Suited::Hounsfield) => ValueScale::Hounsfield,
            (None, Suited::Intensities | Suited::Any) => ValueScale::Data,
        };
        let source = TransferSource {
            scale,
            gradient_opacity: by_gradient,
            shading: Some(if self.lit { Shading::Phong(Phong::default()) } else { Shading::None }),
            preset: Some(name.to_owned()),
            ..TransferSource::of_values(transfer.expect(VALID))
        };
        Preset { name, about: self.about, suited: self.suited, sources: self.sources, source }
    }
}

const VALID: &str = "the presets are valid, as a test has seen";

impl Suited {
    /// What is wrong with a volume whose values go from `lo` to `hi`, if anything; `name` is the preset's.
    pub fn warning(self, name: &str, [lo, hi]: [f64; 2]) -> Option<String> {
        // Fat is −190 to −30, and no body lacks it; bone and contrast agents are above 150.
        let is_hounsfield = lo <= -30.0 && 150.0 <= hi;
        // Air in CT.
        let is_ct = lo <= -500.0 && 150.0 <= hi;
        match self {
            Self::Hounsfield if !is_hounsfield => Some(format!(
                "{name} is for Hounsfield units, where air is -1000 and bone begins at 150, and the values go \
                 from {lo} to {hi}: give a window for its least and its greatest value, or take another preset"
            )),
            Self::Intensities if is_ct => Some(format!(
                "{name} is for intensities without a scale, and values from {lo} to {hi} look like Hounsfield \
                 units: a preset ct-.. may suit better"
            )),
            Self::Hounsfield | Self::Intensities | Self::Any => None,
        }
    }

    /// What people call such values.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hounsfield => "Hounsfield units",
            Self::Intensities => "background to brightest",
            Self::Any => "least to largest",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_valid() {
        for name in PRESET_NAMES {
            let preset = preset(name).unwrap();
            assert!(
                !preset.about.is_empty() && preset.about.len() < 90,
                "{name}: {}",
                preset.about
            );
            assert!(!preset.source.transfer.iso_ranges().is_empty(), "{name} shows something");
            let [lo, hi] = preset.source.transfer.span();
            match preset.suited {
                Suited::Hounsfield => {
                    assert!(-1024.0 <= lo && hi <= 3100.0, "{name}: {lo} to {hi}");
                    assert!(!preset.sources.is_empty(), "{name} names its sources");
                }
                Suited::Intensities | Suited::Any => {
                    assert!(preset.source.scale.is_relative(), "{name}");
                    assert!(0.0 <= lo && hi <= 1.0, "{name}: {lo} to {hi}");
                }
            }
        }
        let error = preset("ct-bones").unwrap_err().to_string();
        assert!(error.contains("\"ct-bones\"") && error.contains("mr-t1"), "{error}");
    }

    /// Which of air, lung, fat, muscle, a vessel with contrast agent and cortical bone are visible.
    #[test]
    fn preset_ct_tells_tissues_apart() {
        let tissues = [-1000.0, -800.0, -100.0, 50.0, 300.0, 1000.0];
        for (name, expected) in [
            ("ct-bone", "....xx"),
            ("ct-skin", "..xxxx"),
            ("ct-muscle", "...xxx"),
            ("ct-lung", ".x..xx"),
            ("ct-vessels", "....xx"),
        ] {
            let transfer = preset(name).unwrap().source.transfer;
            let visible: String = tissues
                .iter()
                .map(|&hu| if 0.004 < transfer.opacity(hu) { 'x' } else { '.' })
                .collect();
            assert_eq!(visible, expected, "{name}");
        }
    }

    #[test]
    fn preset_says_what_does_not_suit() {
        let check = |suited: Suited, range, expected: Option<&str>| {
            let warning = suited.warning("it", range);
            match (&warning, expected) {
                (None, None) => {}
                (Some(warning), Some(expected)) => {
                    assert!(warning.contains(expected), "{warning}");
                }
                _ => panic!("{suited:?} of {range:?}: {warning:?}"),
            }
        };
        check(Suited::Hounsfield, [-1024.0, 3071.0], None);
        check(Suited::Hounsfield, [0.0, 255.0], Some("from 0 to 255"));
        check(Suited::Hounsfield, [0.0, 3926.0], Some("is for Hounsfield units"));
        check(Suited::Intensities, [0.0, 255.0], None);
        check(Suited::Intensities, [-1024.0, 1500.0], Some("look like Hounsfield"));
        check(Suited::Any, [-1024.0, 1500.0], None);
    }
}
