//! `cargo xtask package`: packs every crate that is published as `cargo publish` would, and builds each from
//! its package alone.
//!
//! A checkout hides what a package lacks: a file outside of the crate's folder, a version that a dependency
//! has only by its path, a licence. Here crates find each other by their packages too, as they would in a
//! registry. Nothing is uploaded, and what is not committed yet is packed as it is.

use anyhow::{Result, ensure};

use xtask::process::{cargo, output, run as run_command};
use xtask::workspace::{self, Workspace};

/// What every package must hold beside its code.
const IN_EVERY_PACKAGE: &[&str] = &["LICENSE-APACHE", "LICENSE-MIT", "README.md"];

pub(crate) fn run() -> Result<()> {
    let workspace = Workspace::read()?;
    let names: Vec<&str> = workspace.published().map(|package| &*package.name).collect();
    for name in &names {
        check_list(name)?;
    }
    let mut package = cargo(workspace::root());
    package.args(["package", "--all-features", "--allow-dirty"]);
    package.args(names.iter().flat_map(|name| ["--package", *name]));
    // Otherwise each package builds all that it depends on anew, in a folder of its own.
    package.arg("--target-dir").arg(&workspace.target_directory);
    // Nobody debugs it, and with debug information it takes twice as long.
    run_command(package.env("CARGO_PROFILE_DEV_DEBUG", "0"))
}

fn check_list(name: &str) -> Result<()> {
    let list = ["package", "--list", "--allow-dirty", "--package", name];
    let files = output(cargo(workspace::root()).args(list))?;
    let lacks = lacking(&files);
    ensure!(lacks.is_empty(), "the package of {name} lacks {}", lacks.join(", "));
    Ok(())
}

/// What is not among the files of a package, one a line.
fn lacking(files: &str) -> Vec<&'static str> {
    let is_there = |name: &str| files.lines().any(|file| file == name);
    IN_EVERY_PACKAGE.iter().copied().filter(|name| !is_there(name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lacking_files_by_whole_names() {
        assert!(
            lacking("Cargo.toml\nLICENSE-APACHE\nLICENSE-MIT\nREADME.md\nsrc/lib.rs\n").is_empty()
        );
        assert_eq!(lacking("docs/README.md\nLICENSE-MIT\n"), ["LICENSE-APACHE", "README.md"]);
    }

    #[test]
    fn published_are_libraries_and_the_program() {
        let workspace = Workspace::read().unwrap();
        let published: Vec<&str> = workspace.published().map(|package| &*package.name).collect();
        for (name, is_published) in [("slabsplat", true), ("slabsplat-cli", true), ("xtask", false)]
        {
            assert_eq!(published.contains(&name), is_published, "{name}");
        }
    }
}
