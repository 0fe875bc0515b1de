//! `cargo xtask bench`: starts `slabsplat-bench`, which does the measuring.

use anyhow::Result;
use std::ffi::OsStr;

use xtask::process::{cargo, run as run_command};
use xtask::workspace;

pub(crate) fn run(args: &[impl AsRef<OsStr>]) -> Result<()> {
    let run = ["run", "--quiet", "--package", "slabsplat-bench", "--"];
    run_command(cargo(workspace::root()).args(run).args(args))
}
