//! `cargo xtask bench`: the benchmarks of all crates that have some.
//!
//! `cargo bench --workspace` would also start every crate's unit tests as benchmarks, and those stop at the first
//! option that is meant for criterion, such as `--save-baseline`.
//! So packages and benchmarks are named one by one.

use std::ffi::OsString;

use anyhow::{Result, ensure};

use crate::process::{cargo, run as run_command};
use crate::workspace::{self, Package};

pub(crate) fn run(args: &[OsString]) -> Result<()> {
    let root = workspace::root();
    let selection = selection(&workspace::packages(root)?);
    ensure!(!selection.is_empty(), "no crate of this workspace has a benchmark");
    run_command(cargo(root).arg("bench").args(selection).args(args))
}

fn selection(packages: &[Package]) -> Vec<String> {
    let mut args = Vec::new();
    for package in packages.iter().filter(|package| !package.benches.is_empty()) {
        args.extend(["--package".to_owned(), package.name.clone()]);
        for bench in &package.benches {
            args.extend(["--bench".to_owned(), bench.clone()]);
        }
    }
    args
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selection_names_benches_only() {
        let mut kernel = Package::named("slabsplat-kernel");
        kernel.benches = vec!["section".to_owned(), "table".to_owned()];
        let packages = [Package::named("slabsplat-core"), kernel];
        let expected = ["--package", "slabsplat-kernel", "--bench", "section", "--bench", "table"];
        assert_eq!(selection(&packages), expected, "only the crate with benchmarks is named");
    }
}
