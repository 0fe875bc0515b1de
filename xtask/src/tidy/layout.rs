//! Rules for where things lie: what is at the top, how crates are set up, how large pictures and data may be.

use std::collections::BTreeSet;

use super::{File, Finding};

/// What a newcomer sees first, so it grows by agreement only.
const TOP_LEVEL: &[&str] = &[
    ".cargo",
    ".ci",
    ".git",
    ".gitignore",
    "Cargo.lock",
    "Cargo.toml",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "README.md",
    "clippy.toml",
    "crates",
    "docs",
    "rustfmt.toml",
    "shaders",
    "target",
    "tests",
    "xtask",
];

const IMAGES: &[&str] = &["apng", "gif", "jpeg", "jpg", "png", "webp"];

const KIB: usize = 1024;
const MAX_DOCS_IMAGE_BYTES: usize = 512 * KIB;
const MAX_TEST_IMAGE_BYTES: usize = 4 * KIB;
const MAX_BINARY_BYTES: usize = 64 * KIB;

pub(super) fn top_level(files: &[File]) -> Vec<Finding> {
    let entries: BTreeSet<&str> = files.iter().filter_map(|f| f.path.split('/').next()).collect();
    let strangers = entries.into_iter().filter(|entry| !TOP_LEVEL.contains(entry));
    strangers
        .map(|entry| Finding {
            path: entry.to_owned(),
            line: None,
            message: format!(
                "not agreed at the top: move it, or add it to the list in {}",
                file!()
            ),
        })
        .collect()
}

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

/// Lints are set once, for all.
pub(super) fn inherited_lints(file: &File) -> Vec<Finding> {
    let Some(text) = file.text_if("toml").filter(|_| file.path.ends_with("Cargo.toml")) else {
        return Vec::new();
    };
    let is_package = value(text, "package", "name").is_some();
    let inherits = value(text, "lints", "workspace") == Some("true");
    if !is_package || inherits {
        return Vec::new();
    }
    vec![file.finding("must inherit the lints: `[lints]`, then `workspace = true`")]
}

/// A clone is forever as large as its largest version, and a small picture shows one matter.
pub(super) fn binary_size(file: &File) -> Vec<Finding> {
    if file.text.is_some() {
        return Vec::new();
    }
    let extension = file.extension().to_lowercase();
    let is_image = IMAGES.contains(&extension.as_str());
    let is_test_image = is_image && file.path.split('/').any(|part| part == "tests");
    if is_test_image && extension != "png" {
        return vec![file.finding("a test image must be a PNG: it is compared bit by bit")];
    }
    let (kind, max_bytes) = if is_test_image {
        ("test image", MAX_TEST_IMAGE_BYTES)
    } else if is_image && file.path.starts_with("docs/") {
        ("image of the documentation", MAX_DOCS_IMAGE_BYTES)
    } else {
        ("binary file", MAX_BINARY_BYTES)
    };
    if file.n_bytes <= max_bytes {
        return Vec::new();
    }
    let (n_bytes, max_kib) = (file.n_bytes, max_bytes / KIB);
    vec![file.finding(format!("{n_bytes} bytes, a {kind} has at most {max_kib} KiB"))]
}

/// What a manifest sets `key` to in `[section]`, as it stands there.
fn value<'a>(manifest: &'a str, section: &str, key: &str) -> Option<&'a str> {
    let header = format!("[{section}]");
    let lines = manifest.lines().map(str::trim).skip_while(|line| *line != header).skip(1);
    lines
        .take_while(|line| !line.starts_with('['))
        .filter_map(|line| line.split_once('='))
        .find_map(|(name, value)| (name.trim() == key).then_some(value.trim()))
}

#[cfg(test)]
mod tests {
    use super::super::{NONE, lines_found};
    use super::*;

    #[test]
    fn top_level_strangers_once() {
        let paths = ["Cargo.toml", "docs/a.md", "scratch/a", "scratch/b", "notes.txt"];
        let files = paths.map(|path| File::new(path, Vec::new()));
        let found = top_level(&files);
        let found: Vec<&str> = found.iter().map(|finding| finding.path.as_str()).collect();
        assert_eq!(found, ["notes.txt", "scratch"], "a file and a directory");
    }

    #[test]
    fn crate_name_is_directory() {
        let manifest = "[package]\nname = \"slabsplat-core\"\n";
        let check = |path: &str| lines_found(crate_name, path, manifest);
        assert_eq!(check("crates/slabsplat-core/Cargo.toml"), NONE, "the same");
        assert_eq!(check("crates/core/Cargo.toml"), [0], "another");
        assert_eq!(check("tests/Cargo.toml"), NONE, "not under crates");
    }

    #[test]
    fn inherited_lints_missing() {
        let check = |rest: &str| {
            let manifest = format!("[package]\nname = \"a\"\n{rest}");
            lines_found(inherited_lints, "crates/a/Cargo.toml", &manifest)
        };
        assert_eq!(check("[lints]\nworkspace = true\n"), NONE, "inherited");
        assert_eq!(check("[lints.rust]\nunsafe_code = \"deny\"\n"), [0], "set anew");
        assert_eq!(check("[dependencies]\nworkspace = true\n"), [0], "in another section");
        assert_eq!(lines_found(inherited_lints, "Cargo.toml", "[workspace]\n"), NONE, "no package");
    }

    #[test]
    fn binary_size_limits() {
        let check = |path: &str, n_bytes: usize, n_findings: usize| {
            let found = binary_size(&File::new(path, vec![0; n_bytes]));
            assert_eq!(found.len(), n_findings, "{path} of {n_bytes} bytes: {found:?}");
        };
        check("tests/images/a.png", 4 * KIB, 0);
        check("tests/images/a.png", 4 * KIB + 1, 1);
        check("crates/a/tests/a.png", 4 * KIB + 1, 1);
        check("tests/images/a.jpg", 1, 1);
        check("tests/data/a.nii.gz", 64 * KIB, 0);
        check("docs/a.png", 512 * KIB, 0);
        check("docs/a.png", 512 * KIB + 1, 1);
        check("docs/a.nrrd", 64 * KIB + 1, 1);
        check("crates/a/src/a.png", 64 * KIB + 1, 1);
    }
}
