//! Colour maps by name, from 0 to 1.
//!
//! Crates that have such maps were looked at: colorous 1.0.16 takes turbo and cividis from polynomials, which
//! are up to 32 and 19 steps of 8 bits off the published tables. Points of these tables are data of ours.

use std::collections::BTreeMap;

use slabsplat_core::PiecewiseLinear;

use super::color_space::{ColorSpace, in_rgb};
use crate::IoError;

/// The colour maps that [`colormap`] knows. With `_r` behind its name, each runs backwards.
pub const COLORMAP_NAMES: &[&str] = &[
    "viridis",
    "magma",
    "inferno",
    "plasma",
    "cividis",
    "turbo",
    "gray",
    "hot",
    "cool-warm",
    "red",
    "green",
    "blue",
    "cyan",
    "magenta",
    "yellow",
];

const TABLES: &str = include_str!("colormaps.toml");

/// Entries of the published tables.
const N_ENTRIES: f64 = 256.0;

type Point = (f64, [f64; 3]);

/// Colours from 0 to 1: viridis, magma, inferno, plasma, cividis and turbo as published, hot as in matplotlib
/// and MATLAB, Moreland's cool-warm, and from black to gray or to one colour for channels of a microscope.
///
/// # Errors
/// If there is no map of that name; the message lists those that there are.
pub fn colormap(name: &str) -> Result<PiecewiseLinear<3>, IoError> {
    let (forward, is_reversed) = match name.strip_suffix("_r") {
        Some(forward) => (forward, true),
        None => (name, false),
    };
    let points =
        points(forward).ok_or_else(|| IoError::UnknownColormap { name: name.to_owned() })?;
    let points = if is_reversed {
        points.into_iter().rev().map(|(at, color)| (1.0 - at, color)).collect()
    } else {
        points
    };
    Ok(PiecewiseLinear::new("color", points).expect("the maps are valid, as a test has seen"))
}

fn points(name: &str) -> Option<Vec<Point>> {
    let from_black = |color: [f64; 3]| vec![(0.0, [0.0; 3]), (1.0, color)];
    Some(match name {
        "gray" => from_black([1.0; 3]),
        "red" => from_black([1.0, 0.0, 0.0]),
        "green" => from_black([0.0, 1.0, 0.0]),
        "blue" => from_black([0.0, 0.0, 1.0]),
        "cyan" => from_black([0.0, 1.0, 1.0]),
        "magenta" => from_black([1.0, 0.0, 1.0]),
        "yellow" => from_black([1.0, 1.0, 0.0]),
        "hot" => vec![
            (0.0, [0.0416, 0.0, 0.0]),
            (0.365_079, [1.0, 0.0, 0.0]),
            (0.746_032, [1.0, 1.0, 0.0]),
            (1.0, [1.0; 3]),
        ],
        // K. Moreland's ends: 59, 76, 192 and 180, 4, 38 of 255.
        "cool-warm" => in_rgb(
            ColorSpace::Diverging,
            &[(0.0, [0.2298, 0.2987, 0.7537]), (1.0, [0.7057, 0.0156, 0.1502])],
        ),
        _ => return table(name),
    })
}

/// The points of a published table.
fn table(name: &str) -> Option<Vec<Point>> {
    let mut tables: BTreeMap<String, Vec<[f64; 4]>> =
        toml::from_str(TABLES).expect("the tables are TOML, as a test has seen");
    let points = tables.remove(name)?;
    Some(
        points.into_iter().map(|[entry, r, g, b]| (entry / (N_ENTRIES - 1.0), [r, g, b])).collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries 0, 32, 64, 128, 192 and 255 of the tables of 256, in 8 bits: matplotlib 3.11.2,
    /// `matplotlib.colormaps[name]`; of cool-warm, the 33 values of `CoolWarmFloat33.csv`.
    const PUBLISHED: &[(&str, [[i32; 3]; 6])] = &[
        (
            "viridis",
            [
                [68, 1, 84],
                [71, 45, 123],
                [59, 82, 139],
                [33, 145, 140],
                [94, 201, 98],
                [253, 231, 37],
            ],
        ),
        (
            "magma",
            [
                [0, 0, 4],
                [29, 17, 71],
                [81, 18, 124],
                [183, 55, 121],
                [252, 137, 97],
                [252, 253, 191],
            ],
        ),
        (
            "inferno",
            [[0, 0, 4], [33, 12, 74], [87, 16, 110], [188, 55, 84], [249, 142, 9], [252, 255, 164]],
        ),
        (
            "plasma",
            [
                [13, 8, 135],
                [76, 2, 161],
                [126, 3, 168],
                [204, 71, 120],
                [248, 149, 64],
                [240, 249, 33],
            ],
        ),
        (
            "cividis",
            [
                [0, 34, 78],
                [26, 56, 111],
                [67, 78, 108],
                [125, 124, 120],
                [188, 174, 108],
                [254, 232, 56],
            ],
        ),
        (
            "turbo",
            [
                [48, 18, 59],
                [70, 107, 227],
                [40, 188, 235],
                [164, 252, 60],
                [251, 126, 33],
                [122, 4, 3],
            ],
        ),
        (
            "hot",
            [[11, 0, 0], [95, 0, 0], [179, 0, 0], [255, 92, 0], [255, 255, 7], [255, 255, 255]],
        ),
        ("gray", [[0; 3], [32; 3], [64; 3], [128; 3], [192; 3], [255; 3]]),
    ];

    #[test]
    fn colormaps_are_as_published() {
        for &(name, colors) in PUBLISHED {
            let map = colormap(name).unwrap();
            for (entry, expected) in [0.0, 32.0, 64.0, 128.0, 192.0, 255.0].into_iter().zip(colors)
            {
                let color = map.at(entry / 255.0);
                // Half a step is rounding, the rest is what points leave out.
                let is_close = color
                    .iter()
                    .zip(expected)
                    .all(|(is, e)| (255.0 * is - f64::from(e)).abs() < 0.95);
                assert!(is_close, "{name} at {entry}: {color:?} should be {expected:?}");
            }
        }
        let middle = colormap("cool-warm").unwrap().at(0.5);
        assert!(middle.iter().all(|channel| (channel - 0.8654).abs() < 0.002), "{middle:?}");
    }

    #[test]
    fn colormaps_span_0_to_1() {
        for name in COLORMAP_NAMES {
            let [map, reversed] =
                [(*name).to_owned(), format!("{name}_r")].map(|it| colormap(&it).unwrap());
            let points = map.points();
            assert_eq!([points[0].0, points[points.len() - 1].0], [0.0, 1.0], "{name}");
            for at in [0.0, 0.3, 0.5, 1.0] {
                let both = map.at(at).into_iter().zip(reversed.at(1.0 - at));
                assert!(both.into_iter().all(|(a, b)| (a - b).abs() < 1e-9), "{name} at {at}");
            }
        }
        let error = colormap("jet").unwrap_err().to_string();
        assert!(error.contains("\"jet\"") && error.contains("turbo"), "{error}");
    }
}
