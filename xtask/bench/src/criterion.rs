//! The criterion benchmarks of all crates that have some, or those on one kind of processor.
//!
//! `cargo bench --workspace` would also start every crate's unit tests as benchmarks, and those stop at the
//! first option that is meant for criterion, such as `--save-baseline`.
//! So packages and benchmarks are named one by one.
//! A benchmark that needs a GPU is called `gpu`, in whichever crate it is.

use std::ffi::OsString;

use anyhow::{Result, ensure};

use xtask::process::{cargo, run as run_command};
use xtask::workspace::{self, Package, Workspace};

const GPU_BENCH: &str = "gpu";

/// The processor that is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Processor {
    Any,
    Cpu,
    Gpu,
}

impl Processor {
    fn runs(self, bench: &str) -> bool {
        match self {
            Self::Any => true,
            Self::Cpu => bench != GPU_BENCH,
            Self::Gpu => bench == GPU_BENCH,
        }
    }
}

pub(super) fn run(processor: Processor, args: &[OsString]) -> Result<()> {
    let selection = selection(&Workspace::read()?.packages, processor);
    ensure!(!selection.is_empty(), "no crate of this workspace has such a benchmark");
    run_command(cargo(workspace::root()).arg("bench").args(selection).args(args))
}

fn selection(packages: &[Package], processor: Processor) -> Vec<String> {
    let mut args = Vec::new();
    for package in packages {
        let mut benches = package.benches().filter(|bench| processor.runs(bench)).peekable();
        if benches.peek().is_some() {
            args.extend(["--package".to_owned(), package.name.clone()]);
        }
        args.extend(benches.flat_map(|bench| ["--bench".to_owned(), bench.to_owned()]));
    }
    args
}

#[cfg(test)]
mod tests {
    use super::*;
    use xtask::workspace::Target;

    fn check(processor: Processor, expected: &str) {
        let bench =
            |name: &&str| Target { name: (*name).to_owned(), kind: vec!["bench".to_owned()] };
        let with = |name: &str, benches: &[&str]| Package {
            name: name.to_owned(),
            targets: benches.iter().map(bench).collect(),
            ..Package::default()
        };
        let packages = [
            with("core", &[]),
            with("kernel", &["section", "table"]),
            with("tests", &["frame", "gpu"]),
            with("wgpu", &["gpu"]),
        ];
        assert_eq!(selection(&packages, processor).join(" "), expected, "{processor:?}");
    }

    #[test]
    fn selection_names_benches_only() {
        let kernel = "--package kernel --bench section --bench table";
        let tests = "--package tests --bench frame --bench gpu";
        check(Processor::Any, &format!("{kernel} {tests} --package wgpu --bench gpu"));
    }

    #[test]
    fn selection_of_one_processor() {
        let kernel = "--package kernel --bench section --bench table";
        check(Processor::Cpu, &format!("{kernel} --package tests --bench frame"));
        check(Processor::Gpu, "--package tests --bench gpu --package wgpu --bench gpu");
    }
}
