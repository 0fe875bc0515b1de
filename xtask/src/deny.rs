//! `cargo xtask deny`: whether everything that is depended on has a licence that we may pass on, comes from
//! the registry, and has no known fault, by `xtask/deny.toml`.
//!
//! The tool is cargo-deny, which must be installed; otherwise a line says so.
//! Licences and sources are a matter of `Cargo.lock`, and checked each time. Which faults are known is a
//! matter of the day, and of a list in the network: `cargo xtask deny advisories` asks for them.

use std::ffi::OsString;

use anyhow::Result;

use xtask::process::{cargo, has_subcommand, run as run_command};
use xtask::workspace;

const OFFLINE: &[&str] = &["bans", "licenses", "sources"];

/// The given checks, or all that need no network.
pub(crate) fn run(checks: &[OsString]) -> Result<()> {
    if !has_subcommand("deny") {
        eprintln!("deny: skipped, as cargo-deny is not here: `cargo install --locked cargo-deny`");
        return Ok(());
    }
    let mut deny = cargo(workspace::root());
    deny.args(["deny", "--all-features", "--config", "xtask/deny.toml", "check"]);
    if checks.is_empty() {
        deny.args(OFFLINE);
    }
    run_command(deny.args(checks))
}
