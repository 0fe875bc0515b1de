//! Counts that are the same from run to run, and what they were when somebody last looked: a file of
//! `tests/`. A guard compares both; more than was recorded, by more than [`TOLERANCE`], is a failure.

use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

use xtask::workspace;

/// What is to be done with counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Task {
    Compare,
    Record,
}

/// Growth from which a guard speaks: a few instructions a splat, which a stopwatch would not see.
const TOLERANCE: f64 = 0.05;

/// Counts, and what they depend on.
pub(super) trait Record: Serialize + DeserializeOwned {
    /// The guard, as `bench` takes it. Its file in `tests/` has the same name.
    const KIND: &'static str;
    /// What is counted, for readers of the file.
    const SUBJECT: &'static str;

    /// What is recorded.
    fn read() -> Result<Self> {
        let path = path(Self::KIND);
        let text =
            fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        toml::from_str(&text).with_context(|| path.display().to_string())
    }

    /// Records this instead, and prints it.
    fn write(&self) -> Result<()> {
        let path = path(Self::KIND);
        let text = self.text()?;
        fs::write(&path, &text).with_context(|| format!("cannot write {}", path.display()))?;
        println!("{text}");
        Ok(())
    }

    fn text(&self) -> Result<String> {
        let (kind, subject) = (Self::KIND, Self::SUBJECT);
        let header = format!("# Written by `cargo xtask bench {kind} --record`: {subject}.\n");
        Ok(header + &toml::to_string(self)?)
    }
}

fn path(kind: &str) -> PathBuf {
    workspace::root().join("tests").join(kind).with_extension("toml")
}

/// What follows the name of a guard.
pub(super) fn parse<R: Record>(args: &[OsString]) -> Result<Task, String> {
    match args {
        [] => Ok(Task::Compare),
        [flag] if flag == "--record" => Ok(Task::Record),
        [other, ..] => {
            Err(format!("`bench {}` takes only --record, found `{}`", R::KIND, other.display()))
        }
    }
}

pub(super) fn has_grown(was: u64, now: u64) -> bool {
    (1.0 + TOLERANCE) * (was as f64) < now as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{instructions, shaders};

    #[test]
    fn growth_of_more_than_five_percent() {
        assert!(!has_grown(40, 42));
        assert!(has_grown(40, 43));
        assert!(has_grown(0, 1));
        assert!(!has_grown(40, 1));
    }

    fn check_file<R: Record>() {
        let written = fs::read_to_string(path(R::KIND)).unwrap();
        let text = R::read().unwrap().text().unwrap();
        assert_eq!(text, written, "writing it again changes nothing");
    }

    #[test]
    fn records_of_this_repository() {
        check_file::<instructions::Record>();
        check_file::<shaders::Record>();
    }
}
