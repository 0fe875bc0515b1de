//! Rules for where things lie: what is at the top, and how large pictures and data may be.

use std::collections::BTreeSet;

use super::{File, Finding};

/// What a newcomer sees first, so it grows by agreement only.
const TOP_LEVEL: &[&str] = &[
    ".cargo",
    ".ci",
    ".git",
    ".gitignore",
    "CONTRIBUTING.md",
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

#[cfg(test)]
mod tests {
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
