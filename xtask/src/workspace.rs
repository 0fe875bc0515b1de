//! What cargo knows about the workspace, as far as the tools ask: packages, what they use, features,
//! benchmarks.
//!
//! Read from `cargo metadata --no-deps`, which parses manifests only: it needs neither a lock file nor a
//! network.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::process::{cargo, output};

/// The workspace.
#[derive(Clone, Debug, Deserialize)]
pub struct Workspace {
    /// Its members.
    pub packages: Vec<Package>,
    /// Where cargo puts what it builds.
    pub target_directory: PathBuf,
}

/// A member of the workspace.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Package {
    /// As its manifest says.
    pub name: String,
    /// As its manifest says, or the workspace's.
    pub version: String,
    /// Where that manifest is.
    pub manifest_path: PathBuf,
    /// The registries that it may go to: any if there is no list, none if it is empty.
    pub publish: Option<Vec<String>>,
    /// The oldest Rust that builds it, as its manifest says.
    pub rust_version: Option<String>,
    /// What it uses, its tests and build script included.
    pub dependencies: Vec<Dependency>,
    /// Features by name; what they switch on does not matter here.
    pub features: BTreeMap<String, IgnoredAny>,
    /// Libraries, programs, tests, benchmarks.
    pub targets: Vec<Target>,
}

/// Something that a package uses.
#[derive(Clone, Debug, Deserialize)]
pub struct Dependency {
    /// As the registry or the workspace knows it, however the manifest renames it.
    pub name: String,
    /// Who sees it; `None` stands for the library or program itself.
    pub kind: Option<DependencyKind>,
    /// Whether it comes with a feature only.
    pub optional: bool,
}

/// Who sees a dependency if the library or program does not.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DependencyKind {
    /// Tests, examples and benchmarks.
    Dev,
    /// The build script.
    Build,
}

/// Something that cargo builds of a package.
#[derive(Clone, Debug, Deserialize)]
pub struct Target {
    /// As `--test` or `--bench` takes it.
    pub name: String,
    /// As cargo calls it: `["lib"]`, `["bench"]`.
    pub kind: Vec<String>,
}

impl Workspace {
    /// Asks cargo.
    ///
    /// # Errors
    /// If a manifest is wrong.
    pub fn read() -> Result<Self> {
        let metadata = ["metadata", "--no-deps", "--format-version", "1"];
        parse(&output(cargo(root()).args(metadata))?)
    }

    /// Members that a registry gets.
    pub fn published(&self) -> impl Iterator<Item = &Package> {
        self.packages.iter().filter(|package| package.is_published())
    }
}

impl Package {
    /// Names of the benchmarks.
    pub fn benches(&self) -> impl Iterator<Item = &str> {
        let benches = self.targets.iter().filter(|target| target.kind == ["bench"]);
        benches.map(|target| target.name.as_str())
    }

    /// Whether others can depend on it.
    #[must_use]
    pub fn has_library(&self) -> bool {
        self.targets.iter().any(|target| target.kind == ["lib"])
    }

    /// Whether a registry gets it.
    #[must_use]
    pub fn is_published(&self) -> bool {
        self.publish.as_ref().is_none_or(|registries| !registries.is_empty())
    }
}

/// The directory of the workspace's manifest.
#[must_use]
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace's directory")
}

fn parse(metadata: &str) -> Result<Workspace> {
    let mut workspace: Workspace =
        serde_json::from_str(metadata).context("cannot read `cargo metadata`")?;
    workspace.packages.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(workspace)
}

#[cfg(test)]
mod tests {
    use super::*;

    const METADATA: &str = r#"{ "target_directory": "/t", "packages": [ {
        "name": "a",
        "version": "0.1.0",
        "manifest_path": "/a/Cargo.toml",
        "publish": null,
        "rust_version": "1.90",
        "dependencies": [
            { "name": "glam", "kind": null, "optional": false },
            { "name": "fastrand", "kind": "dev", "optional": false },
            { "name": "naga", "kind": "build", "optional": false }
        ],
        "features": { "default": ["simd"], "simd": [] },
        "targets": [ { "name": "a", "kind": ["lib"] }, { "name": "toss", "kind": ["bench"] } ]
    } ] }"#;

    #[test]
    fn parse_one_package() {
        let workspace = parse(METADATA).unwrap();
        let package = &workspace.packages[0];
        assert_eq!(package.name, "a", "name");
        assert!(package.features.keys().eq(["default", "simd"]), "features");
        assert!(package.benches().eq(["toss"]), "benches, without the library");
        assert!(package.has_library(), "the other target");
        assert!(package.is_published(), "to any registry");
        assert!(
            !Package { publish: Some(Vec::new()), ..package.clone() }.is_published(),
            "to none"
        );
        let kinds: Vec<_> = package.dependencies.iter().map(|d| d.kind).collect();
        assert_eq!(kinds, [None, Some(DependencyKind::Dev), Some(DependencyKind::Build)]);
    }

    #[test]
    fn read_this_workspace() {
        let packages = Workspace::read().unwrap().packages;
        assert!(packages.iter().any(|package| package.name == "xtask"), "xtask is a member");
    }
}
