//! `cargo xtask scalar`: the loops of computers without vectors, which this one may have, against its own.
//!
//! They take three times as long to compile as all else of slabsplat-cpu, so that no other build has them.

use anyhow::Result;

use xtask::process::{cargo, run as run_command};
use xtask::workspace::{self, Workspace};

pub(crate) fn run() -> Result<()> {
    let folder = Workspace::read()?.target_directory.join("scalar");
    let mut test = cargo(workspace::root());
    test.args(["test", "--package", "slabsplat-cpu", "--lib", "--target-dir"]).arg(folder);
    // Nobody debugs it.
    test.env("RUSTFLAGS", "--cfg slabsplat_scalar").env("CARGO_PROFILE_DEV_DEBUG", "0");
    run_command(&mut test)
}
