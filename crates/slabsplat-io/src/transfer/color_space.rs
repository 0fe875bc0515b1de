//! Colour spaces between whose colours ParaView interpolates, and their lines as points in RGB.
//!
//! A transfer function is linear in RGB between its points. A line through another space is therefore cut
//! until what is between two points is straight to a quarter of a step of 8 bits.
//!
//! HSV as in A. R. Smith, "Color gamut transform pairs", SIGGRAPH 1978. CIELAB for the white of D65 and sRGB
//! of IEC 61966-2-1, its matrices as B. Lindbloom has them, each the other's inverse. Msh, the space of
//! diverging maps: K. Moreland, "Diverging Color Maps for Scientific Visualization", ISVC 2009.

use std::f64::consts::{FRAC_PI_3, TAU};

/// Red, green and blue, or coordinates in another space.
type Triple = [f64; 3];

/// In which space colours between two points are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorSpace {
    Rgb,
    Hsv,
    /// Round the circle of hues by the shorter way.
    HsvWrapped,
    Lab,
    Diverging,
    /// All between two points has the colour of the second.
    Step,
}

/// A quarter of a step of 8 bits.
const MAX_BEND: f64 = 0.25 / 255.0;

/// A line is cut into at most so many parts: 2 to that power.
const MAX_CUTS: u32 = 9;

/// Points so many are a table: what is between two of them is straight enough.
const TABLE_LEN: usize = 1024;

/// The white of D65, as CIE XYZ.
const WHITE: Triple = [0.950_47, 1.0, 1.088_83];

/// What sRGB makes of CIE XYZ: by rows, red, green and blue.
const RGB_FROM_XYZ: [Triple; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_8, 0.041_556],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

const XYZ_FROM_RGB: [Triple; 3] = [
    [0.412_456_4, 0.357_576_1, 0.180_437_5],
    [0.212_672_9, 0.715_152_2, 0.072_175],
    [0.019_333_9, 0.119_192, 0.950_304_1],
];

/// Points between which RGB is linear, for points between which that space is.
pub(super) fn in_rgb(space: ColorSpace, points: &[(f64, Triple)]) -> Vec<(f64, Triple)> {
    let mut in_rgb = Vec::with_capacity(points.len());
    let n_cuts = if points.len() < TABLE_LEN { MAX_CUTS } else { 0 };
    for (idx, &(value, color)) in points.iter().enumerate() {
        if let Some(&before) = idx.checked_sub(1).and_then(|idx| points.get(idx)) {
            add_between(space, [before, (value, color)], n_cuts, &mut in_rgb);
        }
        in_rgb.push((value, color));
    }
    in_rgb
}

/// What lies between two points, without these.
fn add_between(
    space: ColorSpace,
    [from, to]: [(f64, Triple); 2],
    n_cuts: u32,
    points: &mut Vec<(f64, Triple)>,
) {
    if to.0 <= from.0 {
        return;
    }
    match space {
        ColorSpace::Rgb => {}
        // Both would stand where a step of the points' own is.
        ColorSpace::Step => {
            let starts_a_step = points.iter().rev().nth(1).is_some_and(|it| it.0 == from.0);
            if starts_a_step {
                points.pop();
            }
            points.push((from.0, to.1));
        }
        ColorSpace::Hsv | ColorSpace::HsvWrapped | ColorSpace::Lab | ColorSpace::Diverging => {
            let line = |t: f64| {
                // Ends as they are written, and not by way of the other space.
                match t {
                    0.0 => from.1,
                    1.0 => to.1,
                    _ => between(space, from.1, to.1, t),
                }
            };
            let mut add = |t: f64, color| points.push((from.0 + t * (to.0 - from.0), color));
            cut(&line, [0.0, 1.0], n_cuts, &mut add);
        }
    }
}

/// Adds the points that a part of a line needs, without its ends.
fn cut(
    line: &impl Fn(f64) -> Triple,
    [start, end]: [f64; 2],
    n_cuts: u32,
    add: &mut impl FnMut(f64, Triple),
) {
    let ends = [line(start), line(end)];
    let is_bent = [0.25, 0.5, 0.75].into_iter().any(|t| {
        let (is, straight) = (line(mix(start, end, t)), mixed(ends[0], ends[1], t));
        is.iter().zip(straight).any(|(a, b)| MAX_BEND < (a - b).abs())
    });
    if n_cuts == 0 || !is_bent {
        return;
    }
    let middle = mix(start, end, 0.5);
    cut(line, [start, middle], n_cuts - 1, add);
    add(middle, line(middle));
    cut(line, [middle, end], n_cuts - 1, add);
}

/// The colour a part `t` of the way from `a` to `b`.
pub(super) fn between(space: ColorSpace, a: Triple, b: Triple, t: f64) -> Triple {
    match space {
        ColorSpace::Rgb => mixed(a, b, t),
        ColorSpace::Step => b,
        ColorSpace::Hsv => rgb_from_hsv(mixed(hsv_from_rgb(a), hsv_from_rgb(b), t)),
        ColorSpace::HsvWrapped => {
            let (a, mut b) = (hsv_from_rgb(a), hsv_from_rgb(b));
            b[0] -= (b[0] - a[0]).round();
            rgb_from_hsv(mixed(a, b, t))
        }
        ColorSpace::Lab => rgb_from_lab(mixed(lab_from_rgb(a), lab_from_rgb(b), t)),
        ColorSpace::Diverging => diverging(a, b, t),
    }
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

fn mixed(a: Triple, b: Triple, t: f64) -> Triple {
    [0, 1, 2].map(|channel| mix(a[channel], b[channel], t))
}

/// Hue, 0 to 1 round the circle, saturation and value.
fn hsv_from_rgb(rgb @ [r, g, b]: Triple) -> Triple {
    let (max, min) = extremes(rgb);
    let chroma = max - min;
    if chroma <= 0.0 {
        return [0.0, 0.0, max];
    }
    let sixth = if max == r {
        ((g - b) / chroma).rem_euclid(6.0)
    } else if max == g {
        (b - r) / chroma + 2.0
    } else {
        (r - g) / chroma + 4.0
    };
    [sixth / 6.0, chroma / max, max]
}

fn rgb_from_hsv([hue, saturation, value]: Triple) -> Triple {
    [5.0, 3.0, 1.0].map(|offset| {
        let sixth = (offset + 6.0 * hue).rem_euclid(6.0);
        value * (1.0 - saturation * sixth.min(4.0 - sixth).clamp(0.0, 1.0))
    })
}

fn extremes(triple: Triple) -> (f64, f64) {
    let nothing = (f64::NEG_INFINITY, f64::INFINITY);
    triple.iter().fold(nothing, |(max, min), &it| (it.max(max), it.min(min)))
}

fn product(rows: &[Triple; 3], with: Triple) -> Triple {
    rows.map(|row| row.iter().zip(with).map(|(a, b)| a * b).sum())
}

fn lab_from_rgb(rgb: Triple) -> Triple {
    let linear =
        rgb.map(|c| if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) });
    let xyz = product(&XYZ_FROM_RGB, linear);
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let part: f64 = xyz[axis] / WHITE[axis];
        if part <= 216.0 / 24_389.0 { (24_389.0 / 27.0 * part + 16.0) / 116.0 } else { part.cbrt() }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// What no screen shows keeps its hue and loses brightness, as in ParaView.
fn rgb_from_lab([l, a, b]: Triple) -> Triple {
    let y = (l + 16.0) / 116.0;
    let of_white = [y + a / 500.0, y, y - b / 200.0]
        .map(|f| if f <= 6.0 / 29.0 { (116.0 * f - 16.0) * 27.0 / 24_389.0 } else { f * f * f });
    let linear = product(&RGB_FROM_XYZ, [0, 1, 2].map(|axis| of_white[axis] * WHITE[axis]));
    let rgb = linear
        .map(|c| if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 });
    let (max, _) = extremes(rgb);
    rgb.map(|c| (c / max.max(1.0)).clamp(0.0, 1.0))
}

/// Magnitude, saturation and hue: CIELAB in polar coordinates, angles in radians.
fn msh_from_rgb(rgb: Triple) -> Triple {
    let [l, a, b] = lab_from_rgb(rgb);
    let magnitude = (l * l + a * a + b * b).sqrt();
    if magnitude < 1e-3 {
        return [magnitude, 0.0, 0.0];
    }
    let saturation = (l / magnitude).clamp(-1.0, 1.0).acos();
    [magnitude, saturation, if saturation < 1e-3 { 0.0 } else { b.atan2(a) }]
}

fn rgb_from_msh([magnitude, saturation, hue]: Triple) -> Triple {
    let radius = magnitude * saturation.sin();
    rgb_from_lab([magnitude * saturation.cos(), radius * hue.cos(), radius * hue.sin()])
}

/// A saturation from which on a colour is no gray.
const SATURATED: f64 = 0.05;

/// The least magnitude of the white between two colours.
const WHITE_MAGNITUDE: f64 = 88.0;

/// Between two colours whose hues lie apart, by way of a white.
fn diverging(a: Triple, b: Triple, t: f64) -> Triple {
    let (mut a, mut b, mut t) = (msh_from_rgb(a), msh_from_rgb(b), t);
    let apart = (a[2] - b[2]).abs();
    let apart = apart.min(TAU - apart);
    if SATURATED < a[1] && SATURATED < b[1] && FRAC_PI_3 < apart {
        let white = [a[0].max(b[0]).max(WHITE_MAGNITUDE), 0.0, 0.0];
        if t < 0.5 {
            (b, t) = (white, 2.0 * t);
        } else {
            (a, t) = (white, 2.0 * t - 1.0);
        }
    }
    // A gray has no hue: it is given the one that makes all between look alike.
    if a[1] < SATURATED && SATURATED < b[1] {
        a[2] = spun_hue(b, a[0]);
    } else if b[1] < SATURATED && SATURATED < a[1] {
        b[2] = spun_hue(a, b[0]);
    }
    let turn = b[2] - a[2];
    b[2] -= TAU * (turn / TAU).round();
    rgb_from_msh(mixed(a, b, t))
}

/// The hue with which a gray of a larger magnitude goes with a colour: a bright gray needs a turn.
fn spun_hue([magnitude, saturation, hue]: Triple, of_gray: f64) -> f64 {
    if of_gray <= magnitude {
        return hue;
    }
    let root = (of_gray * of_gray - magnitude * magnitude).sqrt();
    let spin = saturation * root / (magnitude * saturation.sin());
    // Away from purple.
    if -FRAC_PI_3 < hue { hue + spin } else { hue - spin }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Far below a step of 8 bits.
    fn is_close(a: Triple, b: Triple) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
    }

    fn bytes(color: Triple) -> [i32; 3] {
        color.map(|channel| (255.0 * channel).round() as i32)
    }

    /// The first ends, the middle and some more of Moreland's `CoolWarmFloat33.csv`, at
    /// <https://www.kennethmoreland.com/color-maps/>; ParaView's default map.
    #[test]
    fn diverging_is_morelands() {
        let ends = [
            [0.229_805_7, 0.298_717_966, 0.753_683_153],
            [0.705_673_158, 0.015_556_16, 0.150_232_812],
        ];
        for (t, expected) in [
            (0.0, ends[0]),
            (0.031_25, [0.266_233_88, 0.353_094_838, 0.801_466_763]),
            (0.125, [0.383_013_34, 0.509_419_04, 0.917_387_822]),
            (0.25, [0.552_953_156, 0.688_929_332, 0.995_375_608]),
            (0.375, [0.722_193_294, 0.813_952_739, 0.976_574_709]),
            (0.468_75, [0.833_466_556, 0.860_207_984, 0.901_068_838]),
            (0.5, [0.865_395_197, 0.865_410_21, 0.865_395_561]),
            (0.531_25, [0.897_787_179, 0.848_937_047, 0.820_880_546]),
            (0.625, [0.958_852_946, 0.769_767_752, 0.678_007_945]),
            (1.0, ends[1]),
        ] {
            let color = between(ColorSpace::Diverging, ends[0], ends[1], t);
            let error = color.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1.0 / 512.0, "{color:?} at {t} should be {expected:?}");
        }
    }

    /// CIELAB of sRGB's corners: B. Lindbloom's calculator, D65, rounded.
    #[test]
    fn lab_is_cielab() {
        for (rgb, expected) in [
            ([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]),
            ([0.0, 1.0, 0.0], [87.73, -86.18, 83.18]),
            ([0.0, 0.0, 1.0], [32.30, 79.19, -107.86]),
            ([1.0, 1.0, 1.0], [100.0, 0.0, 0.0]),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ([0.5, 0.5, 0.5], [53.39, 0.0, 0.0]),
        ] {
            let lab = lab_from_rgb(rgb);
            assert!(lab.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05), "{rgb:?} {lab:?}");
            assert!(is_close(rgb_from_lab(lab), rgb), "{rgb:?} there and back");
        }
        // Half-way between black and white is the gray of lightness 50.
        assert_eq!(bytes(between(ColorSpace::Lab, [0.0; 3], [1.0; 3], 0.5)), [119; 3]);
    }

    #[test]
    fn hsv_goes_round_one_way_or_the_other() {
        let [red, magenta] = [[1.0, 0.0, 0.0], [1.0, 0.0, 1.0]];
        let check = |space, expected: [i32; 3]| {
            assert_eq!(bytes(between(space, red, magenta, 0.4)), expected, "{space:?}");
        };
        check(ColorSpace::Rgb, [255, 0, 102]);
        // Hues 0 and 5/6: by way of 1/3, or of 14/15.
        check(ColorSpace::Hsv, [0, 255, 0]);
        check(ColorSpace::HsvWrapped, [255, 0, 102]);
        for rgb in [[0.2, 0.4, 0.9], [0.9, 0.3, 0.31], [0.1, 0.8, 0.2], [0.5; 3], [0.0; 3]] {
            assert!(is_close(rgb_from_hsv(hsv_from_rgb(rgb)), rgb), "{rgb:?}");
        }
    }

    #[test]
    fn points_follow_the_space() {
        let ends = [(-10.0, [0.23, 0.3, 0.754]), (30.0, [0.706, 0.016, 0.15])];
        for space in
            [ColorSpace::Hsv, ColorSpace::HsvWrapped, ColorSpace::Lab, ColorSpace::Diverging]
        {
            let points = in_rgb(space, &ends);
            assert!(3 < points.len() && points.len() < 130, "{} points", points.len());
            assert_eq!([points[0], points[points.len() - 1]], ends);
            let curve = slabsplat_core::PiecewiseLinear::new("color", points).unwrap();
            for step in 0..=1000 {
                let t = f64::from(step) / 1000.0;
                let expected = between(space, ends[0].1, ends[1].1, t);
                let is = curve.at(-10.0 + 40.0 * t);
                let error = is.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(error < 0.5 / 255.0, "{space:?} at {t}: {is:?}, not {expected:?}");
            }
        }
        let points = [(0.0, [0.0; 3]), (1.0, [0.5; 3]), (2.0, [1.0; 3])];
        assert_eq!(in_rgb(ColorSpace::Rgb, &points), points);
        let steps = in_rgb(ColorSpace::Step, &points);
        let curve = slabsplat_core::PiecewiseLinear::new("color", steps).unwrap();
        let at = [0.0, 0.5, 1.0, 1.5, 2.0].map(|value| curve.at(value)[0]);
        assert_eq!(at, [0.5, 0.5, 1.0, 1.0, 1.0]);
    }
}
