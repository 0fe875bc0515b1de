//! `cargo xtask semver [REVISION]`: whether what is published still fits its version number, compared with
//! the last release, the latest tag `v…`, or with any revision of git's.
//!
//! The tool is cargo-semver-checks, which must be installed; otherwise a line says so. As long as nothing is
//! released there is nothing to compare with unless a revision is named, as `main` before a merge. What
//! breaks is then a failure, and a line of the changelog.

use std::ffi::OsString;
use std::process::Command;

use anyhow::{Context, Result};

use xtask::process::{cargo, has_subcommand, output, run as run_command};
use xtask::workspace::{self, Workspace};

/// The revision that the arguments name, if they do.
pub(crate) fn parse(args: &[OsString]) -> Result<Option<String>, String> {
    match args {
        [] => Ok(None),
        [revision] if !revision.to_string_lossy().starts_with('-') => {
            Ok(Some(revision.to_string_lossy().into_owned()))
        }
        _ => Err("`semver` takes a revision of git's, or nothing".to_owned()),
    }
}

/// With a revision that is named, the want of one is a failure.
pub(crate) fn run(revision: Option<&str>) -> Result<()> {
    let baseline = match revision {
        Some(revision) => Some(commit_of(revision)?),
        None => last_release(),
    };
    let Some(baseline) = baseline else {
        eprintln!(
            "semver: skipped, as nothing is released yet: there is no tag `v…`; \
             `cargo xtask semver REVISION` compares with a commit"
        );
        return Ok(());
    };
    if !has_subcommand("semver-checks") {
        let hint = "`cargo install --locked cargo-semver-checks`";
        eprintln!("semver: skipped, as cargo-semver-checks is not here: {hint}");
        return Ok(());
    }
    let workspace = Workspace::read()?;
    let mut semver = cargo(workspace::root());
    semver.args(["semver-checks", "--all-features", "--baseline-rev", &baseline]);
    // What is a program has no interface.
    let libraries = workspace.published().filter(|package| package.has_library());
    run_command(semver.args(libraries.flat_map(|package| ["--package", &package.name])))
}

/// The commit that a revision is, which cargo-semver-checks finds in the repository.
fn commit_of(revision: &str) -> Result<String> {
    let mut git = Command::new("git");
    git.current_dir(workspace::root()).args([
        "rev-parse",
        "--verify",
        "--quiet",
        "--end-of-options",
    ]);
    let commit = output(git.arg(format!("{revision}^{{commit}}")));
    Ok(commit.with_context(|| format!("git knows no commit `{revision}`"))?.trim().to_owned())
}

/// The latest tag of a release that this commit comes after.
fn last_release() -> Option<String> {
    let mut git = Command::new("git");
    git.current_dir(workspace::root());
    let tag = output(git.args(["describe", "--tags", "--abbrev=0", "--match", "v[0-9]*"])).ok()?;
    Some(tag.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parse_takes_one_revision() {
        let parse =
            |args: &[&str]| parse(&args.iter().map(|arg| OsString::from(*arg)).collect::<Vec<_>>());
        assert_eq!((parse(&[]), parse(&["main"])), (Ok(None), Ok(Some("main".to_owned()))));
        for bad in [&["--fix"][..], &["a", "b"]] {
            assert!(parse(bad).unwrap_err().contains("takes a revision"), "{bad:?}");
        }
    }

    #[test]
    fn commit_of_a_revision() {
        let error = commit_of("--no-such-revision").unwrap_err().to_string();
        assert_eq!(error, "git knows no commit `--no-such-revision`");
        // A package has no repository.
        if let Ok(commit) = commit_of("HEAD") {
            assert!(commit.chars().all(|c| c.is_ascii_hexdigit()), "{commit}");
        }
    }
}
