//! Dependency rules: who may use whom, and which crates of others stay where.
//!
//! The rules are the three tables in [`tables`]; the code here only compares manifests with them.
//! Layers hold because this fails when they do not: a backend that could see a file reader would one day call it.
//! Dev-dependencies are free, as tests may compare with anything, but for the crates on top, which would close a circle.

mod tables;

use crate::workspace::{Dependency, DependencyKind, Package};
use tables::{CLOSED, EXTERNALS, LAYERS, Layer, TOP, Users};

/// All violations, one line each.
pub(crate) fn check(packages: &[Package]) -> Vec<String> {
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
    let dev = package.dependencies.iter().filter(|d| d.kind == DependencyKind::Dev);
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
    names_used(package)
        .filter(|name| !is_ours(name) && !closed.externals.contains(name))
        .map(|name| {
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
        DependencyKind::Build => format!("{}/build.rs", package.name),
        DependencyKind::Normal | DependencyKind::Dev => package.name.clone(),
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
    package.dependencies.iter().filter(|dependency| dependency.kind != DependencyKind::Dev)
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
    use crate::workspace;

    fn check_one(package: Package, expected: &[&str]) {
        let found = check(&[package]);
        assert_eq!(found.len(), expected.len(), "one finding each: {found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.starts_with(expected), "{found:?} starts with {expected:?}");
        }
    }

    #[test]
    fn dependencies_of_this_workspace() {
        let violations = check(&workspace::packages(workspace::root()).unwrap());
        assert!(violations.is_empty(), "{}", violations.join("\n"));
    }

    #[test]
    fn unknown_crate() {
        let expected = "`slabsplat-vr` has no place among the layers: add it to the table";
        check_one(Package::named("slabsplat-vr"), &[expected]);
    }

    #[test]
    fn layer_downwards() {
        check_one(Package::named("slabsplat-cpu").with("slabsplat-traverse"), &[]);
        check_one(Package::named("slabsplat-cli").with("slabsplat").with("clap"), &[]);
    }

    #[test]
    fn layer_upwards() {
        let expected = "`slabsplat-backend` must not depend on `slabsplat-traverse`: it may use \
             `slabsplat-core`, `slabsplat-kernel`, because the contract";
        check_one(Package::named("slabsplat-backend").with("slabsplat-traverse"), &[expected]);
        let expected = "`slabsplat-core` must not depend on `slabsplat-new`: it may use none";
        let other = "`slabsplat-core` must not depend on `xtask`";
        check_one(
            Package::named("slabsplat-core").with("slabsplat-new").with("xtask"),
            &[expected, other],
        );
        let expected = "`slabsplat-wgpu` must not depend on `slabsplat-ash`: it may use \
             `slabsplat-gpu`, `slabsplat-shaders`, because it executes";
        check_one(Package::named("slabsplat-wgpu").with("slabsplat-ash"), &[expected]);
        let expected = "`slabsplat-shaders` must not depend on `slabsplat-core`: it may use none";
        check_one(Package::named("slabsplat-shaders").with_build("slabsplat-core"), &[expected]);
        let expected = "`slabsplat-cli` must not depend on `slabsplat-io`: it may use `slabsplat`";
        check_one(Package::named("slabsplat-cli").with("slabsplat-io"), &[expected]);
    }

    #[test]
    fn dev_dependency_circle() {
        check_one(Package::named("slabsplat-kernel").with_dev("slabsplat-io"), &[]);
        let expected = "`slabsplat-kernel` must not depend on `slabsplat`: even its tests";
        check_one(Package::named("slabsplat-kernel").with_dev("slabsplat"), &[expected]);
        check_one(Package::named("slabsplat-tests").with_dev("slabsplat-cli"), &[]);
    }

    #[test]
    fn closed_crates() {
        let expected = "`slabsplat-core` must not depend on `libm`: of others it may use \
             `bytemuck`, `glam`, `thiserror`";
        check_one(Package::named("slabsplat-core").with("libm"), &[expected]);
        check_one(Package::named("slabsplat-kernel").with("libm"), &[]);
        check_one(Package::named("slabsplat-core").with_dev("fastrand"), &[]);
    }

    #[test]
    fn externals_only_where_they_belong() {
        let expected = "`slabsplat` must not depend on `toml`: it belongs to `slabsplat-io` only";
        check_one(Package::named("slabsplat").with("toml"), &[expected]);
        let expected = "`slabsplat-backend` must not depend on `rayon`: it is kept out of";
        check_one(Package::named("slabsplat-backend").with("rayon"), &[expected]);
        let expected = "`slabsplat-io` must not depend on `anyhow`: it belongs to";
        check_one(Package::named("slabsplat-io").with("anyhow"), &[expected]);
        let expected = "`slabsplat-io` must not depend on `indicatif`: it belongs to";
        check_one(Package::named("slabsplat-io").with("indicatif"), &[expected]);
    }
    #[test]
    fn externals_of_build_scripts() {
        check_one(Package::named("slabsplat-shaders").with_build("naga").with_build("anyhow"), &[]);
        let expected = "`slabsplat-shaders` must not depend on `naga`: it belongs to \
             `slabsplat-shaders/build.rs` only";
        check_one(Package::named("slabsplat-shaders").with("naga"), &[expected]);
        let expected = "`slabsplat-wgpu/build.rs` must not depend on `naga`: it belongs to";
        check_one(Package::named("slabsplat-wgpu").with_build("naga"), &[expected]);
        let expected = "`slabsplat-wgpu/build.rs` must not depend on `wgpu`: it belongs to";
        check_one(Package::named("slabsplat-wgpu").with_build("wgpu"), &[expected]);
    }

    /// A row that names a crate wrongly would forbid or allow nothing.
    #[test]
    fn tables_name_crates_of_this_workspace() {
        let packages = workspace::packages(workspace::root()).unwrap();
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
