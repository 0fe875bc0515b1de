//! Lines over an axis, as an SVG within the page. Lines differ by colour and by dashes, and the page's style
//! gives both, so that they suit a dark page and a light one.

use super::html::escaped;
use std::fmt::Write;

/// An axis.
pub(super) struct Axis<'a> {
    pub(super) label: &'a str,
    /// Where it begins and ends.
    pub(super) range: [f64; 2],
    pub(super) ticks: &'a [f64],
    pub(super) scale: Scale,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Scale {
    Linear,
    Logarithmic,
}

/// A line of a plot.
pub(super) struct Line {
    pub(super) label: String,
    pub(super) points: Vec<[f64; 2]>,
}

/// Width and height of the plot, and what labels take of it: left, right, above, below.
const SIZE: [f64; 2] = [440.0, 270.0];
const LEFT: f64 = 72.0;
const RIGHT: f64 = 12.0;
const ABOVE: f64 = 12.0;
const BELOW: f64 = 44.0;

impl Axis<'_> {
    /// How far along the axis a value is, 0 to 1 between its ends; what lies beyond is drawn at the end.
    fn share(&self, value: f64) -> f64 {
        let of = |v: f64| match self.scale {
            Scale::Linear => v,
            Scale::Logarithmic => v.max(f64::MIN_POSITIVE).ln(),
        };
        let [low, high] = self.range.map(of);
        ((of(value) - low) / (high - low)).clamp(0.0, 1.0)
    }
}

/// The plot, with what it shows below it, line by line.
pub(super) fn plot(caption: &str, x: &Axis<'_>, y: &Axis<'_>, lines: &[Line]) -> String {
    let at_x = |value: f64| LEFT + x.share(value) * (SIZE[0] - LEFT - RIGHT);
    let at_y = |value: f64| SIZE[1] - BELOW - y.share(value) * (SIZE[1] - ABOVE - BELOW);
    let [left, right] = x.range.map(at_x);
    let [bottom, top] = y.range.map(at_y);
    // Writing to a string cannot fail.
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n",
        SIZE[0],
        SIZE[1],
        escaped(caption)
    );
    for &tick in y.ticks {
        let at = at_y(tick);
        let _ = write!(svg, "<path class=\"grid\" d=\"M{left} {at:.1}H{right}\"/>");
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" class=\"y\">{tick}</text>",
            left - 6.0,
            at + 4.0
        );
    }
    for &tick in x.ticks {
        let at = at_x(tick);
        let _ = write!(svg, "<path class=\"grid\" d=\"M{at:.1} {bottom}V{top}\"/>");
        let _ =
            writeln!(svg, "<text x=\"{at:.1}\" y=\"{}\" class=\"x\">{tick}</text>", bottom + 16.0);
    }
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" class=\"x\">{}</text>\n<text transform=\"translate(13 {}) rotate(-90)\" \
         class=\"x\">{}</text>",
        f64::midpoint(left, right),
        SIZE[1] - 8.0,
        escaped(x.label),
        f64::midpoint(bottom, top),
        escaped(y.label)
    );
    for (idx, line) in lines.iter().enumerate() {
        let points = line.points.iter().map(|&[x, y]| format!("{:.1},{:.1}", at_x(x), at_y(y)));
        let points = points.collect::<Vec<_>>().join(" ");
        let _ = writeln!(svg, "<polyline class=\"line line-{idx}\" points=\"{points}\"/>");
    }
    let legend = lines.iter().enumerate().map(|(idx, line)| {
        format!(
            "<li><svg viewBox=\"0 0 30 8\" aria-hidden=\"true\"><path class=\"line line-{idx}\" \
             d=\"M1 4H29\"/></svg> {}</li>\n",
            escaped(&line.label)
        )
    });
    format!(
        "<figure>\n{svg}</svg>\n<ul class=\"legend\">\n{}</ul>\n<figcaption>{}</figcaption>\n</figure>\n",
        legend.collect::<String>(),
        escaped(caption)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plot_axis_shares() {
        let axis = |range, scale| Axis { label: "", range, ticks: &[], scale };
        let linear = axis([10.0, 30.0], Scale::Linear);
        assert_eq!([5.0, 10.0, 15.0, 30.0].map(|v| linear.share(v)), [0.0, 0.0, 0.25, 1.0]);
        let logarithmic = axis([0.01, 100.0], Scale::Logarithmic);
        assert!((logarithmic.share(1.0) - 0.5).abs() < 1e-12);
        assert_eq!(logarithmic.share(0.0), 0.0, "nothing has no logarithm");
    }

    #[test]
    fn plot_has_all_lines() {
        let axis =
            Axis { label: "a < b", range: [0.0, 1.0], ticks: &[0.0, 0.5], scale: Scale::Linear };
        let line =
            |label: &str, y| Line { label: label.to_owned(), points: vec![[0.0, y], [1.0, y]] };
        let html = plot("what", &axis, &axis, &[line("low", 0.0), line("high", 1.0)]);
        assert_eq!(html.matches("<polyline").count(), 2, "{html}");
        assert!(html.contains("points=\"72.0,226.0 428.0,226.0\""), "{html}");
        assert!(html.contains("points=\"72.0,12.0 428.0,12.0\""), "{html}");
        assert!(html.contains(">0.5</text>") && html.contains("a &lt; b"), "{html}");
    }
}
