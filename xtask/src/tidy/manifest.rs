//! Rules for manifests: what a crate is called, that all crates have the same lints, and that features are
//! documented.

use toml::{Table, Value};

use super::{File, Finding};

/// The only crates that may contain unsafe code, and so cannot inherit the lints, which forbid it.
/// They repeat all others.
const UNSAFE_CRATES: &[&str] = &["slabsplat-ash", "slabsplat-mpi"];
const UNSAFE_LINT: &str = "unsafe_code";

/// Whoever knows a crate's name knows its directory.
pub(super) fn crate_name(file: &File) -> Vec<Finding> {
    let parts: Vec<&str> = file.path.split('/').collect();
    let (["crates", directory, "Cargo.toml"], Some(name)) = (parts.as_slice(), package(file))
    else {
        return Vec::new();
    };
    if name == *directory {
        return Vec::new();
    }
    vec![file.finding(format!("the crate is called {name}, its directory {directory}"))]
}

/// Of libraries: otherwise docs.rs shows what the default features have, and of nothing which feature it
/// needs.
pub(super) fn docs_rs(file: &File) -> Vec<Finding> {
    let Some(manifest) = manifest(file) else { return Vec::new() };
    let is_published = |package: &Value| package.get("publish") != Some(&Value::Boolean(false));
    let package = manifest.get("package").filter(|package| is_published(package));
    let (Some(package), Some(_)) = (package, manifest.get("features")) else { return Vec::new() };
    if manifest.contains_key("bin") {
        return Vec::new();
    }
    let shown = || package.get("metadata")?.get("docs")?.get("rs")?.get("all-features")?.as_bool();
    if shown() == Some(true) {
        return Vec::new();
    }
    let message = "has features: `all-features = true` in `[package.metadata.docs.rs]` shows them";
    vec![file.finding(message)]
}

/// Workspaces of their own, whose lints are theirs: programs of other people, as it were, and fuzz targets,
/// which `libfuzzer-sys` writes unsafe code into.
const OUTSIDE: &[&str] = &["tests/outside/", "tests/fuzz/"];

/// Lints are set once, for all.
pub(super) fn lints(files: &[File]) -> Vec<Finding> {
    let workspace = files.iter().find(|file| file.path == "Cargo.toml").and_then(manifest);
    let of_workspace =
        workspace.as_ref().and_then(|manifest| manifest.get("workspace")?.get("lints"));
    let Some(Value::Table(of_workspace)) = of_workspace else { return Vec::new() };
    let ours = files.iter().filter(|file| !OUTSIDE.iter().any(|path| file.path.starts_with(path)));
    ours.filter_map(|file| other_lints(file, of_workspace)).collect()
}

fn other_lints(file: &File, of_workspace: &Table) -> Option<Finding> {
    let name = package(file)?;
    let lints = manifest(file)?.remove("lints");
    let (expected, message) = if UNSAFE_CRATES.contains(&&*name) {
        (but_unsafe(of_workspace), "`[lints]` must be the workspace's, but for unsafe code")
    } else {
        let inherited = Table::from_iter([("workspace".to_owned(), Value::Boolean(true))]);
        (inherited, "must inherit the lints: `[lints]`, then `workspace = true`")
    };
    (lints != Some(Value::Table(expected))).then(|| file.finding(message))
}

fn but_unsafe(lints: &Table) -> Table {
    let mut lints = lints.clone();
    if let Some(Value::Table(rust)) = lints.get_mut("rust") {
        rust.remove(UNSAFE_LINT);
    }
    lints
}

/// The name of the package whose manifest this is.
fn package(file: &File) -> Option<String> {
    Some(manifest(file)?.get("package")?.get("name")?.as_str()?.to_owned())
}

/// Cargo complains of one that cannot be read.
fn manifest(file: &File) -> Option<Table> {
    let is_manifest = file.path == "Cargo.toml" || file.path.ends_with("/Cargo.toml");
    file.text.as_deref().filter(|_| is_manifest)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(path: &str, name: &str, rest: &str) -> File {
        File::new(path, format!("[package]\nname = \"{name}\"\n{rest}").into_bytes())
    }

    #[test]
    fn crate_name_is_directory() {
        let check = |path: &str, n_findings: usize| {
            assert_eq!(crate_name(&named(path, "slabsplat-core", "")).len(), n_findings, "{path}");
        };
        check("crates/slabsplat-core/Cargo.toml", 0);
        check("crates/core/Cargo.toml", 1);
        check("tests/Cargo.toml", 0);
    }

    #[test]
    fn docs_rs_shows_features() {
        let check = |rest: &str, n_findings: usize| {
            let found = docs_rs(&named("a/Cargo.toml", "a", rest));
            assert_eq!(found.len(), n_findings, "{rest:?}: {found:?}");
        };
        check("", 0);
        check("publish = false\n[features]\nb = []\n", 0);
        check("[features]\nb = []\n", 1);
        check("[features]\nb = []\n[package.metadata.docs.rs]\nall-features = true\n", 0);
    }

    #[test]
    fn lints_inherited_or_repeated() {
        let workspace = "[workspace.lints.rust]\nmissing_docs = \"deny\"\nunsafe_code = \"forbid\"\n\
            [workspace.lints.clippy]\nall = { level = \"deny\", priority = -1 }\n";
        let check = |name: &str, tables: &str, n_findings: usize| {
            let workspace = File::new("Cargo.toml", workspace.as_bytes().to_vec());
            let found = lints(&[workspace, named("a/Cargo.toml", name, tables)]);
            assert_eq!(found.len(), n_findings, "{name} with {tables:?}: {found:?}");
        };
        let inherited = "[lints]\nworkspace = true\n";
        let repeated = "[lints.rust]\nmissing_docs = \"deny\"\n\
            [lints.clippy]\nall = { level = \"deny\", priority = -1 }\n";
        check("a", inherited, 0);
        check("a", "", 1);
        check("a", "[dependencies]\nworkspace = true\n", 1);
        check("a", repeated, 1);
        UNSAFE_CRATES.iter().for_each(|name| check(name, repeated, 0));
        check(UNSAFE_CRATES[0], "[lints.rust]\nmissing_docs = \"deny\"\n", 1);
    }

    #[test]
    fn lints_of_other_workspaces_are_theirs() {
        let workspace = File::new("Cargo.toml", b"[workspace.lints.rust]\na = \"deny\"\n".to_vec());
        let at = |path: &str| named(path, "a", "");
        let files = [workspace, at("tests/fuzz/Cargo.toml"), at("tests/outside/a/Cargo.toml")];
        assert_eq!(lints(&files), []);
    }

    /// The rule would be content with a workspace that it cannot read.
    #[test]
    fn lints_of_this_workspace_are_read() {
        let path = xtask::workspace::root().join("Cargo.toml");
        let manifest = manifest(&File::new("Cargo.toml", std::fs::read(path).unwrap())).unwrap();
        let lints = &manifest["workspace"]["lints"];
        assert_eq!(lints["rust"][UNSAFE_LINT].as_str(), Some("forbid"), "in all other crates");
        assert!(lints["clippy"].as_table().is_some_and(|lints| 1 < lints.len()), "clippy's");
    }
}
