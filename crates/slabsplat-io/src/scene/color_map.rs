//! Transfer functions that ParaView has exported: JSON with `RGBPoints` and `Points`.
//!
//! Read: the first map of the file, its colours between the points in RGB whatever `ColorSpace`
//! says, its opacities with their midpoints. A sharpness counts as a step if it is (nearly) 1, else
//! as none. Not read: the colour of NaN, which is never drawn here, and indexed colours. ParaView's
//! opacities are per its own unit distance; here they are per voxel step.

use std::path::Path;

use serde::Deserialize;
use slabsplat_core::TransferFunction;

use crate::{IoError, text};

#[derive(Deserialize)]
struct ColorMap {
    /// Value, red, green, blue, value, …
    #[serde(rename = "RGBPoints")]
    rgb_points: Option<Vec<f64>>,
    /// Value, opacity, midpoint, sharpness, value, …
    #[serde(rename = "Points")]
    points: Option<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Maps {
    Many(Vec<ColorMap>),
    One(ColorMap),
}

/// A sharpness from which on a ramp is a step, as ParaView draws it.
const STEP_SHARPNESS: f64 = 0.99;

/// Reads the first colour map of a ParaView `.json` file. Values stay as they are: export the map
/// with the range that it is meant for. Without opacities it rises from 0 to 1 over its colours.
///
/// # Errors
/// If the file cannot be read, is not such a file, or its points do not make a transfer function.
pub fn read_color_map(path: impl AsRef<Path>) -> Result<TransferFunction, IoError> {
    let path = path.as_ref();
    let malformed = |what: String| IoError::malformed(path, what);
    let maps: Maps = serde_json::from_str(&text::read(path)?).map_err(|e| {
        // What an untagged enum says of itself helps nobody.
        match e.classify() {
            serde_json::error::Category::Data => malformed(NOT_A_MAP.to_owned()),
            _ => malformed(format!("not JSON: {e}")),
        }
    })?;
    let map = match maps {
        Maps::Many(maps) => maps.into_iter().find(|map| map.rgb_points.is_some()),
        Maps::One(map) => Some(map),
    };
    let (rgb_points, points) = map
        .and_then(|map| Some((map.rgb_points?, map.points)))
        .ok_or_else(|| malformed(NOT_A_MAP.to_owned()))?;
    let color = colors(&rgb_points).map_err(malformed)?;
    let opacity = match points {
        Some(points) => opacities(&points).map_err(malformed)?,
        None => ramp(&color),
    };
    TransferFunction::new(opacity, color).map_err(|e| malformed(e.to_string()))
}

const NOT_A_MAP: &str = "not a ParaView colour map: an object with numbers in RGBPoints is missing";

fn colors(numbers: &[f64]) -> Result<Vec<(f64, [f64; 3])>, String> {
    let (points, rest) = numbers.as_chunks::<4>();
    if points.is_empty() || !rest.is_empty() {
        return Err(format!("RGBPoints has {} numbers, not a multiple of 4", numbers.len()));
    }
    Ok(points.iter().map(|&[value, r, g, b]| (value, [r, g, b])).collect())
}

fn opacities(numbers: &[f64]) -> Result<Vec<(f64, [f64; 1])>, String> {
    let (points, rest) = numbers.as_chunks::<4>();
    if points.is_empty() || !rest.is_empty() {
        return Err(format!("Points has {} numbers, not a multiple of 4", numbers.len()));
    }
    let mut opacities = Vec::with_capacity(2 * points.len());
    for (idx, &[value, opacity, midpoint, sharpness]) in points.iter().enumerate() {
        opacities.push((value, [opacity]));
        if let Some(&[next, next_opacity, ..]) = points.get(idx + 1) {
            let middle = value + midpoint * (next - value);
            // A middle at either end would make a third point there.
            if !(value < middle && middle < next) {
                continue;
            }
            if STEP_SHARPNESS < sharpness {
                opacities.extend([(middle, [opacity]), (middle, [next_opacity])]);
            } else {
                opacities.push((middle, [(opacity + next_opacity) / 2.0]));
            }
        }
    }
    Ok(opacities)
}

/// From nothing at the first colour to everything at the last.
fn ramp(color: &[(f64, [f64; 3])]) -> Vec<(f64, [f64; 1])> {
    let ends = [color.first(), color.last()].into_iter().flatten();
    ends.zip([0.0, 1.0]).map(|(&(value, _), opacity)| (value, [opacity])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(json: &str) -> Result<TransferFunction, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("map.json");
        std::fs::write(&path, json).unwrap();
        read_color_map(&path).map_err(|e| e.to_string())
    }

    #[test]
    fn color_map_of_paraview() {
        let transfer = read(
            r#"[{"ColorSpace": "RGB", "Name": "x", "NanColor": [1, 1, 0],
                "Points": [0, 0, 0.5, 0, 10, 0.5, 0.25, 0, 20, 1, 0.5, 1, 30, 0, 0.5, 0],
                "RGBPoints": [0, 0, 0, 0, 30, 1, 0.5, 0]}]"#,
        )
        .unwrap();
        assert_eq!(transfer.color(15.0), [0.5, 0.25, 0.0]);
        for (value, opacity) in
            [(5.0, 0.25), (12.5, 0.75), (20.0, 1.0), (24.9, 1.0), (25.0, 0.0), (99.0, 0.0)]
        {
            assert!((transfer.opacity(value) - opacity).abs() < 1e-12, "at {value}");
        }
    }

    #[test]
    fn color_map_without_opacity_is_a_ramp() {
        let transfer = read(r#"{"RGBPoints": [-2, 0, 0, 0, 2, 1, 1, 1]}"#).unwrap();
        assert_eq!([-2.0, 0.0, 2.0].map(|v| transfer.opacity(v)), [0.0, 0.5, 1.0]);
    }

    #[test]
    fn color_map_errors_are_plain() {
        for (json, expected) in [
            ("", "not JSON"),
            ("[1, 2", "not JSON"),
            ("[]", "RGBPoints is missing"),
            ("{}", "RGBPoints is missing"),
            (r#"[{"RGBPoints": "red"}]"#, "RGBPoints is missing"),
            (r#"[{"RGBPoints": [0, 1, 1]}]"#, "RGBPoints has 3 numbers"),
            (r#"[{"RGBPoints": [0, 1, 1, 1], "Points": [1]}]"#, "Points has 1 numbers"),
            (r#"[{"RGBPoints": [0, 1, 9, 1]}]"#, "outside 0 to 1"),
            (r#"[{"RGBPoints": [5, 1, 1, 1, 0, 1, 1, 1]}]"#, "out of order"),
        ] {
            let err = read(json).unwrap_err();
            assert!(err.contains(expected), "{err} should contain {expected}");
            assert!(!err.contains('\n'), "{err} should be one line");
        }
    }
}
