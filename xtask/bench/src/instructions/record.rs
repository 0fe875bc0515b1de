//! What the frames took when somebody last looked: `tests/instructions.toml`.

use std::collections::BTreeMap;
use std::env::consts::{ARCH, OS};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use xtask::process::output;

/// Instructions by the name of the frame.
pub(super) type Counts = BTreeMap<String, u64>;

const HEADER: &str = "# Written by `cargo xtask bench instructions --record`: what the frames of \
    tests/tests/instructions.rs take.\n";

/// Counts, and what they depend on.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(super) struct Record {
    /// Counts on another have nothing to do with these.
    pub(super) machine: String,
    pub(super) rustc: String,
    pub(super) counts: Counts,
}

impl Record {
    /// The counts, of this machine and compiler.
    pub(super) fn now(counts: Counts) -> Result<Self> {
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let rustc = output(Command::new(rustc).arg("--version"))?.trim().to_owned();
        Ok(Self { machine: machine(), rustc, counts })
    }

    fn text(&self) -> Result<String> {
        Ok(HEADER.to_owned() + &toml::to_string(self)?)
    }
}

/// As much of a machine as makes programs take other paths. valgrind hides what is newer than AVX2.
pub(super) fn machine() -> String {
    format!("{OS} on {ARCH}{}", if has_avx2() { " with AVX2" } else { "" })
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}

pub(super) fn read(root: &Path) -> Result<Record> {
    let path = path(root);
    let text =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    toml::from_str(&text).with_context(|| path.display().to_string())
}

pub(super) fn write(root: &Path, record: &Record) -> Result<()> {
    let path = path(root);
    let text = record.text()?;
    fs::write(&path, &text).with_context(|| format!("cannot write {}", path.display()))?;
    println!("{text}");
    Ok(())
}

fn path(root: &Path) -> PathBuf {
    root.join("tests").join("instructions.toml")
}

#[cfg(test)]
mod tests {
    use super::*;
    use xtask::workspace;

    #[test]
    fn record_there_and_back() {
        let counts = [("haze", 1_234_567), ("section-table", 0)];
        let record = Record {
            machine: "linux on x86_64".to_owned(),
            rustc: "rustc 1.95.0 (abc 2026-01-01)".to_owned(),
            counts: counts.map(|(name, count)| (name.to_owned(), count)).into(),
        };
        assert_eq!(toml::from_str::<Record>(&record.text().unwrap()).unwrap(), record);
    }

    #[test]
    fn record_of_this_repository() {
        let record = read(workspace::root()).unwrap();
        assert!(!record.counts.is_empty() && !record.machine.is_empty(), "{record:?}");
        let text = fs::read_to_string(path(workspace::root())).unwrap();
        assert_eq!(record.text().unwrap(), text, "writing it again changes nothing");
    }
}
