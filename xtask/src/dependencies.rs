//! Dependency rules: who may use whom, and which crates of others stay where.
//!
//! The rules are the three tables below; the code only compares manifests with them.
//! Layers hold because this fails when they do not: a backend that could see a file reader would one day call it.
//! Dev-dependencies are free, as tests may compare with anything, but for the crates on top, which would close a circle.

use crate::workspace::Package;

/// A crate of the workspace, and the crates of the workspace that it may use.
struct Layer {
    name: &'static str,
    may_use: &'static [&'static str],
    why: &'static str,
}

const LAYERS: &[Layer] = &[
    Layer { name: "slabsplat-core", may_use: &[], why: "all others stand on it" },
    Layer {
        name: "slabsplat-kernel",
        may_use: &["slabsplat-core"],
        why: "kernels and their tables know nothing of volumes on disk, of order, or of who draws",
    },
    Layer {
        name: "slabsplat-io",
        may_use: &["slabsplat-core"],
        why: "readers and writers make and take core's types, and never render",
    },
    Layer {
        name: "slabsplat-traverse",
        may_use: &["slabsplat-core", "slabsplat-kernel"],
        why: "the order of voxels must not depend on who draws them",
    },
    Layer {
        name: "slabsplat-backend",
        may_use: &["slabsplat-core", "slabsplat-kernel"],
        why: "the contract knows no backend, no file and no traversal",
    },
    Layer {
        name: "slabsplat-cpu",
        may_use: &["slabsplat-core", "slabsplat-kernel", "slabsplat-traverse", "slabsplat-backend"],
        why: "a backend executes a plan: it reads no file and sees no other backend",
    },
    Layer {
        name: "slabsplat",
        may_use: &[
            "slabsplat-core",
            "slabsplat-kernel",
            "slabsplat-io",
            "slabsplat-traverse",
            "slabsplat-backend",
            "slabsplat-cpu",
        ],
        why: "the facade joins the libraries, and programs stand on top of it",
    },
    Layer {
        name: "slabsplat-cli",
        may_use: &["slabsplat"],
        why: "what the program can do, any downstream crate must be able to do",
    },
    Layer {
        name: "slabsplat-tests",
        may_use: &[
            "slabsplat-core",
            "slabsplat-kernel",
            "slabsplat-io",
            "slabsplat-traverse",
            "slabsplat-backend",
            "slabsplat-cpu",
            "slabsplat",
            "slabsplat-cli",
        ],
        why: "tests look everywhere but into the tooling",
    },
    Layer { name: "xtask", may_use: &[], why: "lint must run while the renderer does not build" },
];

/// Crates that even a dev-dependency reaches only from above.
const TOP: &[&str] = &["slabsplat", "slabsplat-cli"];

/// The only crates of others that a crate may use.
struct Closed {
    name: &'static str,
    externals: &'static [&'static str],
    why: &'static str,
}

const CLOSED: &[Closed] = &[
    Closed {
        name: "slabsplat-core",
        externals: &["bytemuck", "glam", "thiserror"],
        why: "what core uses, everybody compiles, on wasm32 too",
    },
    Closed {
        name: "slabsplat-kernel",
        externals: &["bytemuck", "glam", "libm", "thiserror"],
        why: "tables must be the same bits on every machine, so it takes its functions from libm",
    },
];

/// A crate of others, and who may use it.
struct External {
    name: &'static str,
    users: Users,
    why: &'static str,
}

enum Users {
    Only(&'static [&'static str]),
    AllBut(&'static [&'static str]),
}

const EXTERNALS: &[External] = &[
    External {
        name: "rayon",
        users: Users::AllBut(&["slabsplat-core", "slabsplat-kernel", "slabsplat-backend"]),
        why: "threads belong to those who execute, and these must build where there are none",
    },
    External { name: "image", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "serde", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "toml", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "nifti", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "flate2", users: Users::Only(&["slabsplat-io"]), why: CODECS },
    External { name: "clap", users: Users::Only(&["slabsplat-cli"]), why: TERMINAL },
    External { name: "indicatif", users: Users::Only(&["slabsplat-cli"]), why: TERMINAL },
    External {
        name: "anyhow",
        users: Users::Only(&["slabsplat-cli", "slabsplat-tests", "xtask"]),
        why: "a library's errors are an enum that the caller can act on",
    },
];

const CODECS: &str = "file formats stay in one crate";
const TERMINAL: &str = "only the program talks to a terminal";

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
    vec![format!("`{name}` has no place among the layers: add it to the table in {}", file!())]
}

fn broken_layers(package: &Package) -> Vec<String> {
    let Some(layer) = layer(&package.name) else { return Vec::new() };
    used(package)
        .filter(|name| is_ours(name) && !layer.may_use.contains(name))
        .map(|name| {
            let allowed = listed(layer.may_use);
            forbidden(package, name, &format!("it may use {allowed}, because {}", layer.why))
        })
        .collect()
}

fn circles(package: &Package) -> Vec<String> {
    let Some(layer) = layer(&package.name) else { return Vec::new() };
    let dev = package.dependencies.iter().filter(|dependency| dependency.is_dev);
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
    used(package)
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
        .filter_map(|name| EXTERNALS.iter().find(|external| external.name == name))
        .filter(|external| !external.users.include(&package.name))
        .map(|external| {
            let why = format!("{}, because {}", external.users.described(), external.why);
            forbidden(package, external.name, &why)
        })
        .collect()
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

/// What the package's own code is built with.
fn used(package: &Package) -> impl Iterator<Item = &str> {
    package.dependencies.iter().filter(|dependency| !dependency.is_dev).map(|d| d.name.as_str())
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
}
