//! `cargo xtask msrv`: whether the oldest Rust that the manifests promise builds what is published.
//!
//! That toolchain comes by rustup. Where it is not installed a line says so, and nothing is tested; with
//! `--install` rustup is asked for it first.

use std::ffi::OsString;
use std::process::Command;

use anyhow::{Context, Result};

use xtask::process::{output, run as run_command};
use xtask::workspace::{self, Workspace};

/// Whether the arguments ask to install.
pub(crate) fn parse(args: &[OsString]) -> Result<bool, String> {
    match args {
        [] => Ok(false),
        [flag] if flag == "--install" => Ok(true),
        [arg, ..] => Err(format!("`msrv` takes `--install` alone, found `{}`", arg.display())),
    }
}

pub(crate) fn run(installs: bool) -> Result<()> {
    let workspace = Workspace::read()?;
    let promised = workspace.published().find_map(|package| package.rust_version.as_deref());
    let toolchain = toolchain(promised.context("manifests promise no `rust-version`")?);
    if installs && let Err(error) = install(&toolchain) {
        eprintln!("msrv: {error:#}");
    }
    if !is_installed(&toolchain) {
        eprintln!("msrv: skipped, as rustup has no Rust {toolchain}: `cargo xtask msrv --install`");
        return Ok(());
    }
    let mut check = with_toolchain(&toolchain);
    check.args(["cargo", "check", "--locked", "--all-features"]);
    check.args(workspace.published().flat_map(|package| ["--package", &package.name]));
    // Two compilers that share a folder take turns in building everything anew.
    run_command(check.arg("--target-dir").arg(workspace.target_directory.join("msrv")))
}

/// As rustup calls the first release of a version.
fn toolchain(rust_version: &str) -> String {
    match rust_version.matches('.').count() {
        1 => format!("{rust_version}.0"),
        _ => rust_version.to_owned(),
    }
}

fn install(toolchain: &str) -> Result<()> {
    let install = ["toolchain", "install", toolchain, "--profile", "minimal", "--no-self-update"];
    run_command(Command::new("rustup").args(install))
}

fn is_installed(toolchain: &str) -> bool {
    output(with_toolchain(toolchain).args(["rustc", "--version"])).is_ok()
}

fn with_toolchain(toolchain: &str) -> Command {
    let mut command = Command::new("rustup");
    command.args(["run", toolchain]).current_dir(workspace::root());
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn toolchain_is_a_release() {
        assert_eq!(toolchain("1.90"), "1.90.0");
        assert_eq!(toolchain("1.90.1"), "1.90.1");
    }
}
