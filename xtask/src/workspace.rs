//! What cargo knows about the workspace, as far as the other modules ask: packages, what they use, features, benchmarks.
//!
//! Read from `cargo metadata --no-deps`, which parses manifests only: it needs neither a lock file nor a network.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::process::{cargo, output};

#[derive(Clone, Debug)]
pub(crate) struct Package {
    pub(crate) name: String,
    pub(crate) dependencies: Vec<Dependency>,
    pub(crate) features: Vec<String>,
    pub(crate) benches: Vec<String>,
}

#[derive(Clone, Debug)]
pub(crate) struct Dependency {
    /// As the registry or the workspace knows it, however the manifest renames it.
    pub(crate) name: String,
    pub(crate) kind: DependencyKind,
}

/// Who sees a dependency: the library or program, its tests, examples and benchmarks, or its build script.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum DependencyKind {
    Normal,
    Dev,
    Build,
}

/// The directory of the workspace's manifest.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace's directory")
}

/// What lies beside a checkout, where it does: scenes on real data, and scripts that run other renderers.
pub(crate) fn shared() -> PathBuf {
    root().parent().unwrap_or(root()).join("shared")
}

/// The members of the workspace, by name.
pub(crate) fn packages(root: &Path) -> Result<Vec<Package>> {
    parse(&metadata(root)?).context("cannot read `cargo metadata`")
}

/// Where cargo puts what it builds.
pub(crate) fn target_directory(root: &Path) -> Result<PathBuf> {
    let metadata: Value = serde_json::from_str(&metadata(root)?)?;
    Ok(string(&metadata, "target_directory")?.into())
}

fn metadata(root: &Path) -> Result<String> {
    output(cargo(root).args(["metadata", "--no-deps", "--format-version", "1"]))
}

fn parse(metadata: &str) -> Result<Vec<Package>> {
    let metadata: Value = serde_json::from_str(metadata)?;
    let mut packages: Vec<Package> =
        array(&metadata, "packages")?.iter().map(parse_package).collect::<Result<_>>()?;
    packages.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(packages)
}

fn parse_package(package: &Value) -> Result<Package> {
    let features = package["features"].as_object().context("`features` is no table")?;
    let is_bench = |target: &&Value| target["kind"] == serde_json::json!(["bench"]);
    Ok(Package {
        name: string(package, "name")?,
        dependencies: array(package, "dependencies")?
            .iter()
            .map(parse_dependency)
            .collect::<Result<_>>()?,
        features: features.keys().cloned().collect(),
        benches: array(package, "targets")?
            .iter()
            .filter(is_bench)
            .map(|target| string(target, "name"))
            .collect::<Result<_>>()?,
    })
}

fn parse_dependency(dependency: &Value) -> Result<Dependency> {
    let kind = match dependency["kind"].as_str() {
        None => DependencyKind::Normal,
        Some("dev") => DependencyKind::Dev,
        Some("build") => DependencyKind::Build,
        Some(other) => bail!("there is no kind of dependency `{other}`"),
    };
    Ok(Dependency { name: string(dependency, "name")?, kind })
}

fn array<'a>(value: &'a Value, key: &str) -> Result<&'a Vec<Value>> {
    value[key].as_array().with_context(|| format!("`{key}` is no list"))
}

fn string(value: &Value, key: &str) -> Result<String> {
    Ok(value[key].as_str().with_context(|| format!("`{key}` is no string"))?.to_owned())
}

#[cfg(test)]
impl Package {
    pub(crate) fn named(name: &str) -> Self {
        Self { name: name.to_owned(), dependencies: vec![], features: vec![], benches: vec![] }
    }

    pub(crate) fn with(self, dependency: &str) -> Self {
        self.with_kind(dependency, DependencyKind::Normal)
    }

    pub(crate) fn with_dev(self, dependency: &str) -> Self {
        self.with_kind(dependency, DependencyKind::Dev)
    }

    pub(crate) fn with_build(self, dependency: &str) -> Self {
        self.with_kind(dependency, DependencyKind::Build)
    }

    fn with_kind(mut self, dependency: &str, kind: DependencyKind) -> Self {
        self.dependencies.push(Dependency { name: dependency.to_owned(), kind });
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const METADATA: &str = r#"{ "packages": [ {
        "name": "a",
        "dependencies": [
            { "name": "glam", "kind": null },
            { "name": "fastrand", "kind": "dev" },
            { "name": "naga", "kind": "build" }
        ],
        "features": { "default": ["simd"], "simd": [] },
        "targets": [ { "name": "a", "kind": ["lib"] }, { "name": "toss", "kind": ["bench"] } ]
    } ] }"#;

    #[test]
    fn parse_one_package() {
        let packages = parse(METADATA).unwrap();
        let package = &packages[0];
        assert_eq!(package.name, "a", "name");
        assert_eq!(package.features, ["default", "simd"], "features");
        assert_eq!(package.benches, ["toss"], "benches, without the library");
        let kinds: Vec<(&str, DependencyKind)> =
            package.dependencies.iter().map(|d| (d.name.as_str(), d.kind)).collect();
        let expected = [
            ("glam", DependencyKind::Normal),
            ("fastrand", DependencyKind::Dev),
            ("naga", DependencyKind::Build),
        ];
        assert_eq!(kinds, expected, "dependencies");
    }

    #[test]
    fn packages_of_this_workspace() {
        let packages = packages(root()).unwrap();
        assert!(packages.iter().any(|package| package.name == "xtask"), "xtask is a member");
    }
}
