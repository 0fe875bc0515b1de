//! `cargo xtask`: the one entrance to everything that a contributor or a build server runs.
//!
//! ```text
//! cargo xtask lint     cargo xtask test     cargo xtask bench     cargo xtask ci
//! ```
//!
//! Each command is a file of its own name; `cargo xtask` without arguments lists them.
//! The rules about this repository that no compiler knows are [`tidy`] (files) and [`dependencies`] (crates).
//! Both run as tests too, so that a plain `cargo test` finds what they find.
//!
//! Nothing here is part of the renderer, and no crate may depend on it.

mod lint;
mod test;

mod bench;
mod ci;

mod dependencies;
mod tidy;

mod apt;
mod process;
mod vulkan;
mod workspace;

use std::ffi::OsString;
use std::process::ExitCode;

use bench::Bench;
use test::Test;

const USAGE: &str = "\
Usage: cargo xtask COMMAND

  lint                     rustfmt, tidy, dependency rules, clippy and documentation, warnings denied
  test [ARGS]              set up what the tests need, then `cargo test ARGS`, of all packages unless some are named
  test --seeds N [ARGS]    the same with N fresh seeds for each test at random, which are fixed otherwise
  bench [cpu|gpu] [ARGS]   `cargo bench ARGS` on every benchmark, or on those of one processor
  bench peers              frames of slabsplat and of VTK's ray caster by turns, and their ratios
                           [--frames N] frames a run, [--pairs N] runs of each
  bench scaling            time against voxels, pixels, slab width and threads: tables, and plots in docs/images
                           [--frames N] frames a point, [--voxels N] the largest number of relevant voxels
  bench instructions       count what small frames take and compare it with what is recorded, as `test` does
                           [--record] instead of comparing
  ci                       lint, test, and each crate and each feature of it built alone
  help                     print this

A filter for the benchmarks, or another option of theirs, follows `--`:
  cargo xtask bench cpu -- toss --save-baseline before

Tests that need a GPU, or a driver that does without one, are skipped where there is none;
with SLABSPLAT_REQUIRE_GPU in the environment they fail.
";

fn main() -> ExitCode {
    let task = match parse(std::env::args_os().skip(1)) {
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

/// A command with the arguments that it passes on.
#[derive(Debug, PartialEq)]
enum Task {
    Lint,
    Test(Test),
    Bench(Bench),
    Ci,
    Help,
}

fn run(task: &Task) -> anyhow::Result<()> {
    match task {
        Task::Lint => lint::run(),
        Task::Test(test) => test::run(test),
        Task::Bench(bench) => bench::run(bench),
        Task::Ci => ci::run(),
        Task::Help => {
            print!("{USAGE}");
            Ok(())
        }
    }
}

fn parse(mut args: impl Iterator<Item = OsString>) -> Result<Task, String> {
    let command = args.next().ok_or("a command is missing")?;
    let rest: Vec<OsString> = args.collect();
    let task = match command.to_str() {
        Some("test") => return test::parse(rest).map(Task::Test),
        Some("bench") => return bench::parse(rest).map(Task::Bench),
        Some("lint") => Task::Lint,
        Some("ci") => Task::Ci,
        Some("help" | "--help" | "-h") => Task::Help,
        _ => return Err(format!("there is no command `{}`", command.display())),
    };
    match rest.first() {
        None => Ok(task),
        Some(arg) => {
            Err(format!("`{}` takes no arguments, found `{}`", command.display(), arg.display()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(args: &[&str], expected: Result<Task, &str>) {
        let task = parse(args.iter().map(OsString::from));
        assert_eq!(task, expected.map_err(String::from), "arguments {args:?}");
    }

    #[test]
    fn parse_commands() {
        check(&["lint"], Ok(Task::Lint));
        check(&["ci"], Ok(Task::Ci));
        check(&["--help"], Ok(Task::Help));
        let cpu = Bench::Criterion(bench::Processor::Cpu, vec!["--".into(), "toss".into()]);
        check(&["bench", "cpu", "--", "toss"], Ok(Task::Bench(cpu)));
        check(&["test"], Ok(Task::Test(Test::default())));
    }

    #[test]
    fn parse_wrong_arguments() {
        check(&[], Err("a command is missing"));
        check(&["lnt"], Err("there is no command `lnt`"));
        check(&["lint", "--fix"], Err("`lint` takes no arguments, found `--fix`"));
    }
}
