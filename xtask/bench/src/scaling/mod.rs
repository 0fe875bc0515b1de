//! `cargo xtask bench scaling`: how the time of a frame grows with what there is to do.
//!
//! One quantity changes at a time: relevant voxels, pixels, the slab width, threads. Each is a plot in
//! `docs/images/` and a table on stdout, both for `docs/performance.md`. Every point is a run of
//! `slabsplat bench`, the median of its frames; where volumes do not fit into memory their points are left
//! out, in so many words.
//!
//! The pictures are a ball that hides most of itself and the same ball as a haze, and the brain in both ways
//! where its volume is there. [`sweeps`] lists what is measured, [`plot`] draws it.

mod memory;
mod plot;
mod sweeps;

use std::ffi::OsString;

use anyhow::Result;

use super::options::parse_counts;
use super::program::{Program, Run};
use super::table::{markdown, rounded, thousands};
use sweeps::{Picture, Step, Sweep};
use xtask::workspace;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Options {
    n_frames: usize,
    /// The largest number of relevant voxels.
    max_voxels: usize,
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    x: f64,
    ms: f64,
}

/// A picture's times in a sweep.
#[derive(Clone, Debug, PartialEq)]
struct Curve {
    name: &'static str,
    points: Vec<Point>,
}

pub(super) fn parse(args: &[OsString]) -> Result<Options, String> {
    let (mut n_frames, mut max_voxels) = (5, sweeps::MAX_VOXELS as usize);
    parse_counts(args, &mut [("--frames", &mut n_frames), ("--voxels", &mut max_voxels)])?;
    let min = sweeps::MIN_MAX_VOXELS as usize;
    if max_voxels < min {
        return Err(format!("`--voxels` must be {min} at least, or there is no curve"));
    }
    Ok(Options { n_frames, max_voxels })
}

pub(super) fn run(options: &Options) -> Result<()> {
    let program = Program::built()?;
    let pictures = sweeps::pictures();
    let images = workspace::root().join("docs").join("images");
    for sweep in sweeps::all(options.max_voxels as u64) {
        let curves: Vec<Curve> = pictures
            .iter()
            .filter(|picture| sweep.takes(picture))
            .map(|picture| measure(&program, &sweep, picture, options))
            .collect();
        plot::draw(&images.join(sweep.file), &sweep, &curves)?;
        println!("\n## {}\n\n{}", sweep.title, table(&sweep, &curves));
        println!("![{}](images/{})", sweep.title, sweep.file);
    }
    Ok(())
}

/// The curve of a picture, without the points that cannot be measured here.
fn measure(program: &Program, sweep: &Sweep, picture: &Picture, options: &Options) -> Curve {
    let points = sweep.steps.iter().filter_map(|step| {
        let name = format!("{}, {} {}", picture.name, number(step.x), sweep.unit);
        match measure_one(program, sweep, picture, step, options) {
            Ok(point) => {
                eprintln!("bench: {name}: {:.1} ms", point.ms);
                Some(point)
            }
            Err(error) => {
                eprintln!("bench: {name}: not measured: {error:#}");
                None
            }
        }
    });
    Curve { name: picture.name, points: points.collect() }
}

fn measure_one(
    program: &Program,
    sweep: &Sweep,
    picture: &Picture,
    step: &Step,
    options: &Options,
) -> Result<Point> {
    memory::check(step.n_relevant.unwrap_or(0))?;
    let run = Run {
        input: picture.input(step),
        flags: picture.flags.iter().map(ToString::to_string).chain(step.flags.clone()).collect(),
        n_frames: options.n_frames,
        n_threads: step.n_threads,
    };
    let measure = program.bench(&run)?;
    // How many voxels of a ball are relevant depends on its transfer function: only the program knows.
    let x = if sweep.counts_voxels { measure.n_voxels as f64 } else { step.x };
    Ok(Point { x, ms: measure.median_ms })
}

/// A row for each step, a column for each picture.
fn table(sweep: &Sweep, curves: &[Curve]) -> String {
    let names = curves.iter().map(|curve| format!("{}, ms", curve.name));
    let head: Vec<String> = [sweep.unit.to_owned()].into_iter().chain(names).collect();
    let mut xs: Vec<f64> = curves.iter().flat_map(|c| c.points.iter().map(|p| p.x)).collect();
    xs.sort_by(f64::total_cmp);
    xs.dedup();
    let row = |&x: &f64| {
        let ms = |curve: &Curve| {
            let point = curve.points.iter().find(|point| point.x == x);
            point.map_or("–".to_owned(), |point| rounded(point.ms))
        };
        [number(x)].into_iter().chain(curves.iter().map(ms)).collect()
    };
    markdown(&head, &xs.iter().map(row).collect::<Vec<_>>())
}

fn number(x: f64) -> String {
    if x.fract() == 0.0 { thousands(x as u64) } else { format!("{x}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_leaves_gaps() {
        let curve = |name, points: &[(f64, f64)]| {
            let points = points.iter().map(|&(x, ms)| Point { x, ms }).collect();
            Curve { name, points }
        };
        let curves = [curve("a", &[(0.5, 3.0), (1000.0, 4.0)]), curve("b", &[(1000.0, 12.5)])];
        let sweep = &sweeps::all(sweeps::MAX_VOXELS)[0];
        let text = table(sweep, &curves);
        let unit = sweep.unit;
        let head = format!("| {unit} | a, ms | b, ms |\n| --- | --- | --- |\n");
        assert_eq!(text, format!("{head}| 0.5 | 3.00 | – |\n| 1,000 | 4.00 | 12.5 |\n"));
    }
}
