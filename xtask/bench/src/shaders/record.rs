//! What the shaders took when somebody last looked: `tests/shaders.toml`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::super::recorded;

/// Counts, and who compiled.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct Record {
    /// The GPU, the driver and its version. Counts of another have nothing to do with these.
    pub(super) device: String,
    pub(super) shaders: BTreeMap<String, Counts>,
}

/// What the compiler made of a shader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct Counts {
    /// Instructions of the longest innermost loop that reads workgroup memory.
    pub(super) innermost_loop: u64,
    pub(super) instructions: u64,
    /// Vector registers of a thread.
    pub(super) registers: u64,
    pub(super) workgroup_bytes: u64,
    /// That a SIMD unit holds at a time, as far as registers allow.
    pub(super) subgroups: u64,
}

impl recorded::Record for Record {
    const KIND: &'static str = "shaders";
    const SUBJECT: &'static str = "what a driver's compiler makes of shaders/";
}

#[cfg(test)]
mod tests {
    use super::*;
    use recorded::Record as _;

    #[test]
    fn record_of_this_repository() {
        let record = Record::read().unwrap();
        assert!(!record.shaders.is_empty(), "{record:?}");
    }
}
