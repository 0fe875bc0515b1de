//! Transfer functions of ParaView: JSON with `RGBPoints` and `Points`.
//!
//! Read: the first map of the file; its colours in the `ColorSpace` that it names, its opacities with their
//! midpoints, and `ScalarOpacityUnitDistance`. A map over 0 … 1 is stretched to the volume's values, as
//! ParaView does where it applies one. A sharpness counts as a step if it is (nearly) 1, else as none.
//! CIEDE2000 is taken as CIELAB, of which it is another measure. Not read: the colour of NaN, which is never
//! drawn here, and indexed colours.

use serde::Deserialize;
use serde_json::json;
use slabsplat_core::{PiecewiseLinear, TransferFunction};

use super::color_space::{ColorSpace, in_rgb};
use super::file::Look;
use super::{TransferSource, ValueScale};

#[derive(Deserialize)]
struct ColorMap {
    /// Value, red, green, blue, value, …
    #[serde(rename = "RGBPoints")]
    rgb_points: Option<Vec<f64>>,
    /// Value, opacity, midpoint, sharpness, value, …
    #[serde(rename = "Points")]
    points: Option<Vec<f64>>,
    #[serde(rename = "ColorSpace")]
    color_space: Option<String>,
    #[serde(rename = "HSVWrap")]
    hsv_wrap: Option<Flag>,
    #[serde(rename = "ScalarOpacityUnitDistance")]
    unit_distance: Option<f64>,
    #[serde(rename = "IndexedColors")]
    indexed_colors: Option<serde_json::Value>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Flag {
    Bool(bool),
    Number(f64),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Maps {
    Many(Vec<ColorMap>),
    One(Box<ColorMap>),
}

/// A sharpness from which on a ramp is a step, as ParaView draws it.
const STEP_SHARPNESS: f64 = 0.99;

const NOT_A_MAP: &str = "not a ParaView colour map: an object with numbers in RGBPoints is missing";

const INDEXED: &str =
    "a ParaView map of categories (IndexedColors): it has colours of labels, none of values";

/// The first colour map of a text. Without opacities it rises from 0 to 1 over its colours.
pub(super) fn paraview_source(text: &str) -> Result<TransferSource, String> {
    let maps: Maps = serde_json::from_str(text).map_err(|error| {
        // What an untagged enum says of itself helps nobody.
        match error.classify() {
            serde_json::error::Category::Data => NOT_A_MAP.to_owned(),
            _ => format!("not JSON: {error}"),
        }
    })?;
    let maps = match maps {
        Maps::Many(maps) => maps,
        Maps::One(map) => vec![*map],
    };
    let is_indexed = maps.iter().any(|map| map.indexed_colors.is_some());
    let map = maps.into_iter().find(|map| map.rgb_points.is_some());
    let map = map.ok_or_else(|| if is_indexed { INDEXED } else { NOT_A_MAP }.to_owned())?;
    map.into_source()
}

impl ColorMap {
    fn into_source(self) -> Result<TransferSource, String> {
        let space = self.color_space()?;
        let curve_error = |error: slabsplat_core::TransferError| error.to_string();
        let points = colors(self.rgb_points.as_deref().unwrap_or_default())?;
        // Before anything is interpolated between them.
        let color = PiecewiseLinear::new("color", points).map_err(curve_error)?;
        let span = color.span();
        let opacity = match &self.points {
            Some(points) => opacities(points)?,
            None => vec![(span[0], [0.0]), (span[1], [1.0])],
        };
        let mut opacity = PiecewiseLinear::new("opacity", opacity).map_err(curve_error)?;
        let color =
            PiecewiseLinear::new("color", in_rgb(space, color.points())).map_err(curve_error)?;
        let is_relative = span == [0.0, 1.0];
        let [lo, hi] = opacity.span();
        // ParaView stretches either to the same values.
        if is_relative && (lo < 0.0 || 1.0 < hi) {
            opacity = opacity.moved("opacity", [lo, hi], span).map_err(curve_error)?;
        }
        if let Some(distance) = self.unit_distance.filter(|it| !it.is_normal() || *it < 0.0) {
            return Err(format!("ScalarOpacityUnitDistance is a positive length, not {distance}"));
        }
        Ok(TransferSource {
            scale: if is_relative { ValueScale::Data } else { ValueScale::Values },
            unit_distance: self.unit_distance,
            ..TransferSource::of_values(TransferFunction::of_curves(opacity, color))
        })
    }

    fn color_space(&self) -> Result<ColorSpace, String> {
        let wraps = match self.hsv_wrap {
            Some(Flag::Bool(wraps)) => wraps,
            Some(Flag::Number(number)) => number != 0.0,
            None => false,
        };
        Ok(match self.color_space.as_deref() {
            None | Some("RGB") => ColorSpace::Rgb,
            Some("HSV") if wraps => ColorSpace::HsvWrapped,
            Some("HSV" | "HSVNoWrap") => ColorSpace::Hsv,
            Some("Lab" | "CIELAB" | "Lab/CIEDE2000" | "CIEDE2000") => ColorSpace::Lab,
            Some("Diverging") => ColorSpace::Diverging,
            Some("Step") => ColorSpace::Step,
            Some(other) => {
                let known = "RGB, HSV, Lab, CIELAB, Lab/CIEDE2000, Diverging, Step";
                return Err(format!("ColorSpace is {other:?}: expected one of {known}"));
            }
        })
    }
}

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

/// A map as ParaView imports it, in RGB, with linear opacities.
pub(super) fn paraview_text(look: &Look<'_>) -> String {
    let color = look.transfer.color_points().points().iter();
    let rgb: Vec<f64> = color.flat_map(|&(value, [r, g, b])| [value, r, g, b]).collect();
    let opacity = look.transfer.opacity_points().points().iter();
    let points: Vec<f64> = opacity.flat_map(|&(value, [alpha])| [value, alpha, 0.5, 0.0]).collect();
    let map = json!([{
        "Name": "slabsplat",
        "ColorSpace": "RGB",
        "RGBPoints": rgb,
        "Points": points,
        "ScalarOpacityUnitDistance": look.unit,
    }]);
    format!("{map:#}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(keys: &str) -> TransferSource {
        paraview_source(&format!("[{{{keys}}}]")).unwrap()
    }

    #[test]
    fn color_map_of_paraview() {
        let source = map(r#""ColorSpace": "RGB", "Name": "x", "NanColor": [1, 1, 0],
               "Points": [0, 0, 0.5, 0, 10, 0.5, 0.25, 0, 20, 1, 0.5, 1, 30, 0, 0.5, 0],
               "RGBPoints": [0, 0, 0, 0, 30, 1, 0.5, 0]"#);
        assert_eq!((source.scale, source.unit_distance), (ValueScale::Values, None));
        let transfer = source.transfer;
        assert_eq!(transfer.color(15.0), [0.5, 0.25, 0.0]);
        for (value, opacity) in
            [(5.0, 0.25), (12.5, 0.75), (20.0, 1.0), (24.9, 1.0), (25.0, 0.0), (99.0, 0.0)]
        {
            assert!((transfer.opacity(value) - opacity).abs() < 1e-12, "at {value}");
        }
    }

    #[test]
    fn color_map_without_opacity_is_a_ramp() {
        let transfer = map(r#""RGBPoints": [-2, 0, 0, 0, 2, 1, 1, 1]"#).transfer;
        assert_eq!([-2.0, 0.0, 2.0].map(|v| transfer.opacity(v)), [0.0, 0.5, 1.0]);
    }

    #[test]
    fn color_map_from_0_to_1_is_relative() {
        let source = map(
            r#""RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1], "Points": [-5, 0, 0.5, 0, 15, 1, 0.5, 0],
               "ScalarOpacityUnitDistance": 2.5"#,
        );
        assert_eq!((source.scale, source.unit_distance), (ValueScale::Data, Some(2.5)));
        assert_eq!(source.transfer.opacity(0.5), 0.5, "its own span is 0 to 1, too");
    }

    /// Half-way from blue to red, by ParaView's names. CIELAB's is the value in chroma.js' documentation,
    /// `chroma.mix('red', 'blue', 0.5, 'lab')`: `#ca0088`. HSV goes from hue 2/3 to 0.
    #[test]
    fn color_map_honours_its_space() {
        let check = |keys: &str, expected: [i32; 3]| {
            let keys = format!(r#""RGBPoints": [0, 0, 0, 1, 10, 1, 0, 0], {keys}"#);
            let color = map(&keys).transfer.color(5.0).map(|c| (255.0 * c).round() as i32);
            assert_eq!(color, expected, "{keys}");
        };
        check(r#""ColorSpace": "RGB""#, [128, 0, 128]);
        check(r#""ColorSpace": "HSV""#, [0, 255, 0]);
        check(r#""ColorSpace": "HSV", "HSVWrap": 1"#, [255, 0, 255]);
        for lab in ["Lab", "CIELAB", "Lab/CIEDE2000"] {
            check(&format!(r#""ColorSpace": "{lab}""#), [202, 0, 136]);
        }
        check(r#""ColorSpace": "Step""#, [255, 0, 0]);
    }

    #[test]
    fn color_map_errors_are_plain() {
        for (json, expected) in [
            ("", "not JSON"),
            ("[1, 2", "not JSON"),
            ("[]", "RGBPoints is missing"),
            ("{}", "RGBPoints is missing"),
            (r#"[{"RGBPoints": "red"}]"#, "RGBPoints is missing"),
            (r#"[{"IndexedColors": [1, 0, 0], "Annotations": ["1", "a"]}]"#, "map of categories"),
            (r#"[{"RGBPoints": [0, 1, 1]}]"#, "RGBPoints has 3 numbers"),
            (r#"[{"RGBPoints": [0, 1, 1, 1], "Points": [1]}]"#, "Points has 1 numbers"),
            (r#"[{"RGBPoints": [0, 1, 9, 1]}]"#, "outside 0 to 1"),
            (r#"[{"RGBPoints": [5, 1, 1, 1, 0, 1, 1, 1]}]"#, "out of order"),
            (r#"[{"RGBPoints": [5, 1, 1, 1], "ColorSpace": "XYZ"}]"#, "ColorSpace is \"XYZ\""),
            (
                r#"[{"RGBPoints": [5, 1, 1, 1], "ScalarOpacityUnitDistance": 0}]"#,
                "positive length, not 0",
            ),
        ] {
            let error = paraview_source(json).unwrap_err();
            assert!(error.contains(expected), "{error} should contain {expected}");
            assert!(!error.contains('\n'), "{error} should be one line");
        }
    }
}
