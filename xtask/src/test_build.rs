//! Programs that `cargo xtask test` has built already, for what runs them in another way.
//!
//! Cargo unites features over all packages that are named, and builds each profile by itself: asked for a
//! program of one package, or in another profile, it would build most of the workspace anew.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::process::{REPEATABLE, cargo, output, starts};

/// What is built with MPI, where there is one.
const MPI: &str = "slabsplat-cli/mpi,slabsplat-mpi/mpi";

/// Whether ranks can be built and started.
#[must_use]
pub fn has_mpi() -> bool {
    starts("mpicc") && starts("mpirun")
}

/// The arguments of cargo for all packages, with the features that all tests have.
#[must_use]
pub fn all_packages() -> &'static [&'static str] {
    if has_mpi() { &["--workspace", "--features", MPI] } else { &["--workspace"] }
}

/// The program of a test.
///
/// # Errors
/// If it does not build.
pub fn test(root: &Path, name: &str) -> Result<PathBuf> {
    program(root, &["test", "--no-run", "--test", name], name)
}

/// The program of an example. `cargo test --example` would make a test of it.
///
/// # Errors
/// If it does not build.
pub fn example(root: &Path, name: &str) -> Result<PathBuf> {
    program(root, &["build", "--profile", "test", "--example", name], name)
}

fn program(root: &Path, args: &[&str], name: &str) -> Result<PathBuf> {
    let mut build = cargo(root);
    let (variable, value) = REPEATABLE;
    build.env(variable, value);
    build.args(args).args(all_packages());
    build.arg("--message-format=json-render-diagnostics").stderr(Stdio::inherit());
    let messages = output(&mut build)?;
    let program = messages.lines().filter_map(|line| program_in(line, name)).next_back();
    program.with_context(|| format!("cargo built no program `{name}`"))
}

/// The program of a target, if this message of cargo's names it.
fn program_in(message: &str, target: &str) -> Option<PathBuf> {
    let message: Value = serde_json::from_str(message).ok()?;
    let is_meant = message["reason"] == "compiler-artifact" && message["target"]["name"] == target;
    message["executable"].as_str().filter(|_| is_meant).map(PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn program_in_messages() {
        let message = r#"{ "reason": "compiler-artifact", "executable": "/t/instructions-1",
            "target": { "name": "instructions" } }"#;
        assert_eq!(program_in(message, "instructions"), Some("/t/instructions-1".into()));
        assert_eq!(program_in(message, "gpu"), None, "another target");
        assert_eq!(program_in("warning: no JSON", "instructions"), None);
    }
}
