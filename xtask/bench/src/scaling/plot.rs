//! Plots as SVG: both axes logarithmic, so that growth by the same power has the same slope everywhere.

use std::ops::Range;
use std::path::Path;

use anyhow::{Result, anyhow, ensure};
use plotters::coord::Shift;
use plotters::coord::combinators::{LogCoord, WithKeyPoints};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Curve, Point, Sweep};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Axis = WithKeyPoints<LogCoord<f64>>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

const SIZE: (u32, u32) = (720, 420);
const FONT: &str = "sans-serif";
const TEXT: RGBColor = RGBColor(60, 60, 60);
const GRID: RGBColor = RGBColor(225, 225, 225);
const IDEAL: RGBColor = RGBColor(140, 140, 140);

/// Dark enough on white, and apart for those who see fewer colours: Okabe and Ito's.
const COLORS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 130, 95), RGBColor(190, 90, 150)];

/// Room at the right for the curves' names, which stand at their ends, and from name to name.
const NAMES_WIDTH: u32 = 130;
const NAME_HEIGHT: i32 = 17;

/// Draws the curves of a sweep, which have a point at least.
pub(super) fn draw(path: &Path, sweep: &Sweep, curves: &[Curve]) -> Result<()> {
    let curves: Vec<&Curve> = curves.iter().filter(|curve| !curve.points.is_empty()).collect();
    ensure!(!curves.is_empty(), "nothing is measured that {} could show", path.display());
    let area = SVGBackend::new(path, SIZE).into_drawing_area();
    draw_on(&area, sweep, &curves)
        .and_then(|()| area.present())
        .map_err(|error| anyhow!("cannot draw {}: {error}", path.display()))
}

type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

fn draw_on(area: &Area<'_>, sweep: &Sweep, curves: &[&Curve]) -> Drawn {
    area.fill(&WHITE)?;
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let y_ticks = ticks_around(points().map(|point| point.ms));
    let x_ticks: Vec<f64> = sweep.ticks();
    // What is measured need not end at a tick.
    let mut beyond: Vec<f64> =
        x_ticks.iter().copied().chain(points().map(|point| point.x)).collect();
    beyond.sort_by(f64::total_cmp);
    let mut chart = ChartBuilder::on(area)
        .caption(sweep.title, (FONT, 17).into_font().color(&TEXT))
        .margin(12)
        .margin_right(NAMES_WIDTH)
        .x_label_area_size(46)
        .y_label_area_size(64)
        .build_cartesian_2d(
            wide(&beyond, 1.08).log_scale().with_key_points(x_ticks),
            wide(&y_ticks, 1.0).log_scale().with_key_points(y_ticks),
        )?;
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(TEXT)
        .label_style((FONT, 13).into_font().color(&TEXT))
        .x_label_formatter(&|&x| (sweep.label)(x))
        .y_label_formatter(&|&ms| time(ms))
        .x_desc(sweep.unit)
        .y_desc("median of a frame")
        .draw()?;
    let ideal = ideal(sweep, curves, &chart.y_range());
    let dashed = DashedLineSeries::new(coordinates(&ideal), 5, 4, IDEAL.stroke_width(1));
    chart.draw_series(dashed)?;
    for (curve, &color) in curves.iter().zip(COLORS.iter().cycle()) {
        chart.draw_series(LineSeries::new(coordinates(curve), color.stroke_width(2)))?;
        chart.draw_series(coordinates(curve).map(|at| Circle::new(at, 3.5, color.filled())))?;
    }
    let colored = curves.iter().copied().zip(COLORS.iter().cycle());
    draw_names(area, &chart, colored.chain([(&ideal, &IDEAL)]))
}

fn coordinates(curve: &Curve) -> impl Iterator<Item = (f64, f64)> + Clone {
    curve.points.iter().map(|point| (point.x, point.ms))
}

/// The slope of a frame all of which grows or shrinks with x, from the start of the highest curve to where
/// the plot ends.
fn ideal(sweep: &Sweep, curves: &[&Curve], y_range: &Range<f64>) -> Curve {
    let firsts = curves.iter().filter_map(|curve| curve.points.first());
    let Some(&Point { x, ms }) = firsts.max_by(|a, b| a.ms.total_cmp(&b.ms)) else {
        return Curve { name: "", points: Vec::new() };
    };
    // Many points, as the plot may end before the line does.
    let at = |step: u32| {
        let far = x * (sweep.last_x() / x).powf(f64::from(step) / 200.0);
        Point { x: far, ms: ms * (far / x).powf(sweep.ideal_power) }
    };
    let points =
        (0..=200).map(at).filter(|point| (y_range.start..=y_range.end).contains(&point.ms));
    let name = if 0.0 < sweep.ideal_power { "proportional" } else { "reciprocal" };
    Curve { name, points: points.collect() }
}

/// The names at the ends of their curves, moved apart where they would touch.
fn draw_names<'c>(
    area: &Area<'_>,
    chart: &Chart<'_, '_>,
    curves: impl Iterator<Item = (&'c Curve, &'c RGBColor)>,
) -> Drawn {
    let ends = curves.filter_map(|(curve, color)| {
        let end = curve.points.last()?;
        Some((chart.backend_coord(&(end.x, end.ms)), curve.name, color))
    });
    let mut ends: Vec<_> = ends.collect();
    ends.sort_by_key(|((_, y), ..)| *y);
    let ys = apart(&ends.iter().map(|((_, y), ..)| *y).collect::<Vec<_>>());
    for (((x, _), name, color), y) in ends.into_iter().zip(ys) {
        let style = (FONT, 13).into_font().color(color).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(name, (x + 12, y), style))?;
    }
    Ok(())
}

/// Heights from above to below, as near to where they are as leaves room for names.
fn apart(ys: &[i32]) -> Vec<i32> {
    let mut ys = ys.to_vec();
    for idx in 1..ys.len() {
        let overlap = NAME_HEIGHT - (ys[idx] - ys[idx - 1]);
        if 0 < overlap {
            // Those above move up by half of it, which may push on.
            let up = overlap / 2;
            ys[..idx].iter_mut().for_each(|y| *y -= up);
            ys[idx] += overlap - up;
        }
    }
    ys
}

/// From the first to the last point, and beyond by a factor.
fn wide(ticks: &[f64], factor: f64) -> Range<f64> {
    let first = ticks.first().copied().unwrap_or(1.0);
    let last = ticks.last().copied().unwrap_or(1.0);
    first / factor..last * factor
}

/// 1, 2, 5, 10 and so on: the largest that is not above the numbers, to the smallest that is not below.
fn ticks_around(numbers: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let min = numbers.clone().fold(f64::INFINITY, f64::min);
    let max = numbers.fold(0.0, f64::max);
    let all: Vec<f64> =
        (-3..9).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10_f64.powi(power))).collect();
    let first = all.iter().rposition(|&tick| tick <= min).unwrap_or(0);
    let last = all.iter().position(|&tick| max <= tick).unwrap_or(all.len() - 1);
    all[first..=last.max(first + 1)].to_vec()
}

/// Seconds where there are some.
fn time(ms: f64) -> String {
    if ms < 999.5 { format!("{} ms", round(ms)) } else { format!("{} s", round(ms / 1e3)) }
}

/// Without what powers of ten leave behind.
fn round(number: f64) -> f64 {
    (number * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::super::sweeps;
    use super::*;

    #[test]
    fn ticks_enclose() {
        let check = |numbers: &[f64], expected: &[f64]| {
            assert_eq!(ticks_around(numbers.iter().copied()), expected, "{numbers:?}");
        };
        check(&[3.0, 40.0], &[2.0, 5.0, 10.0, 20.0, 50.0]);
        check(&[10.0], &[10.0, 20.0]);
    }

    #[test]
    fn apart_at_least_a_line() {
        assert_eq!(apart(&[10, 100]), [10, 100], "far enough");
        let moved = apart(&[50, 52, 54, 200]);
        assert!(moved.windows(2).all(|pair| NAME_HEIGHT <= pair[1] - pair[0]), "{moved:?}");
    }

    #[test]
    fn time_for_people() {
        for (ms, expected) in [(0.5, "0.5 ms"), (200.0, "200 ms"), (1000.0, "1 s"), (2e4, "20 s")] {
            assert_eq!(time(ms), expected);
        }
    }

    /// Every sweep, with one curve that grows and one of a single point.
    #[test]
    fn draw_all_sweeps() {
        let folder = std::env::temp_dir().join(format!("slabsplat-plots-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for sweep in sweeps::all(sweeps::MAX_VOXELS) {
            let points: Vec<Point> =
                sweep.ticks().iter().map(|&x| Point { x, ms: 3.0 * x.sqrt() }).collect();
            let single = Curve { name: "single", points: points[..1].to_vec() };
            let path = folder.join(sweep.file);
            draw(&path, &sweep, &[Curve { name: "growing", points }, single]).unwrap();
            let text = std::fs::read_to_string(path).unwrap();
            assert!(text.contains("</svg>") && text.contains("growing"), "{}", sweep.file);
            assert!(text.contains(sweep.unit) && text.contains(" ms"), "{}", sweep.file);
        }
        std::fs::remove_dir_all(folder).unwrap();
        assert!(
            draw(Path::new("a.svg"), &sweeps::all(sweeps::MAX_VOXELS)[0], &[]).is_err(),
            "nothing to draw"
        );
    }
}
