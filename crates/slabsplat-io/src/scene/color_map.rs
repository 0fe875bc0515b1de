//! ParaView's colour maps: JSON with `RGBPoints` `[v, r, g, b, …]` and `Points` `[v, opacity, midpoint,
//! sharpness, …]`, in an array of which the first map is read.
//! <https://docs.paraview.org/en/latest/ReferenceManual/colorMapping.html>

use std::path::Path;

use serde::Deserialize;
use slabsplat_core::TransferFunction;

use crate::{IoError, text};

/// The keys that are read; a map has many more that do not matter here.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "PascalCase")]
struct ColorMap {
    #[serde(rename = "RGBPoints")]
    rgb_points: Vec<f64>,
    points: Option<Vec<f64>>,
}

/// Reads a transfer function from a colour map with opacities. Midpoints and sharpnesses are not used: the
/// function is linear between points.
///
/// # Errors
/// If the file cannot be read, is no such map, or has no opacities.
pub fn read_color_map(path: &Path) -> Result<TransferFunction, IoError> {
    let malformed = |what: String| IoError::malformed(path, what);
    let maps: Vec<ColorMap> = serde_json::from_str(&text::read(path)?)
        .map_err(|err| malformed(format!("not a ParaView colour map: {err}")))?;
    let map = maps.first().ok_or_else(|| malformed("holds no colour map".to_owned()))?;
    let points = map.points.as_ref().ok_or_else(|| {
        malformed("has no opacities (Points): save it with \"Save opacities\" on".to_owned())
    })?;
    if map.rgb_points.len() % 4 != 0 || points.len() % 4 != 0 {
        return Err(malformed("RGBPoints and Points must come in groups of 4 numbers".to_owned()));
    }
    let color = map.rgb_points.chunks_exact(4).map(|p| (p[0], [p[1], p[2], p[3]])).collect();
    let opacity = points.chunks_exact(4).map(|p| (p[0], [p[1]])).collect();
    TransferFunction::new(opacity, color).map_err(|err| malformed(err.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(json: &str) -> Result<TransferFunction, IoError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("map.json");
        std::fs::write(&path, json).unwrap();
        read_color_map(&path)
    }

    #[test]
    fn color_map_of_paraview() {
        let map = read(
            r#"[{"ColorSpace": "Diverging", "Name": "x",
                 "Points": [0, 0, 0.5, 0, 10, 1, 0.5, 0],
                 "RGBPoints": [0, 0.1, 0.2, 0.3, 10, 0.5, 0.6, 0.7]}]"#,
        )
        .unwrap();
        assert_eq!(map.opacity(5.0), 0.5);
        assert_eq!(map.color(10.0), [0.5, 0.6, 0.7]);
    }

    #[test]
    fn color_map_errors_are_plain() {
        for (json, expected) in [
            ("{", "not a ParaView colour map"),
            ("[]", "no colour map"),
            (r#"[{"RGBPoints": [0, 1, 1, 1]}]"#, "no opacities"),
            (r#"[{"RGBPoints": [0, 1, 1], "Points": [0, 1, 0, 0]}]"#, "groups of 4"),
            (r#"[{"RGBPoints": [0, 9, 1, 1], "Points": [0, 1, 0, 0]}]"#, "outside 0 to 1"),
        ] {
            let err = read(json).unwrap_err().to_string();
            assert!(err.contains(expected) && !err.contains('\n'), "{err}");
        }
    }
}
