//! Dependency rules: who may use whom, and which crates of others stay where.
//!
//! The rules are the three tables in [`tables`]; the code here only compares manifests with them.
//! Layers hold because this fails when they do not: a backend that could see a file reader would one day call
//! it.
//! Dev-dependencies are free, as tests may compare with anything, but for the crates on top, which would
//! close a circle.

mod modules;
mod tables;

use anyhow::Result;
use std::path::Path;
use tables::{CLOSED, EXTERNALS, LAYERS, Layer, TOP, Users};
use xtask::workspace::{Dependency, DependencyKind, Package};

/// All violations in the workspace at `root`, one line each.
pub(crate) fn check(root: &Path, packages: &[Package]) -> Result<Vec<String>> {
    Ok([violations(packages), modules::check(root)?].concat())
}

fn violations(packages: &[Package]) -> Vec<String> {
    let rules = [unknown_crates, broken_layers, circles, open_closed, misplaced_externals];
    packages
        .iter()
        .flat_map(|package| rules.into_iter().flat_map(move |rule| rule(package)))
        .collect()
}

fn unknown_crates(package: &Package) -> Vec<String> {
    if layer(&package.name).is_some() {
        return Vec::new();
    }
    let name = &package.name;
    vec![format!("`{name}` has no place among the layers: add it to the table in {}", tables::FILE)]
}

fn broken_layers(package: &Package) -> Vec<String> {
    let Some(layer) = layer(&package.name) else { return Vec::new() };
    names_used(package)
        .filter(|name| is_ours(name) && !layer.may_use.contains(name))
        .map(|name| {
            let allowed = listed(layer.may_use);
            forbidden(package, name, &format!("it may use {allowed}, because {}", layer.why))
        })
        .collect()
}

fn circles(package: &Package) -> Vec<String> {
    let Some(layer) = layer(&package.name) else { return Vec::new() };
    let dev = package.dependencies.iter().filter(|d| d.kind == Some(DependencyKind::Dev));
    dev.map(|dependency| dependency.name.as_str())
        .filter(|name| TOP.contains(name) && !layer.may_use.contains(name))
        .map(|name| {
            let why = "even its tests stay below the crates on top; move the test to `tests/`";
            forbidden(package, name, why)
        })
        .collect()
}

fn open_closed(package: &Package) -> Vec<String> {
    let Some(closed) = CLOSED.iter().find(|closed| closed.name == package.name) else {
        return Vec::new();
    };
    let is_free = |dependency: &&Dependency| {
        let is_in = |names: &[&str]| names.contains(&dependency.name.as_str());
        is_in(closed.externals) || dependency.optional && is_in(closed.optional)
    };
    used(package)
        .filter(|dependency| !is_ours(&dependency.name) && !is_free(dependency))
        .map(|Dependency { name, .. }| {
            let allowed = listed(closed.externals);
            let why = format!("of others it may use {allowed}, because {}", closed.why);
            forbidden(package, name, &why)
        })
        .collect()
}

fn misplaced_externals(package: &Package) -> Vec<String> {
    used(package)
        .filter_map(|dependency| {
            let external = EXTERNALS.iter().find(|external| external.name == dependency.name)?;
            Some((external, user(package, dependency)))
        })
        .filter(|(external, user)| !external.users.include(user))
        .map(|(external, user)| {
            let why = format!("{}, because {}", external.users.described(), external.why);
            format!("`{user}` must not depend on `{}`: {why}", external.name)
        })
        .collect()
}

/// Who uses the dependency, as the tables call it.
fn user(package: &Package, dependency: &Dependency) -> String {
    match dependency.kind {
        Some(DependencyKind::Build) => format!("{}/build.rs", package.name),
        Some(DependencyKind::Dev) | None => package.name.clone(),
    }
}

impl Users {
    fn include(&self, name: &str) -> bool {
        match self {
            Self::Only(users) => users.contains(&name),
            Self::AllBut(others) => !others.contains(&name),
        }
    }

    fn described(&self) -> String {
        match self {
            Self::Only(users) => format!("it belongs to {} only", listed(users)),
            Self::AllBut(others) => format!("it is kept out of {}", listed(others)),
        }
    }
}

/// What the package is built with; its tests may use more.
fn used(package: &Package) -> impl Iterator<Item = &Dependency> {
    package.dependencies.iter().filter(|dependency| dependency.kind != Some(DependencyKind::Dev))
}

fn names_used(package: &Package) -> impl Iterator<Item = &str> {
    used(package).map(|dependency| dependency.name.as_str())
}

fn layer(name: &str) -> Option<&'static Layer> {
    LAYERS.iter().find(|layer| layer.name == name)
}

/// A prefix, not the table: a crate that is not in it yet must not pass as somebody else's.
fn is_ours(name: &str) -> bool {
    name == "xtask" || name.starts_with("slabsplat")
}

fn listed(names: &[&str]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn forbidden(package: &Package, dependency: &str, why: &str) -> String {
    format!("`{}` must not depend on `{dependency}`: {why}", package.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use xtask::workspace::Workspace;

    /// What is found of a package that `uses` others, as `glam serde? dev:fastrand build:naga`: nothing, or
    /// one line each that starts as expected.
    fn check_one(name: &str, uses: &str, expected: &[&str]) {
        let dependency = |word: &str| {
            let (kind, name) = match word.split_once(':') {
                Some(("dev", name)) => (Some(DependencyKind::Dev), name),
                Some((_, name)) => (Some(DependencyKind::Build), name),
                None => (None, word),
            };
            let (name, optional) =
                name.strip_suffix('?').map_or((name, false), |name| (name, true));
            Dependency { name: name.to_owned(), kind, optional }
        };
        let dependencies = uses.split_whitespace().map(dependency).collect();
        let package = Package { name: name.to_owned(), dependencies, ..Package::default() };
        let found = violations(&[package]);
        assert_eq!(found.len(), expected.len(), "one finding each: {found:?}");
        for (found, expected) in found.iter().zip(expected) {
            let start = format!("`{expected}");
            assert!(found.starts_with(&start), "{found:?} starts with {start:?}");
        }
    }

    #[test]
    fn dependencies_of_this_workspace() {
        let violations = violations(&Workspace::read().unwrap().packages);
        assert!(violations.is_empty(), "{}", violations.join("\n"));
    }

    #[test]
    fn unknown_crate() {
        check_one("slabsplat-vr", "", &["slabsplat-vr` has no place among the layers: add it to"]);
    }

    #[test]
    fn layer_downwards() {
        check_one("slabsplat-cpu", "slabsplat-traverse", &[]);
        check_one("slabsplat-cli", "slabsplat clap", &[]);
    }

    #[test]
    fn layer_upwards() {
        let cases = [
            (
                "slabsplat-backend",
                "slabsplat-traverse",
                "it may use `slabsplat-core`, `slabsplat-kernel`, because the contract",
            ),
            ("slabsplat-core", "slabsplat-new", "it may use none"),
            ("slabsplat-core", "xtask", "it may use none"),
            (
                "slabsplat-wgpu",
                "slabsplat-ash",
                "it may use `slabsplat-gpu`, `slabsplat-shaders`, because it executes",
            ),
            ("slabsplat-cli", "slabsplat-io", "it may use `slabsplat`"),
            ("xtask", "slabsplat-bench", "it may use none"),
        ];
        for (name, uses, why) in cases {
            let expected = format!("{name}` must not depend on `{uses}`: {why}");
            check_one(name, uses, &[&expected]);
        }
        let expected = "slabsplat-shaders` must not depend on `slabsplat-core`: it may use none";
        check_one("slabsplat-shaders", "build:slabsplat-core", &[expected]);
    }

    #[test]
    fn dev_dependency_circle() {
        check_one("slabsplat-kernel", "dev:slabsplat-io", &[]);
        let expected = "slabsplat-kernel` must not depend on `slabsplat`: even its tests";
        check_one("slabsplat-kernel", "dev:slabsplat", &[expected]);
        check_one("slabsplat-tests", "dev:slabsplat-cli", &[]);
    }

    #[test]
    fn closed_crates() {
        let expected = "slabsplat-core` must not depend on `libm`: of others it may use \
             `bytemuck`, `glam`, `thiserror`";
        check_one("slabsplat-core", "libm", &[expected]);
        check_one("slabsplat-kernel", "libm", &[]);
        check_one("slabsplat-core", "dev:fastrand", &[]);
        check_one("slabsplat-core", "serde? ndarray?", &[]);
        check_one("slabsplat-core", "serde", &["slabsplat-core` must not depend on `serde`"]);
        check_one("slabsplat-core", "libm?", &[expected]);
    }

    #[test]
    fn externals_only_where_they_belong() {
        let cases = [
            ("slabsplat", "toml", "it belongs to `slabsplat-core`, `slabsplat-io`"),
            ("slabsplat-backend", "rayon", "it is kept out of"),
            ("slabsplat-io", "anyhow", "it belongs to"),
            ("slabsplat-io", "indicatif", "it belongs to"),
            ("slabsplat-shaders", "naga", "it belongs to `slabsplat-shaders/build.rs` only"),
        ];
        for (name, uses, why) in cases {
            check_one(name, uses, &[&format!("{name}` must not depend on `{uses}`: {why}")]);
        }
    }

    #[test]
    fn externals_of_build_scripts() {
        check_one("slabsplat-shaders", "build:naga build:anyhow", &[]);
        for name in ["naga", "wgpu"] {
            let expected =
                format!("slabsplat-wgpu/build.rs` must not depend on `{name}`: it belongs");
            check_one("slabsplat-wgpu", &format!("build:{name}"), &[&expected]);
        }
    }

    /// A row that names a crate wrongly would forbid or allow nothing.
    #[test]
    fn tables_name_crates_of_this_workspace() {
        let packages = Workspace::read().unwrap().packages;
        let rows = LAYERS.iter().flat_map(|layer| layer.may_use.iter().chain([&layer.name]));
        let users = EXTERNALS.iter().flat_map(|external| match external.users {
            Users::Only(users) => users,
            Users::AllBut(others) => others,
        });
        let closed = CLOSED.iter().map(|closed| &closed.name);
        for name in rows.chain(users).chain(closed).chain(TOP) {
            let name = name.trim_end_matches("/build.rs");
            assert!(packages.iter().any(|package| package.name == name), "`{name}` is a member");
        }
    }
}
