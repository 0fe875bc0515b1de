//! Counting by valgrind's callgrind, which counts in one function only.
//!
//! valgrind is called here rather than by iai-callgrind or its like: those want a runner of just their
//! version to be installed, and what they do more than this, caches and baselines, nothing here asks for.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::record::Counts;
use xtask::process::output;
use xtask::test_build;
use xtask::workspace::Workspace;

/// The test target that renders, and the function in it that is counted.
const TARGET: &str = "instructions";
const COUNTED: &str = "counted_frame";

fn ensure_installed() -> Result<()> {
    let lack = "valgrind is missing: `cargo xtask test --install` installs it";
    output(Command::new("valgrind").arg("--version")).map(drop).context(lack)
}

/// What each of the frames takes.
pub(super) fn count(root: &Path) -> Result<Counts> {
    ensure_installed()?;
    let program = test_build::test(root, TARGET)?;
    let names = output(Command::new(&program).arg("--workloads"))?;
    let profiles = profiles()?;
    std::fs::create_dir_all(&profiles)
        .with_context(|| format!("cannot make {}", profiles.display()))?;
    let count = |name: &str| count_one(&program, name, &profiles.join(name));
    names.lines().map(|name| Ok((name.to_owned(), count(name)?))).collect()
}

/// Where callgrind leaves what it found, a file a frame, for whoever wants to know more.
pub(super) fn profiles() -> Result<PathBuf> {
    Ok(Workspace::read()?.target_directory.join("callgrind"))
}

fn count_one(program: &Path, name: &str, profile: &Path) -> Result<u64> {
    let mut out_file = OsString::from("--callgrind-out-file=");
    out_file.push(profile);
    let valgrind = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg(format!("--toggle-collect=*{COUNTED}*"))
        .arg(out_file)
        .arg(program)
        .args(["--count", name])
        .output()
        .context("cannot start valgrind")?;
    let stderr = String::from_utf8_lossy(&valgrind.stderr);
    ensure!(valgrind.status.success(), "valgrind failed on {name}: {}", stderr.trim());
    let count = collected(&stderr).with_context(|| format!("valgrind counts nothing: {stderr}"))?;
    // The function is not called that any more, or was inlined.
    ensure!(0 < count, "valgrind does not find `{COUNTED}` in {}", program.display());
    Ok(count)
}

/// The number in `==123== Collected : 4567`.
fn collected(stderr: &str) -> Option<u64> {
    let line = stderr.lines().find_map(|line| line.split_once("Collected :"));
    line?.1.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn collected_among_other_lines() {
        let stderr = "==7== Events    : Ir\n==7== Collected : 4567\n==7== \n";
        assert_eq!(collected(stderr), Some(4567));
        assert_eq!(collected("==7== nothing"), None);
    }
}
