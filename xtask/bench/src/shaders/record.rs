//! What the shaders took when somebody last looked: `tests/shaders.toml`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

const HEADER: &str = "# Written by `cargo xtask bench shaders --record`: what a driver's compiler \
    makes of shaders/.\n";

/// Counts, and who compiled.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(super) struct Record {
    /// The GPU, the driver and its version. Counts of another have nothing to do with these.
    pub(super) device: String,
    pub(super) shaders: BTreeMap<String, Counts>,
}

/// What the compiler made of a shader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(super) struct Counts {
    /// Instructions of the longest innermost loop that reads workgroup memory.
    pub(super) innermost_loop: u64,
    pub(super) instructions: u64,
    /// Vector registers of a thread.
    pub(super) registers: u64,
    pub(super) workgroup_bytes: u64,
    /// That a SIMD unit holds at a time, as far as registers allow.
    pub(super) subgroups: u64,
}

pub(super) fn read(root: &Path) -> Result<Record> {
    let path = path(root);
    let text =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    toml::from_str(&text).with_context(|| path.display().to_string())
}

pub(super) fn write(root: &Path, record: &Record) -> Result<()> {
    let path = path(root);
    let text = text(record)?;
    fs::write(&path, &text).with_context(|| format!("cannot write {}", path.display()))?;
    println!("{text}");
    Ok(())
}

fn text(record: &Record) -> Result<String> {
    Ok(HEADER.to_owned() + &toml::to_string(record)?)
}

fn path(root: &Path) -> PathBuf {
    root.join("tests").join("shaders.toml")
}

#[cfg(test)]
mod tests {
    use super::*;
    use xtask::workspace;

    #[test]
    fn record_of_this_repository() {
        let record = read(workspace::root()).unwrap();
        assert!(!record.shaders.is_empty(), "{record:?}");
        let written = fs::read_to_string(path(workspace::root())).unwrap();
        assert_eq!(text(&record).unwrap(), written, "writing it again changes nothing");
    }
}
