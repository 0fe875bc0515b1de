//! `cargo xtask test`: the tests of all crates, on a machine that has only Rust.
//!
//! Cargo fetches what all of them need. Some need system packages beside, a Vulkan driver, MPI and valgrind:
//! [`system`] says what is missing, and installs it if `--install` says so. Once all tests have passed,
//! instructions are counted, those of shaders too.
//!
//! Tests at random have fixed seeds. `--seeds` gives them others, as many as one has time for: [`Seeds`].

use std::ffi::OsString;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Result;
use xtask::process::{REPEATABLE, cargo, run as run_command};
use xtask::test_build::all_packages;
use xtask::workspace;

use crate::{bench, system};

/// What is to be tested.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Test {
    /// Whether system packages that are missing are to be installed.
    installs: bool,
    seeds: Option<Seeds>,
    /// For cargo.
    args: Vec<OsString>,
}

/// The seeds of tests at random, as `crates/slabsplat-seeds` reads them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seeds {
    first: u64,
    n: u64,
}

impl Seeds {
    const VARIABLE: &str = "SLABSPLAT_SEEDS";

    /// As many as the text says.
    fn parse(n: &str) -> Option<Self> {
        n.parse().ok().filter(|n| (1..=1_000_000).contains(n)).map(Self::fresh)
    }

    /// As many as that, which nobody has tried yet: they are counted on from the seconds that it is.
    fn fresh(n: u64) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        Self { first: now.map_or(0, |time| time.as_secs()), n }
    }
}

impl std::fmt::Display for Seeds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}..{}", self.first, self.first + self.n)
    }
}

/// Our own flags come first; what follows them is for cargo.
pub(crate) fn parse(args: &[OsString]) -> Result<Test, String> {
    match args {
        [flag, rest @ ..] if flag == "--install" => Ok(Test { installs: true, ..parse(rest)? }),
        [flag, n, rest @ ..] if flag == "--seeds" => {
            let seeds = n.to_str().and_then(Seeds::parse).ok_or_else(|| {
                format!("`--seeds` takes a number from 1 to 1000000, not `{}`", n.display())
            })?;
            Ok(Test { seeds: Some(seeds), ..parse(rest)? })
        }
        [flag] if flag == "--seeds" => Err("`--seeds` takes a number".to_owned()),
        _ => Ok(Test { args: args.to_vec(), ..Test::default() }),
    }
}

pub(crate) fn run(Test { installs, seeds, args }: &Test) -> Result<()> {
    system::set_up("test", system::TESTS, *installs);
    // Whoever asks for some tests, or for other seeds, does not ask for this one.
    let counts = args.is_empty() && seeds.is_none() && system::has_valgrind();
    let mut test = cargo(workspace::root());
    // One failure must not hide the next.
    test.args(["test", "--no-fail-fast"]);
    if let Some(seeds) = seeds {
        eprintln!("test: {}={seeds}", Seeds::VARIABLE);
        test.env(Seeds::VARIABLE, seeds.to_string());
    }
    if counts {
        // The same build serves both.
        let (variable, value) = REPEATABLE;
        test.env(variable, value);
    }
    // Cargo takes both without an error, and then tests all packages.
    if !names_package(args) {
        test.args(all_packages());
    }
    run_command(test.args(args))?;
    if counts {
        bench::run(&["instructions"])?;
        bench::run(&["shaders"])?;
    }
    Ok(())
}

/// Whether the caller wants some packages only; what follows `--` is for the tests, not for cargo.
fn names_package(args: &[OsString]) -> bool {
    let mut cargo_args = args.iter().filter_map(|arg| arg.to_str()).take_while(|arg| *arg != "--");
    cargo_args.any(|arg| arg.starts_with("-p") || arg.starts_with("--package"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(args: &[&str], expected: bool) {
        let os_args: Vec<OsString> = args.iter().map(OsString::from).collect();
        assert_eq!(names_package(&os_args), expected, "arguments {args:?}");
    }

    #[test]
    fn parse_flags_before_arguments() {
        let parse =
            |args: &str| parse(&args.split_whitespace().map(OsString::from).collect::<Vec<_>>());
        let check = |args: &str, installs: bool, n_seeds: Option<u64>, rest: &str| {
            let test = parse(args).unwrap();
            assert_eq!(test.installs, installs, "{args}");
            assert_eq!(test.seeds.map(|seeds| seeds.n), n_seeds, "{args}");
            assert!(
                test.args.iter().map(OsString::as_os_str).eq(rest.split_whitespace()),
                "{args}"
            );
        };
        check("", false, None, "");
        check("-p xtask", false, None, "-p xtask");
        check("--install -p xtask", true, None, "-p xtask");
        check("--seeds 200 -p xtask", false, Some(200), "-p xtask");
        check("--seeds 7 --install", true, Some(7), "");
        check("-p xtask --install", false, None, "-p xtask --install");
        for bad in ["--seeds", "--seeds many", "--seeds 0", "--install --seeds 2000000"] {
            let error = parse(bad).unwrap_err();
            assert!(error.starts_with("`--seeds` takes a number"), "{error}");
        }
        assert_eq!(Seeds { first: 7, n: 3 }.to_string(), "7..10");
    }

    #[test]
    fn names_package_before_dashes() {
        check(&[], false);
        check(&["--release", "composite"], false);
        check(&["-p", "xtask"], true);
        check(&["--release", "--package=xtask"], true);
        check(&["--", "-p"], false);
    }
}
