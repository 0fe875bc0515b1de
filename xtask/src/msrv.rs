//! `cargo xtask msrv`: whether the oldest Rust that the manifests promise builds what promises it: the libraries.
//! Windows need a younger one, and with them the program; that one is not tested apart, as it is hardly older than
//! the one that builds everything.
//!
//! That toolchain comes by rustup. Where it is not installed a line says so, and nothing is tested; with
//! `--install` rustup is asked for it first.

use std::ffi::OsString;
use std::process::Command;

use anyhow::{Context, Result};

use xtask::process::{output, run as run_command};
use xtask::workspace::{self, Package, Workspace};

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
    let promises = |package: &Package| package.rust_version.clone();
    let promised = workspace.published().filter_map(promises).min_by_key(|it| minor_of(it));
    let promised = promised.context("manifests promise no `rust-version`")?;
    let toolchain = toolchain(&promised);
    if installs && let Err(error) = install(&toolchain) {
        eprintln!("msrv: {error:#}");
    }
    if !is_installed(&toolchain) {
        eprintln!("msrv: skipped, as rustup has no Rust {toolchain}: `cargo xtask msrv --install`");
        return Ok(());
    }
    let mut check = with_toolchain(&toolchain);
    check.args(["cargo", "check", "--locked", "--all-features"]);
    let promising = workspace
        .published()
        .filter(|package| package.rust_version.as_deref() == Some(promised.as_str()));
    check.args(promising.flat_map(|package| ["--package", &package.name]));
    // Two compilers that share a folder take turns in building everything anew.
    run_command(check.arg("--target-dir").arg(workspace.target_directory.join("msrv")))
}

/// The number that tells versions of Rust apart.
fn minor_of(rust_version: &str) -> u32 {
    rust_version.split('.').nth(1).and_then(|minor| minor.parse().ok()).unwrap_or(0)
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
        assert!(minor_of("1.90") < minor_of("1.100") && minor_of("1.95.2") == 95);
    }
}
