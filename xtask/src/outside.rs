//! `cargo xtask outside`: builds and tests the programs of `tests/outside`, which are written as other people
//! would write them, on the packages that `cargo xtask package` made.
//!
//! They lie in a workspace of their own and know slabsplat by its version only; what stands for the registry
//! is the packages, each put in the place of the crate of its name. So a program finds what its author would
//! find, and nothing of the checkout besides.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use xtask::process::{cargo, run as run_command};
use xtask::workspace::{self, Workspace};

use crate::lint::{WASM, WASM_FLAGS, WASM_VECTORS, has_target};
use crate::package;
use crate::web::PAGES;

pub(crate) fn run() -> Result<()> {
    let workspace = Workspace::read()?;
    let outside = Outside::new(&workspace, packages(&workspace)?);
    run_command(cargo(&programs()).args(["fmt", "--all", "--check"]))?;
    let all = ["--workspace", "--all-targets"];
    run_command(outside.cargo("clippy").args(all).args(["--", "-D", "warnings"]))?;
    run_command(outside.cargo("test").arg("--no-fail-fast").args(all))?;
    if !has_target(WASM) {
        eprintln!("outside: pages are skipped, as there is no {WASM}: `rustup target add {WASM}`");
        return Ok(());
    }
    run_command(&mut outside.pages())
}

/// How the programs are built.
pub(crate) struct Outside<'a> {
    /// Where to.
    pub(crate) target: PathBuf,
    /// Name and folder of each crate of ours.
    crates: Vec<(&'a str, PathBuf)>,
}

impl<'a> Outside<'a> {
    pub(crate) fn new(workspace: &Workspace, crates: Vec<(&'a str, PathBuf)>) -> Self {
        Self { target: workspace.target_directory.join("outside"), crates }
    }

    /// A command of cargo's among them.
    pub(crate) fn cargo(&self, subcommand: &str) -> Command {
        let mut command = cargo(&programs());
        command.arg(subcommand).arg("--target-dir").arg(&self.target);
        patch(&mut command, &self.crates);
        command
    }

    /// Builds the pages; never without optimisation: that takes 18 GB of memory for slabsplat-cpu.
    pub(crate) fn pages(&self) -> Command {
        let mut build = self.cargo("build");
        build.args(["--release", "--target", WASM]).env(WASM_FLAGS, WASM_VECTORS);
        build.args(PAGES.iter().flat_map(|page| ["--package", *page]));
        build
    }
}

/// Where the programs lie.
pub(crate) fn programs() -> PathBuf {
    workspace::root().join("tests").join("outside")
}

/// Name and unpacked package of each library that is published.
pub(crate) fn packages(workspace: &Workspace) -> Result<Vec<(&str, PathBuf)>> {
    let folder = package::folder(workspace);
    workspace
        .published()
        // Cargo complains of what nobody can use.
        .filter(|package| package.has_library())
        .map(|package| {
            let unpacked = folder.join(package::unpacked(package));
            let is_there = unpacked.join("Cargo.toml").is_file();
            ensure!(is_there, "{} is not packed: `cargo xtask package` does it", package.name);
            Ok((&*package.name, unpacked))
        })
        .collect()
}

/// Has cargo take these crates where it would ask the registry.
fn patch(command: &mut Command, crates: &[(&str, PathBuf)]) {
    for (name, folder) in crates {
        command.arg("--config").arg(patch_of(name, folder));
    }
}

/// As a line of cargo's configuration.
fn patch_of(name: &str, folder: &Path) -> String {
    // A literal string of TOML, in which no backslash means anything.
    format!("patch.crates-io.{name}.path='{}'", folder.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patch_is_a_line_of_toml() {
        let line = patch_of("slabsplat-io", Path::new(r"C:\target\package\slabsplat-io-0.1.0"));
        let expected = r"patch.crates-io.slabsplat-io.path='C:\target\package\slabsplat-io-0.1.0'";
        assert_eq!(line, expected);
    }

    #[test]
    fn programs_know_versions_only() {
        let manifest = std::fs::read_to_string(programs().join("Cargo.toml")).unwrap();
        assert!(manifest.contains("slabsplat = { version = "), "from a registry, as it seems");
        assert!(!manifest.contains("path ="), "nothing by its path");
    }
}
