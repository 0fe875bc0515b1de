//! What the frames took when somebody last looked: `tests/instructions.toml`.

use std::collections::BTreeMap;
use std::env::consts::{ARCH, OS};
use std::process::Command;

use anyhow::Result;
use serde::{Deserialize, Serialize};

use super::super::recorded;
use xtask::process::output;

/// Instructions by the name of the frame.
pub(super) type Counts = BTreeMap<String, u64>;

/// Counts, and what they depend on.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct Record {
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
}

impl recorded::Record for Record {
    const KIND: &'static str = "instructions";
    const SUBJECT: &'static str = "what the frames of tests/tests/instructions.rs take";
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

#[cfg(test)]
mod tests {
    use super::*;
    use recorded::Record as _;

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
        let record = Record::read().unwrap();
        assert!(!record.counts.is_empty() && !record.machine.is_empty(), "{record:?}");
    }
}
