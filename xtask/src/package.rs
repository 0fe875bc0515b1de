//! `cargo xtask package`: packs every crate that is published as `cargo publish` would, and builds each from
//! its package alone.
//!
//! A checkout hides what a package lacks: a file outside of the crate's folder, a version that a dependency
//! has only by its path, a licence. Here crates find each other by their packages too, as they would in a
//! registry. Nothing is uploaded, and what is not committed yet is packed as it is.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

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
    if let Some(home) = cargo_home() {
        forget_unpacked(&home.join("registry").join("src"), &names)?;
    }
    let of_all = |subcommand: &str| {
        let mut command = cargo(workspace::root());
        command.arg(subcommand).args(names.iter().flat_map(|name| ["--package", *name]));
        // Otherwise each package builds all that it depends on anew, in a folder of its own; and what is
        // forgotten below would be what tests have built.
        command.arg("--target-dir").arg(target(&workspace));
        command
    };
    // What was compiled of the last packages counts as that of these, whose versions are the same.
    run_command(&mut of_all("clean"))?;
    // Nobody debugs it, and with debug information it takes twice as long.
    let mut package = of_all("package");
    run_command(
        package.args(["--all-features", "--allow-dirty"]).env("CARGO_PROFILE_DEV_DEBUG", "0"),
    )
}

fn target(workspace: &Workspace) -> PathBuf {
    workspace.target_directory.join("packages")
}

/// Where packages are unpacked, each in a folder that is called by its name and version.
pub(crate) fn folder(workspace: &Workspace) -> PathBuf {
    target(workspace).join("package")
}

fn cargo_home() -> Option<PathBuf> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    home.or_else(|| Some(std::env::home_dir()?.join(".cargo")))
}

/// Removes what cargo unpacked of our packages the last time. It takes a version for what it was, as that of
/// a registry never changes, and would build others on yesterday's code. Such a registry, which is a folder
/// in the target folder, has a name that begins with a hyphen.
fn forget_unpacked(sources: &Path, names: &[&str]) -> Result<()> {
    let is_local = |folder: &PathBuf| file_name(folder).starts_with('-');
    let registries = entries(sources).into_iter().filter(is_local);
    for package in registries.flat_map(|registry| entries(&registry)) {
        if names.iter().any(|name| is_version_of(&file_name(&package), name)) {
            fs::remove_dir_all(&package).with_context(|| package.display().to_string())?;
        }
    }
    Ok(())
}

fn is_version_of(folder: &str, name: &str) -> bool {
    let version = folder.strip_prefix(name).and_then(|rest| rest.strip_prefix('-'));
    version.is_some_and(|version| version.starts_with(|c: char| c.is_ascii_digit()))
}

/// None, if there is no such folder.
fn entries(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
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
    fn unpacked_versions_by_name() {
        assert!(is_version_of("slabsplat-0.1.0", "slabsplat"));
        assert!(is_version_of("slabsplat-core-1.2.3", "slabsplat-core"));
        for other in ["slabsplat-core-0.1.0", "slabsplat", "slabsplatter-0.1.0"] {
            assert!(!is_version_of(other, "slabsplat"), "{other}");
        }
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
