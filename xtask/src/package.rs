//! `cargo xtask package`: packs every crate that is published as `cargo publish` would, and checks that each
//! compiles of its package alone.
//!
//! A checkout hides what a package lacks: a file outside of the crate's folder, a version that a dependency
//! has only by its path, a licence. Here crates find each other by their packages too, as they would in a
//! registry. Nothing is uploaded, and what is not committed yet is packed as it is.
//!
//! Cargo itself would build them to the end, each in turn; what is built of packages to the end, and run, is
//! `cargo xtask web --packages` and `cargo xtask outside`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use xtask::process::{cargo, output, run as run_command};
use xtask::workspace::{self, Package, Workspace};

/// What every package must hold beside its code.
const IN_EVERY_PACKAGE: &[&str] = &["LICENSE-APACHE", "LICENSE-MIT", "README.md"];

pub(crate) fn run() -> Result<()> {
    let workspace = Workspace::read()?;
    let packages: Vec<&Package> = workspace.published().collect();
    for package in &packages {
        check_list(&package.name)?;
    }
    let folder = folder(&workspace);
    // What packages held once they may lack now.
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())?;
    }
    let mut pack = cargo(workspace::root());
    pack.args(["package", "--no-verify", "--allow-dirty", "--target-dir"]).arg(target(&workspace));
    run_command(pack.args(packages.iter().flat_map(|package| ["--package", &*package.name])))?;
    for package in &packages {
        unpack(&folder, package)?;
    }
    check(&workspace, &packages)
}

fn target(workspace: &Workspace) -> PathBuf {
    workspace.target_directory.join("packages")
}

/// Where cargo puts packages, and where they are unpacked.
pub(crate) fn folder(workspace: &Workspace) -> PathBuf {
    target(workspace).join("package")
}

/// As packages and the folders in them are called.
pub(crate) fn unpacked(package: &Package) -> String {
    format!("{}-{}", package.name, package.version)
}

fn unpack(folder: &Path, package: &Package) -> Result<()> {
    let archive = format!("{}.crate", unpacked(package));
    // `m`: with dates of now. All files in packages have the same one, by which what was built of the last
    // packages would count as built of these.
    run_command(Command::new("tar").current_dir(folder).args(["-xzmf", &*archive]))
}

/// Checks them all, as members of a workspace in which each stands for what a registry has by its name.
fn check(workspace: &Workspace, packages: &[&Package]) -> Result<()> {
    let folder = folder(workspace);
    fs::write(folder.join("Cargo.toml"), manifest(packages))?;
    fs::copy(workspace::root().join("Cargo.lock"), folder.join("Cargo.lock"))?;
    let mut check = cargo(&folder);
    // With the optimisation of our own workspace: so most of what they use has been checked there by
    // `cargo xtask lint`.
    check.args(["check", "--workspace", "--all-features", "--target-dir"]);
    run_command(check.arg(&workspace.target_directory).env("CARGO_PROFILE_DEV_OPT_LEVEL", "1"))
}

/// Of the workspace of packages.
fn manifest(packages: &[&Package]) -> String {
    let members: Vec<String> = packages.iter().map(|package| unpacked(package)).collect();
    let mut manifest = format!("[workspace]\nresolver = \"3\"\nmembers = {members:?}\n");
    manifest.push_str("[patch.crates-io]\n");
    for (package, member) in packages.iter().zip(members) {
        manifest.push_str(&format!("{} = {{ path = {member:?} }}\n", package.name));
    }
    manifest
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
    fn manifest_knows_packages_by_name() {
        let package = |name: &str| {
            let (name, version) = (name.to_owned(), "1.2.3".to_owned());
            Package { name, version, ..Package::default() }
        };
        let packages = [package("slabsplat"), package("slabsplat-core")];
        let manifest = manifest(&packages.each_ref());
        let manifest: toml::Table = manifest.parse().unwrap();
        assert_eq!(
            manifest["workspace"]["members"].as_array().unwrap().len(),
            packages.len(),
            "{manifest}"
        );
        let patch = &manifest["patch"]["crates-io"];
        assert_eq!(patch["slabsplat-core"]["path"].as_str(), Some("slabsplat-core-1.2.3"));
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
