//! `cargo xtask test`: the tests of all crates, on a machine that has only Rust.
//!
//! What the tests need beside that is installed here, before they start; a step that finds its work done does nothing.
//! Cargo fetches most of it; the steps beside are [`vulkan`], a driver for the tests of the GPU backends, and valgrind,
//! which counts [`instructions`] once all tests have passed.
//!
//! Tests at random have fixed seeds. `--seeds` gives them others, as many as one has time for: [`Seeds`].

use std::ffi::OsString;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Result;

use crate::bench::instructions;
use crate::process::{cargo, run as run_command};
use crate::{vulkan, workspace};

/// What is to be tested.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Test {
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

pub(crate) fn parse(args: Vec<OsString>) -> Result<Test, String> {
    let [flag, n, rest @ ..] = args.as_slice() else {
        return match args.first() {
            Some(flag) if flag == "--seeds" => Err("`--seeds` takes a number".to_owned()),
            _ => Ok(Test { seeds: None, args }),
        };
    };
    if flag != "--seeds" {
        return Ok(Test { seeds: None, args });
    }
    match n.to_str().and_then(|n| n.parse().ok()) {
        Some(n @ 1..=1_000_000) => Ok(Test { seeds: Some(Seeds::fresh(n)), args: rest.to_vec() }),
        _ => Err(format!("`--seeds` takes a number from 1 to 1000000, not `{}`", n.display())),
    }
}

pub(crate) fn run(Test { seeds, args }: &Test) -> Result<()> {
    vulkan::set_up()?;
    // Whoever asks for some tests, or for other seeds, does not ask for this one.
    let counts = args.is_empty() && seeds.is_none() && instructions::set_up();
    let mut test = cargo(workspace::root());
    // One failure must not hide the next.
    test.args(["test", "--no-fail-fast"]);
    if let Some(seeds) = seeds {
        eprintln!("test: {}={seeds}", Seeds::VARIABLE);
        test.env(Seeds::VARIABLE, seeds.to_string());
    }
    if counts {
        // The same build serves both.
        let (variable, value) = instructions::REPEATABLE;
        test.env(variable, value);
    }
    // Cargo takes both without complaint, and then tests all packages.
    if !names_package(args) {
        test.arg("--workspace");
    }
    run_command(test.args(args))?;
    if counts { instructions::compare() } else { Ok(()) }
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
    fn parse_seeds() {
        let parse = |args: &[&str]| parse(args.iter().map(OsString::from).collect());
        assert_eq!(parse(&[]), Ok(Test::default()));
        let args = || ["-p", "xtask"].map(OsString::from).to_vec();
        assert_eq!(parse(&["-p", "xtask"]), Ok(Test { seeds: None, args: args() }));
        let test = parse(&["--seeds", "200", "-p", "xtask"]).unwrap();
        assert_eq!((test.seeds.map(|seeds| seeds.n), test.args), (Some(200), args()));
        for bad in [&["--seeds"][..], &["--seeds", "many"], &["--seeds", "0"]] {
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
