//! `cargo xtask ci`: what must pass before a change is handed in.
//!
//! Beside all other commands that judge it builds each crate without features, and with each feature alone.
//! A build of the whole workspace unites the features, and so hides one that does not stand by itself; it
//! unites those of dependencies too, and so a crate that has no features is built alone as well.

use anyhow::{Result, ensure};

use xtask::process::{cargo, run as run_command};
use xtask::workspace::{self, Package, Workspace};

use crate::deny::{self, Deny};
use crate::test::{self, Test};
use crate::web::{self, Web};
use crate::{lint, msrv, outside, package, semver};

pub(crate) fn run() -> Result<()> {
    lint::run()?;
    test::run(&Test::default())?;
    package::run()?;
    web::run(Web::OF_PACKAGES)?;
    outside::run()?;
    msrv::run(false)?;
    deny::run(&Deny::default())?;
    semver::run(None)?;
    check_features()
}

fn check_features() -> Result<()> {
    let mut failed = Vec::new();
    for build in Workspace::read()?.packages.iter().flat_map(feature_builds) {
        if run_command(cargo(workspace::root()).arg("check").args(&build)).is_err() {
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
