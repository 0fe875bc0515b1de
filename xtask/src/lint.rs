//! `cargo xtask lint`: everything that can be said about the code without running it.
//!
//! All steps run even if one fails, the quick ones first: one round shows everything there is to repair.
//! Nothing is repaired here; `cargo fmt` and `cargo clippy --fix` do that.

use std::path::Path;
use std::process::Command;

use anyhow::{Result, bail, ensure};

use xtask::process::{cargo, output, run as run_command};
use xtask::workspace::{self, Workspace};

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

fn report(findings: &[impl ToString]) -> Result<()> {
    if findings.is_empty() {
        return Ok(());
    }
    let lines: Vec<String> = findings.iter().map(ToString::to_string).collect();
    bail!("{}", lines.join("\n"))
}
