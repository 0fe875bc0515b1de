//! `cargo xtask test`: the tests of all crates, on a machine that has only Rust.
//!
//! What the tests need beside that is installed here, before they start; a step that finds its work done does nothing.
//! Cargo fetches most of it; the steps beside are [`vulkan`], a driver for the tests of the GPU backends, and valgrind,
//! which counts [`instructions`] once all tests have passed.

use std::ffi::OsString;

use anyhow::Result;

use crate::bench::instructions;
use crate::process::{cargo, run as run_command};
use crate::{vulkan, workspace};

pub(crate) fn run(args: &[OsString]) -> Result<()> {
    vulkan::set_up()?;
    // Whoever asks for some tests does not ask for this one.
    let counts = args.is_empty() && instructions::set_up();
    let mut test = cargo(workspace::root());
    test.arg("test");
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
    fn names_package_before_dashes() {
        check(&[], false);
        check(&["--release", "composite"], false);
        check(&["-p", "xtask"], true);
        check(&["--release", "--package=xtask"], true);
        check(&["--", "-p"], false);
    }
}
