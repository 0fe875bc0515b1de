//! Volume properties of 3D Slicer as text: `.vp`, nine lines.
//!
//! The lines are interpolation, whether there is light, its diffuse, ambient and specular coefficients, the
//! exponent; then opacity by value, opacity by gradient and colour, each as the count of its numbers and the
//! numbers. Interpolation is not read. Slicer's opacities are per millimetre, the unit distance of VTK that
//! it does not change; its gradients are per voxel step, as here.
//! <https://slicer.readthedocs.io/en/latest/developer_guide/modules/volumerendering.html>.

use std::fmt::Write;

use slabsplat_core::{Phong, PiecewiseLinear, Shading, TransferFunction};

use super::TransferSource;
use super::file::Look;

/// What the lines hold, in order.
const LINES: [&str; 9] = [
    "interpolation",
    "shade",
    "diffuse",
    "ambient",
    "specular",
    "specular power",
    "scalar opacity",
    "gradient opacity",
    "colour",
];

/// The world length that opacities are per.
const UNIT_DISTANCE: f64 = 1.0;

/// Reads a volume property.
pub(super) fn slicer_source(text: &str) -> Result<TransferSource, String> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let Some(lines) = lines.first_chunk::<9>() else {
        let n = lines.iter().filter(|line| !line.is_empty()).count();
        return Err(format!("a volume property of 3D Slicer has 9 lines, not {n}"));
    };
    let opacity = curve::<1>(lines, 6)?.ok_or("line 7 (scalar opacity) has no points")?;
    let color = curve::<3>(lines, 8)?.ok_or("line 9 (colour) has no points")?;
    let gradient_opacity = curve::<1>(lines, 7)?;
    let is_flat = |curve: &PiecewiseLinear<1>| curve.points().iter().all(|point| point.1 == [1.0]);
    Ok(TransferSource {
        gradient_opacity: gradient_opacity.filter(|curve| !is_flat(curve)),
        shading: Some(shading(lines)?),
        unit_distance: Some(UNIT_DISTANCE),
        ..TransferSource::of_values(TransferFunction::of_curves(opacity, color))
    })
}

fn shading(lines: &[&str; 9]) -> Result<Shading, String> {
    if number(lines, 1)? == 0.0 {
        return Ok(Shading::None);
    }
    let mut phong = Phong::default();
    phong.diffuse = number(lines, 2)?;
    phong.ambient = number(lines, 3)?;
    phong.specular = number(lines, 4)?;
    phong.shininess = number(lines, 5)?;
    phong.checked().map(Shading::Phong).map_err(|error| error.to_string())
}

/// The number of a line.
fn number(lines: &[&str; 9], idx: usize) -> Result<f64, String> {
    let text = lines[idx];
    text.parse().map_err(|_| format!("line {} ({}) is {text:?}, not a number", idx + 1, LINES[idx]))
}

/// The points of a line; `None` if there are none.
fn curve<const N: usize>(
    lines: &[&str; 9],
    idx: usize,
) -> Result<Option<PiecewiseLinear<N>>, String> {
    let name = format!("line {} ({})", idx + 1, LINES[idx]);
    let mut numbers = Vec::new();
    for word in lines[idx].split_whitespace() {
        numbers.push(word.parse::<f64>().map_err(|_| format!("{name}: {word:?} is not a number"))?);
    }
    let Some((&count, numbers)) = numbers.split_first() else { return Ok(None) };
    if count != numbers.len() as f64 || numbers.len() % (N + 1) != 0 {
        let n = numbers.len();
        return Err(format!("{name} counts {count} numbers, has {n}, and needs {} a point", N + 1));
    }
    if numbers.is_empty() {
        return Ok(None);
    }
    let point = |point: &[f64]| (point[0], std::array::from_fn(|channel| point[channel + 1]));
    let what = if N == 1 { "opacity" } else { "color" };
    PiecewiseLinear::<N>::new(what, numbers.chunks_exact(N + 1).map(point))
        .map(Some)
        .map_err(|error| format!("{name}: {error}"))
}

/// A volume property as 3D Slicer reads it.
pub(super) fn slicer_text(look: &Look<'_>) -> String {
    let phong = match look.shading {
        Shading::Phong(phong) => phong,
        Shading::None => Phong::default(),
    };
    let shade = u8::from(look.shading != Shading::None);
    // Points of its own that a ramp needs which is bent over another distance.
    let opacity = look.transfer.opacity_points().over_distance(UNIT_DISTANCE / look.unit);
    let by_gradient = look.gradient_opacity.map_or_else(|| "4 0 1 255 1".to_owned(), line);
    let mut text = format!("1\n{shade}\n");
    for coefficient in [phong.diffuse, phong.ambient, phong.specular, phong.shininess] {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{coefficient}");
    }
    let _ =
        writeln!(text, "{}\n{by_gradient}\n{}", line(&opacity), line(look.transfer.color_points()));
    text
}

fn line<const N: usize>(curve: &PiecewiseLinear<N>) -> String {
    let mut line = ((N + 1) * curve.points().len()).to_string();
    for (position, results) in curve.points() {
        let _ = write!(line, " {position}");
        for result in results {
            let _ = write!(line, " {result}");
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROPERTY: &str = "1\n1\n0.9\n0.1\n0.3\n12\n6 -1000 0 150 0 400 0.8\n4 0 0.5 100 1\n\
                            8 -1000 0 0 0 400 1 0.9 0.8\n";

    fn with(from: &str, to: &str) -> Result<TransferSource, String> {
        assert!(PROPERTY.contains(from), "{from}");
        slicer_source(&PROPERTY.replacen(from, to, 1))
    }

    #[test]
    fn slicer_property_is_read() {
        let source = slicer_source(PROPERTY).unwrap();
        assert!((source.transfer.opacity(275.0) - 0.4).abs() < 1e-12);
        assert_eq!(source.transfer.color(400.0), [1.0, 0.9, 0.8]);
        assert_eq!(source.gradient_opacity.unwrap().at(50.0), [0.75]);
        let Some(Shading::Phong(phong)) = source.shading else { panic!("{:?}", source.shading) };
        assert_eq!(
            [phong.ambient, phong.diffuse, phong.specular, phong.shininess],
            [0.1, 0.9, 0.3, 12.0]
        );
        assert_eq!(source.unit_distance, Some(1.0));
        let plain = with("4 0 0.5 100 1", "4 0 1 255 1").unwrap();
        assert_eq!(plain.gradient_opacity, None);
        assert_eq!(with("1\n1\n", "1\r\n0\r\n").unwrap().shading, Some(Shading::None));
    }

    #[test]
    fn slicer_property_comes_back() {
        let source = slicer_source(PROPERTY).unwrap();
        let look = Look {
            transfer: &source.transfer,
            gradient_opacity: source.gradient_opacity.as_ref(),
            shading: source.shading.unwrap(),
            unit: 1.0,
        };
        let again = slicer_source(&slicer_text(&look)).unwrap();
        assert_eq!(again.shading, source.shading);
        assert_eq!(again.gradient_opacity, source.gradient_opacity);
        for value in [-2000.0, 0.0, 200.0, 275.0, 500.0] {
            let [a, b] = [&again, &source].map(|it| it.transfer.opacity(value));
            assert!((a - b).abs() < 1e-9, "{a}, not {b}, at {value}");
            assert_eq!(again.transfer.color(value), source.transfer.color(value));
        }
    }

    #[test]
    fn slicer_errors_name_the_line() {
        for (result, expected) in [
            (slicer_source(""), "has 9 lines, not 0"),
            (slicer_source("1\n1\n0.9\n"), "has 9 lines, not 3"),
            (with("0.9\n0.1", "much\n0.1"), "line 3 (diffuse) is \"much\", not a number"),
            (with("0.9\n0.1", "-1\n0.1"), "diffuse"),
            (with("6 -1000", "8 -1000"), "line 7 (scalar opacity) counts 8 numbers, has 6"),
            (with("6 -1000 0", "5 -1000"), "needs 2 a point"),
            (with("150 0", "150 x"), "line 7 (scalar opacity): \"x\" is not a number"),
            (with("400 0.8", "400 8"), "line 7 (scalar opacity): point 2 of opacity lies outside"),
            (with("6 -1000 0 150 0 400 0.8", ""), "line 7 (scalar opacity) has no points"),
            (with("8 -1000 0 0 0 400 1 0.9 0.8", "0"), "line 9 (colour) has no points"),
            (with("6 -1000", "6e999 -1000"), "counts inf numbers"),
        ] {
            let error = result.unwrap_err();
            assert!(error.contains(expected), "{error} should contain {expected}");
        }
    }
}
