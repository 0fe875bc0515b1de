//! `cargo xtask semver`: whether what is published still fits its version number, compared with the last
//! release, the latest tag `v…`.
//!
//! The tool is cargo-semver-checks, which must be installed; otherwise, or as long as there is no release, a
//! line says so.

use std::process::Command;

use anyhow::Result;

use xtask::process::{cargo, has_subcommand, output, run as run_command};
use xtask::workspace::{self, Workspace};

pub(crate) fn run() -> Result<()> {
    let Some(release) = last_release() else {
        eprintln!("semver: skipped, as nothing is released yet: there is no tag `v…`");
        return Ok(());
    };
    if !has_subcommand("semver-checks") {
        let hint = "`cargo install --locked cargo-semver-checks`";
        eprintln!("semver: skipped, as cargo-semver-checks is not here: {hint}");
        return Ok(());
    }
    let workspace = Workspace::read()?;
    let mut semver = cargo(workspace::root());
    semver.args(["semver-checks", "--all-features", "--baseline-rev", &release]);
    // What is a program has no interface.
    let libraries = workspace.published().filter(|package| package.has_library());
    run_command(semver.args(libraries.flat_map(|package| ["--package", &package.name])))
}

/// The latest tag of a release that this commit comes after.
fn last_release() -> Option<String> {
    let mut git = Command::new("git");
    git.current_dir(workspace::root());
    let tag = output(git.args(["describe", "--tags", "--abbrev=0", "--match", "v[0-9]*"])).ok()?;
    Some(tag.trim().to_owned())
}
