//! Rules for manifests: what a crate is called, and that all crates have the same lints.

use super::{File, Finding};

/// The only crate that may contain unsafe code, and so cannot inherit the lints, which forbid it.
const UNSAFE_CRATE: &str = "slabsplat-ash";

/// What is denied there instead: unsafe code that does not say why it is sound.
const UNSAFE_LINTS: &[(&str, &str)] =
    &[("rust", "unsafe_op_in_unsafe_fn"), ("clippy", "undocumented_unsafe_blocks")];

/// Whoever knows a crate's name knows its directory.
pub(super) fn crate_name(file: &File) -> Vec<Finding> {
    let parts: Vec<&str> = file.path.split('/').collect();
    let (["crates", directory, "Cargo.toml"], Some(text)) = (parts.as_slice(), &file.text) else {
        return Vec::new();
    };
    let name = value(text, "package", "name").unwrap_or("\"\"");
    if name == format!("\"{directory}\"") {
        return Vec::new();
    }
    vec![file.finding(format!("the crate is called {name}, its directory \"{directory}\""))]
}

/// Lints are set once, for all; the one crate that must set its own repeats them.
pub(super) fn lints(files: &[File]) -> Vec<Finding> {
    let workspace = files.iter().find(|file| file.path == "Cargo.toml");
    let workspace = workspace.and_then(|file| file.text.as_deref()).unwrap_or_default();
    files.iter().flat_map(|file| package_lints(file, workspace)).collect()
}

fn package_lints(file: &File, workspace: &str) -> Vec<Finding> {
    let is_manifest = file.path.rsplit('/').next() == Some("Cargo.toml");
    let Some(manifest) = file.text.as_deref().filter(|_| is_manifest) else { return Vec::new() };
    let Some(name) = value(manifest, "package", "name") else { return Vec::new() };
    if value(manifest, "lints", "workspace") == Some("true") {
        return Vec::new();
    }
    if name == format!("\"{UNSAFE_CRATE}\"") {
        return lost_lints(file, manifest, workspace);
    }
    vec![file.finding("must inherit the lints: `[lints]`, then `workspace = true`")]
}

/// The lints that a manifest with tables of its own lacks, or sets otherwise.
fn lost_lints(file: &File, manifest: &str, workspace: &str) -> Vec<Finding> {
    let mut findings = Vec::new();
    for tool in ["rust", "rustdoc", "clippy"] {
        let inherited = entries(workspace, &format!("workspace.lints.{tool}"))
            .filter(|(lint, _)| *lint != "unsafe_code");
        let own = UNSAFE_LINTS.iter().filter(|(of, _)| *of == tool);
        for (lint, level) in inherited.chain(own.map(|(_, lint)| (*lint, "\"deny\""))) {
            if value(manifest, &format!("lints.{tool}"), lint) != Some(level) {
                let message = format!("`[lints.{tool}]` must say `{lint} = {level}`");
                findings.push(file.finding(message));
            }
        }
    }
    findings
}

/// What a manifest sets `key` to in `[section]`, as it stands there.
fn value<'a>(manifest: &'a str, section: &str, key: &str) -> Option<&'a str> {
    entries(manifest, section).find_map(|(name, value)| (name == key).then_some(value))
}

/// The keys of `[section]` and what they are set to, as far as a key fits on a line.
fn entries<'a>(
    manifest: &'a str,
    section: &str,
) -> impl Iterator<Item = (&'a str, &'a str)> + use<'a> {
    let header = format!("[{section}]");
    let lines = manifest.lines().map(str::trim).skip_while(move |line| *line != header).skip(1);
    lines
        .take_while(|line| !line.starts_with('['))
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split_once('='))
        .map(|(name, value)| (name.trim(), value.trim()))
}

#[cfg(test)]
mod tests {
    use super::super::{NONE, lines_found};
    use super::*;

    #[test]
    fn crate_name_is_directory() {
        let manifest = "[package]\nname = \"slabsplat-core\"\n";
        let check = |path: &str| lines_found(crate_name, path, manifest);
        assert_eq!(check("crates/slabsplat-core/Cargo.toml"), NONE, "the same");
        assert_eq!(check("crates/core/Cargo.toml"), [0], "another");
        assert_eq!(check("tests/Cargo.toml"), NONE, "not under crates");
    }

    const WORKSPACE: &str = "[workspace]\n\
        [workspace.lints.rust]\nmissing_docs = \"deny\"\nunsafe_code = \"forbid\"\n\n\
        [workspace.lints.clippy]\nall = { level = \"deny\", priority = -1 }\n# a = 1\n\n\
        [profile.dev]\nopt-level = 1\n";

    fn check_lints(name: &str, tables: &str, expected: &[&str]) {
        let manifest = format!("[package]\nname = \"{name}\"\n{tables}");
        let package = File::new(&format!("crates/{name}/Cargo.toml"), manifest.into_bytes());
        let workspace = File::new("Cargo.toml", WORKSPACE.as_bytes().to_vec());
        let found = lints(&[workspace, package]);
        let found: Vec<&str> = found.iter().map(|finding| finding.message.as_str()).collect();
        assert_eq!(found, expected, "{name} with {tables:?}");
    }

    #[test]
    fn lints_inherited() {
        let missing = ["must inherit the lints: `[lints]`, then `workspace = true`"];
        check_lints("a", "[lints]\nworkspace = true\n", &[]);
        check_lints("a", "[lints.rust]\nmissing_docs = \"deny\"\n", &missing);
        check_lints("a", "[dependencies]\nworkspace = true\n", &missing);
    }

    #[test]
    fn lints_repeated() {
        let rust =
            "[lints.rust]\nmissing_docs = \"deny\"\nunsafe_op_in_unsafe_fn = \"deny\"\na = 1\n";
        let clippy = "[lints.clippy]\nall = { level = \"deny\", priority = -1 }\n\
                      undocumented_unsafe_blocks = \"deny\"\n";
        check_lints(UNSAFE_CRATE, &format!("{rust}{clippy}"), &[]);
        check_lints(UNSAFE_CRATE, "[lints]\nworkspace = true\n", &[]);
    }

    #[test]
    fn lints_lost() {
        let rust = "[lints.rust]\nmissing_docs = \"warn\"\nunsafe_op_in_unsafe_fn = \"deny\"\n";
        let expected = [
            "`[lints.rust]` must say `missing_docs = \"deny\"`",
            "`[lints.clippy]` must say `all = { level = \"deny\", priority = -1 }`",
            "`[lints.clippy]` must say `undocumented_unsafe_blocks = \"deny\"`",
        ];
        check_lints(UNSAFE_CRATE, rust, &expected);
    }

    /// The rule would be content with a workspace that it cannot read.
    #[test]
    fn lints_of_this_workspace_are_read() {
        let manifest =
            std::fs::read_to_string(crate::workspace::root().join("Cargo.toml")).unwrap();
        let level = value(&manifest, "workspace.lints.rust", "unsafe_code");
        assert_eq!(level, Some("\"forbid\""), "unsafe code is forbidden in all other crates");
        assert!(entries(&manifest, "workspace.lints.clippy").count() > 1, "clippy's lints");
    }
}
