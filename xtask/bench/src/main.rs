//! `cargo xtask bench`: everything that measures time or work, and the volumes to measure with.
//!
//! [`criterion`] runs the benchmarks that crates have, [`peers`] compares whole frames with another
//! renderer, [`scaling`] shows how time grows, [`viewer`] how fast pages of a browser follow a mouse,
//! [`instructions`] and [`shaders`] guard against growth unnoticed, and [`data`] fetches a volume, of which
//! [`large`] makes one of 10⁹ voxels. Only instructions are judged: times are printed with what they were
//! measured on, and never asserted.
//!
//! A program of its own, which `xtask` starts, so that `cargo xtask lint` and `test` need not build it.

mod criterion;
mod data;
mod instructions;
mod large;
mod options;
mod peers;
mod program;
mod python;
mod recorded;
mod scaling;
mod shaders;
mod table;
mod viewer;

use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::Result;

use criterion::Processor;

const USAGE: &str = "\
Usage: cargo xtask bench [KIND] [ARGS]

  [cpu|gpu] [ARGS]   `cargo bench ARGS` on every benchmark, or on those of one processor
  peers              frames of slabsplat and of VTK's ray caster alternately, and their ratios
                     [--frames N] frames a run, [--pairs N] runs of each, [--side N] pixels, if not 512
  scaling            time against voxels, pixels, slab width and threads: tables, and plots in docs/images
                     [--frames N] frames a point, [--voxels N] the largest number of relevant voxels
  viewer             how soon the viewer's page shows a volume, and how fast it follows a mouse, alone and as
                     `slabsplat serve` shows it; `cargo xtask web` builds the page
                     [--seconds N] for which it is turned, [--width N] and [--height N] of the page in pixels
  instructions       count what small frames take and compare it with what is recorded, as `test` does
                     [--record] instead of comparing
  shaders            instructions, registers and loops of the shaders by Mesa's compiler for AMD, which needs no
                     GPU, compared with what is recorded, as `test` does
                     [--record] instead of comparing
  data               fetch the brain that peers, scaling and some tests show, from PyPI into tests/data
                     [--large] make one of 10⁹ voxels of it, for peers
  help               print this

A filter for the benchmarks, or another option of theirs, follows `--`:
  cargo xtask bench cpu -- toss --save-baseline before
";

fn main() -> ExitCode {
    let task = match parse(std::env::args_os().skip(1).collect()) {
        Ok(task) => task,
        Err(message) => {
            eprint!("error: {message}\n\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    match run(&task) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

#[derive(Debug, PartialEq)]
enum Task {
    /// With the arguments that cargo and criterion take.
    Criterion(Processor, Vec<OsString>),
    Peers(peers::Options),
    Scaling(scaling::Options),
    Viewer(viewer::Options),
    Instructions(recorded::Task),
    Shaders(recorded::Task),
    Data,
    LargeData,
    Help,
}

fn run(task: &Task) -> Result<()> {
    match task {
        Task::Criterion(processor, args) => criterion::run(*processor, args),
        Task::Peers(options) => peers::run(options),
        Task::Scaling(options) => scaling::run(options),
        Task::Viewer(options) => viewer::run(options),
        Task::Instructions(task) => instructions::run(*task),
        Task::Shaders(task) => shaders::run(*task),
        Task::Data => data::fetch().map(|_| ()),
        Task::LargeData => large::make(),
        Task::Help => {
            print!("{USAGE}");
            Ok(())
        }
    }
}

/// The first word, if it is a kind of benchmark; a filter of that name stands after `--`.
fn parse(mut args: Vec<OsString>) -> Result<Task, String> {
    let kind = args.first().and_then(|arg| arg.to_str()).unwrap_or_default().to_owned();
    let mut rest = || args.split_off(1);
    Ok(match kind.as_str() {
        "cpu" => Task::Criterion(Processor::Cpu, rest()),
        "gpu" => Task::Criterion(Processor::Gpu, rest()),
        "peers" => Task::Peers(peers::parse(&rest())?),
        "scaling" => Task::Scaling(scaling::parse(&rest())?),
        "viewer" => Task::Viewer(viewer::parse(&rest())?),
        "instructions" => Task::Instructions(recorded::parse::<instructions::Record>(&rest())?),
        "shaders" => Task::Shaders(recorded::parse::<shaders::Record>(&rest())?),
        "data" => match rest().as_slice() {
            [] => Task::Data,
            [flag] if flag == "--large" => Task::LargeData,
            _ => return Err("`data` takes only --large".to_owned()),
        },
        "help" | "--help" | "-h" => Task::Help,
        _ => Task::Criterion(Processor::Any, args),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(args: &[&str]) -> Result<Task, String> {
        parse(args.iter().map(OsString::from).collect())
    }

    #[test]
    fn parse_processors() {
        let check = |args: &[&str], processor: Processor, rest: &[&str]| {
            let rest = rest.iter().map(OsString::from).collect();
            assert_eq!(parsed(args), Ok(Task::Criterion(processor, rest)), "arguments {args:?}");
        };
        check(&[], Processor::Any, &[]);
        check(&["--", "toss"], Processor::Any, &["--", "toss"]);
        check(&["cpu"], Processor::Cpu, &[]);
        check(&["gpu", "--", "sort"], Processor::Gpu, &["--", "sort"]);
        check(&["--", "gpu"], Processor::Any, &["--", "gpu"]);
    }

    #[test]
    fn parse_options() {
        let options = peers::Options { n_frames: 3, n_pairs: 7, side: None };
        assert_eq!(parsed(&["peers", "--frames", "3", "--pairs", "7"]), Ok(Task::Peers(options)));
        let options = peers::Options { n_frames: 12, n_pairs: 5, side: Some(128) };
        assert_eq!(parsed(&["peers", "--side", "128"]), Ok(Task::Peers(options)));
        assert_eq!(parsed(&["data", "--large"]), Ok(Task::LargeData));
        let record = Task::Instructions(recorded::Task::Record);
        assert_eq!(parsed(&["instructions", "--record"]), Ok(record));
        assert_eq!(parsed(&["shaders"]), Ok(Task::Shaders(recorded::Task::Compare)));
        let options = viewer::Options { seconds: 3, size: [1280, 800] };
        assert_eq!(parsed(&["viewer", "--seconds", "3"]), Ok(Task::Viewer(options)));
        assert_eq!(parsed(&["data"]), Ok(Task::Data));
        assert_eq!(parsed(&["--help"]), Ok(Task::Help));
        let wrong = [
            ["peers", "--frame"],
            ["scaling", "voxel"],
            ["instructions", "--recrod"],
            ["shaders", "splat"],
            ["data", "brain"],
        ];
        for wrong in wrong {
            assert!(parsed(&wrong).is_err(), "{wrong:?}");
        }
    }
}
