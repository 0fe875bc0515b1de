//! `cargo xtask manual`: man pages and completions of shells, for whoever packs the program.

use anyhow::Result;

use xtask::process::{cargo, run as run_command};
use xtask::workspace;

pub(crate) fn run() -> Result<()> {
    let program = ["run", "--release", "--package", "slabsplat-cli", "--", "manual"];
    run_command(cargo(workspace::root()).args(program).arg("target/manual"))
}
