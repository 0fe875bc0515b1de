//! Transfer functions for common kinds of volumes, by name.
//!
//! Those for CT are in Hounsfield units (air −1000, water 0, soft tissue 20 … 80, vessels with contrast agent
//! 150 … 400, spongy bone from 150, cortical bone 500 … 1900). MR has no such scale, and `gray` no meaning:
//! both are for volumes of 8 bits, 0 … 255.

use slabsplat_core::TransferFunction;

use crate::IoError;

/// A transfer function as a table.
struct Preset {
    name: &'static str,
    /// Value, opacity per unit.
    opacity: &'static [(f64, [f64; 1])],
    /// Value, red, green, blue.
    color: &'static [(f64, [f64; 3])],
}

/// The presets, as [`preset_transfer`] and scene files name them.
pub const PRESET_NAMES: &[&str] = &["ct-bone", "ct-skin", "ct-vessels", "mr-brain", "gray"];

const PRESETS: &[Preset] = &[
    // Bone alone; spongy bone reddish and faint, cortical bone ivory.
    Preset {
        name: "ct-bone",
        opacity: &[(150.0, [0.0]), (300.0, [0.15]), (500.0, [0.6]), (1500.0, [0.9])],
        color: &[
            (150.0, [0.70, 0.35, 0.25]),
            (350.0, [0.90, 0.72, 0.55]),
            (700.0, [1.00, 0.95, 0.85]),
        ],
    },
    // The surface against the air, with whatever is denser behind it hidden.
    Preset {
        name: "ct-skin",
        opacity: &[(-500.0, [0.0]), (-250.0, [0.3]), (-50.0, [0.8])],
        color: &[
            (-500.0, [0.80, 0.50, 0.40]),
            (100.0, [0.93, 0.72, 0.60]),
            (400.0, [1.00, 0.95, 0.85]),
        ],
    },
    // Vessels filled with contrast agent in red, the bone behind them in ivory.
    Preset {
        name: "ct-vessels",
        opacity: &[(120.0, [0.0]), (220.0, [0.45]), (400.0, [0.6]), (1500.0, [0.9])],
        color: &[
            (120.0, [0.55, 0.08, 0.06]),
            (260.0, [0.85, 0.25, 0.18]),
            (500.0, [0.93, 0.85, 0.75]),
        ],
    },
    // A T1 image without the skull: cortex pink, white matter nearly white.
    Preset {
        name: "mr-brain",
        opacity: &[(60.0, [0.0]), (140.0, [0.5]), (255.0, [0.9])],
        color: &[
            (0.0, [0.55, 0.25, 0.20]),
            (160.0, [0.85, 0.55, 0.45]),
            (220.0, [1.00, 0.90, 0.82]),
        ],
    },
    // Brighter is denser.
    Preset {
        name: "gray",
        opacity: &[(0.0, [0.0]), (255.0, [0.5])],
        color: &[(0.0, [0.0, 0.0, 0.0]), (255.0, [1.0, 1.0, 1.0])],
    },
];

/// The transfer function of that name.
///
/// | name | for | values |
/// | --- | --- | --- |
/// | `ct-bone` | bone, in CT | Hounsfield units, from 150 |
/// | `ct-skin` | the outer surface, in CT | Hounsfield units, from −500 |
/// | `ct-vessels` | vessels with contrast agent, in CT | Hounsfield units, from 120 |
/// | `mr-brain` | a brain without its skull, in T1-weighted MR | 0 … 255, from 60 |
/// | `gray` | anything, brighter is denser | 0 … 255 |
///
/// # Errors
/// If there is no such preset; the message lists those that there are.
pub fn preset_transfer(name: &str) -> Result<TransferFunction, IoError> {
    let preset = PRESETS
        .iter()
        .find(|preset| preset.name == name)
        .ok_or_else(|| IoError::UnknownPreset { name: name.to_owned() })?;
    Ok(TransferFunction::new(preset.opacity.to_vec(), preset.color.to_vec())
        .expect("the presets are valid, as a test has seen"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preset_names_are_all_there() {
        let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        assert_eq!(names, PRESET_NAMES);
        for name in PRESET_NAMES {
            assert_eq!(preset_transfer(name).unwrap().iso_ranges().len(), 1, "{name}");
        }
        let err = preset_transfer("ct-bones").unwrap_err().to_string();
        assert!(err.contains("\"ct-bones\"") && err.contains("mr-brain"), "{err}");
    }

    #[test]
    fn preset_ct_tells_tissues_apart() {
        let [bone, skin] = ["ct-bone", "ct-skin"].map(|name| preset_transfer(name).unwrap());
        for (value, bone_shows, skin_shows) in
            [(-1000.0, false, false), (40.0, false, true), (700.0, true, true)]
        {
            assert_eq!(0.0 < bone.opacity(value), bone_shows, "bone at {value}");
            assert_eq!(0.0 < skin.opacity(value), skin_shows, "skin at {value}");
        }
    }
}
