//! How values look, as the section `[classify]` of a scene.

use std::fmt::Write;

use slabsplat_core::PiecewiseLinear;

use super::file::Look;

/// The section, and nothing else. Numbers are the shortest that are read as the same.
pub(super) fn section_text(look: &Look<'_>) -> String {
    let mut text = "[classify]\n".to_owned();
    add("opacity", look.transfer.opacity_points(), &mut text);
    add("color", look.transfer.color_points(), &mut text);
    if let Some(by_gradient) = look.gradient_opacity {
        add("gradient_opacity", by_gradient, &mut text);
    }
    text
}

fn add<const N: usize>(key: &str, curve: &PiecewiseLinear<N>, text: &mut String) {
    let point = |(position, results): &(f64, [f64; N])| {
        let numbers = std::iter::once(position).chain(results).map(|number| format!("{number:?}"));
        format!("[{}]", numbers.collect::<Vec<_>>().join(", "))
    };
    let points: Vec<String> = curve.points().iter().map(point).collect();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{key} = [{}]", points.join(", "));
}
