//! `cargo xtask lint`: everything that can be said about the code without running it.
//!
//! All steps run even if one fails, the quick ones first: one round shows everything there is to repair.
//! Nothing is repaired here; `cargo fmt` and `cargo clippy --fix` do that.

use std::path::Path;
use std::process::Command;

use anyhow::{Result, bail, ensure};

use xtask::process::{cargo, output, run as run_command};
use xtask::workspace::{self, Package, Workspace};

use crate::{dependencies, tidy};

pub(crate) const WASM: &str = "wasm32-unknown-unknown";

/// The environment variable that has flags of the compiler for that target alone.
pub(crate) const WASM_FLAGS: &str = "CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS";

/// What it says for vectors.
pub(crate) const WASM_VECTORS: &str = "-Ctarget-feature=+simd128";

type Step = fn(&Path) -> Result<()>;

const STEPS: &[(&str, Step)] = &[
    ("rustfmt", check_format),
    ("tidy", check_tidy),
    ("dependency rules", check_dependencies),
    ("clippy", check_clippy),
    ("documentation", check_documentation),
    ("WebAssembly", check_wasm),
    ("features", check_features),
];

pub(crate) fn run() -> Result<()> {
    let root = workspace::root();
    let mut failed = Vec::new();
    for (name, step) in STEPS {
        eprintln!("lint: {name}");
        if let Err(error) = step(root) {
            eprintln!("{error:#}");
            failed.push(*name);
        }
    }
    ensure!(failed.is_empty(), "lint failed in {}", failed.join(", "));
    Ok(())
}

fn check_format(root: &Path) -> Result<()> {
    run_command(cargo(root).args(["fmt", "--all", "--check"]))
}

fn check_tidy(root: &Path) -> Result<()> {
    report(&tidy::check(root)?)
}

fn check_dependencies(root: &Path) -> Result<()> {
    report(&dependencies::check(root, &Workspace::read()?.packages)?)
}

fn check_clippy(root: &Path) -> Result<()> {
    let clippy = ["clippy", "--workspace", "--all-targets", "--all-features"];
    run_command(cargo(root).args(clippy).args(["--", "-D", "warnings"]))
}

fn check_documentation(root: &Path) -> Result<()> {
    let doc = ["doc", "--no-deps", "--workspace", "--all-features"];
    run_command(cargo(root).args(doc).env("RUSTDOCFLAGS", "-Dwarnings"))
}

/// Where the target is installed: all that a page can use, and with vectors what is made of them.
fn check_wasm(root: &Path) -> Result<()> {
    if !has_target(WASM) {
        eprintln!("lint: skipped, as it is not here: `rustup target add {WASM}`");
        return Ok(());
    }
    let check = |package: &[&str]| {
        let mut command = cargo(root);
        command.args(["check", "--target", WASM, "--package"]).args(package);
        command
    };
    run_command(&mut check(&["slabsplat", "--features", "wgpu"]))?;
    run_command(check(&["slabsplat-cpu"]).env(WASM_FLAGS, WASM_VECTORS))
}

pub(crate) fn has_target(target: &str) -> bool {
    let libraries = ["--print", "target-libdir", "--target", target];
    let folder = output(Command::new("rustc").args(libraries)).unwrap_or_default();
    Path::new(folder.trim()).is_dir()
}

/// Crates that have features without any, and with each alone: a build of the whole workspace unites them,
/// and so hides one that does not stand by itself.
fn check_features(_: &Path) -> Result<()> {
    check_alone(has_features)
}

pub(crate) fn has_features(package: &Package) -> bool {
    !package.features.is_empty()
}

/// Builds some of the crates by themselves.
pub(crate) fn check_alone(is_wanted: fn(&Package) -> bool) -> Result<()> {
    let mut failed = Vec::new();
    let packages = Workspace::read()?.packages;
    for build in packages.iter().filter(|package| is_wanted(package)).flat_map(feature_builds) {
        let mut check = cargo(workspace::root());
        if run_command(check.args(["check", "--quiet"]).args(&build)).is_err() {
            failed.push(build.join(" "));
        }
    }
    ensure!(failed.is_empty(), "these do not build alone:\n{}", failed.join("\n"));
    Ok(())
}

/// The arguments of one build per feature, and of one without.
fn feature_builds(package: &Package) -> Vec<Vec<String>> {
    let bare = ["--package", &package.name, "--no-default-features"].map(str::to_owned).to_vec();
    let alone = package.features.keys().filter(|feature| *feature != "default").map(|feature| {
        let mut build = bare.clone();
        build.extend(["--features".to_owned(), feature.clone()]);
        build
    });
    std::iter::once(bare.clone()).chain(alone).collect()
}

fn report(findings: &[impl ToString]) -> Result<()> {
    if findings.is_empty() {
        return Ok(());
    }
    let lines: Vec<String> = findings.iter().map(ToString::to_string).collect();
    bail!("{}", lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::IgnoredAny;

    fn check(features: &[&str], expected: &[&str]) {
        let features = features.iter().map(|name| ((*name).to_owned(), IgnoredAny)).collect();
        let package = Package { name: "a".to_owned(), features, ..Package::default() };
        let builds: Vec<String> = feature_builds(&package).iter().map(|b| b.join(" ")).collect();
        assert_eq!(builds, expected, "features of {expected:?}");
    }

    #[test]
    fn feature_builds_each_alone() {
        let bare = "--package a --no-default-features";
        check(&[], &[bare]);
        let cpu = "--package a --no-default-features --features cpu";
        let wgpu = "--package a --no-default-features --features wgpu";
        check(&["cpu", "default", "wgpu"], &[bare, cpu, wgpu]);
    }
}
