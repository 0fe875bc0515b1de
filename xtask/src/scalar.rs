//! `cargo xtask scalar`: the loops of computers without vectors, which this one may have, against its own.
//!
//! Optimised they take three times as long to compile as all else of slabsplat-cpu, so that no other build
//! has them. Here they are not: floats are the same then, and only tests that compare sets of instructions
//! run.

use anyhow::{Result, ensure};

use xtask::process::{cargo, output, run as run_command};
use xtask::workspace::{self, Workspace};

/// What such tests have in their names.
const TESTS: &str = "level";

pub(crate) fn run() -> Result<()> {
    let folder = Workspace::read()?.target_directory.join("scalar");
    let tests = || {
        let mut test = cargo(workspace::root());
        test.args(["test", "--package", "slabsplat-cpu", "--lib", "--target-dir"]).arg(&folder);
        test.args(["--config", "profile.dev.package.slabsplat-cpu.opt-level=0", TESTS]);
        // Nobody debugs it.
        test.env("RUSTFLAGS", "--cfg slabsplat_scalar").env("CARGO_PROFILE_DEV_DEBUG", "0");
        // Frames of functions hold all their variables.
        test.env("RUST_MIN_STACK", (64 << 20).to_string());
        test
    };
    run_command(&mut tests())?;
    let list = output(tests().args(["--", "--list"]))?;
    ensure!(list.contains(": test"), "no test of slabsplat-cpu has `{TESTS}` in its name");
    Ok(())
}
