//! Transfer functions by name. CT presets are in Hounsfield units; the windows follow the usual
//! ranges of tissues (soft tissue 20 to 80 HU, contrast-filled vessels 150 to 400, bone above 300).

use slabsplat_core::TransferFunction;

struct Preset {
    name: &'static str,
    opacity: &'static [(f64, f64)],
    color: &'static [(f64, [f64; 3])],
}

const BONE: [f64; 3] = [0.96, 0.92, 0.84];

const PRESETS: &[Preset] = &[
    Preset {
        name: "ct-bone",
        opacity: &[(180.0, 0.0), (450.0, 0.55), (1500.0, 0.9)],
        color: &[(180.0, [0.65, 0.42, 0.32]), (450.0, [0.90, 0.82, 0.68]), (1500.0, BONE)],
    },
    Preset {
        name: "ct-skin",
        opacity: &[(-500.0, 0.0), (-150.0, 0.4), (200.0, 0.6), (1500.0, 0.9)],
        color: &[
            (-500.0, [0.75, 0.5, 0.4]),
            (-150.0, [0.9, 0.68, 0.56]),
            (200.0, [0.92, 0.75, 0.65]),
            (1500.0, BONE),
        ],
    },
    Preset {
        name: "ct-vessels",
        opacity: &[(120.0, 0.0), (220.0, 0.45), (400.0, 0.6), (1500.0, 0.9)],
        color: &[
            (120.0, [0.55, 0.08, 0.06]),
            (260.0, [0.85, 0.25, 0.18]),
            (500.0, [0.93, 0.85, 0.75]),
            (1500.0, BONE),
        ],
    },
    // 8-bit T1 brains: white matter near 200, cortex near 150.
    Preset {
        name: "mr-brain",
        opacity: &[(60.0, 0.0), (140.0, 0.5), (255.0, 0.9)],
        color: &[(0.0, [0.55, 0.25, 0.2]), (160.0, [0.85, 0.55, 0.45]), (220.0, [1.0, 0.9, 0.82])],
    },
];

/// The names of all presets.
pub const PRESET_NAMES: &[&str] = &["ct-bone", "ct-skin", "ct-vessels", "mr-brain"];

/// The transfer function of that name.
///
/// # Errors
/// If there is none; the message lists which there are.
pub fn preset(name: &str) -> Result<TransferFunction, String> {
    let Some(preset) = PRESETS.iter().find(|preset| preset.name == name) else {
        return Err(format!(
            "there is no preset {name:?}: choose one of {}",
            PRESET_NAMES.join(", ")
        ));
    };
    let opacity = preset.opacity.iter().map(|&(value, opacity)| (value, [opacity])).collect();
    Ok(TransferFunction::new(opacity, preset.color.to_vec()).expect("presets are sorted points"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_all_listed_and_valid() {
        let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        assert_eq!(names, PRESET_NAMES);
        assert!(names.iter().all(|name| preset(name).is_ok()));
        assert!(preset("ct-fog").unwrap_err().contains("ct-bone"));
    }
}
