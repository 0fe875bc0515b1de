//! What comments and documents cite must be there: files of the repository, and sections of the model.
//! Who reads the documentation of a crate has no repository: there a document is cited by its address.

use std::collections::BTreeSet;

use super::{File, Finding};

const MODEL: &str = "docs/model.md";

/// Where documents are in the network.
const ADDRESS: &str = "https://github.com/slabsplat/slabsplat/blob/main/";

/// Where a path begins that means a file of the repository.
const ROOTS: &[&str] = &["crates/", "docs/", "shaders/", "tests/", "xtask/"];

/// Formats in which something is cited.
const EXTENSIONS: &[&str] = &["md", "rs", "toml", "wgsl"];

pub(super) fn dangling(files: &[File]) -> Vec<Finding> {
    let there = Citable::of(files);
    // The tests of rules cite what is not there.
    let may_cite = |file: &&File| {
        EXTENSIONS.contains(&file.extension()) && !file.path.starts_with("xtask/src/tidy/")
    };
    files.iter().filter(may_cite).flat_map(|file| there.dangling_in(file)).collect()
}

/// Documents that the documentation of a crate cites by a path.
pub(super) fn unpublished(file: &File) -> Vec<Finding> {
    let is_source = file.path.starts_with("crates/") && file.path.contains("/src/");
    let Some(text) = file.text_if("rs").filter(|_| is_source) else { return Vec::new() };
    let is_bad = |line: &str| {
        let line = line.trim_start();
        (line.starts_with("///") || line.starts_with("//!")) && line.contains("`docs/")
    };
    file.bad_lines(text, is_bad, "dead on docs.rs: cite a document by its address")
}

/// What may be cited.
struct Citable<'a> {
    /// Files and folders, the latter without a slash at the end.
    paths: BTreeSet<&'a str>,
    /// Numbers of the model's sections.
    sections: BTreeSet<&'a str>,
}

impl<'a> Citable<'a> {
    fn of(files: &'a [File]) -> Self {
        let folders = |path: &'a str| path.match_indices('/').map(move |(end, _)| &path[..end]);
        let paths = files.iter().flat_map(|file| folders(&file.path).chain([&file.path[..]]));
        let model =
            files.iter().find(|file| file.path == MODEL).and_then(|file| file.text.as_deref());
        let number = |line: &'a str| Some(leading_digits(line.strip_prefix("## §")?));
        let sections = model.unwrap_or_default().lines().filter_map(number).collect();
        Self { paths: paths.collect(), sections }
    }

    fn dangling_in(&self, file: &File) -> Vec<Finding> {
        let mut findings = Vec::new();
        for (idx, line) in file.text.as_deref().unwrap_or_default().lines().enumerate() {
            let paths = cited_paths(line)
                .chain(cited_addresses(line))
                .filter(|path| !self.paths.contains(path));
            findings
                .extend(paths.map(|path| file.finding_at(idx + 1, format!("there is no {path}"))));
            let sections = cited_sections(line).filter(|section| !self.sections.contains(section));
            let message = |section: &str| format!("{MODEL} has no §{section}");
            findings.extend(sections.map(|section| file.finding_at(idx + 1, message(section))));
        }
        findings
    }
}

/// Code spans of a line that are paths in the repository.
fn cited_paths(line: &str) -> impl Iterator<Item = &str> {
    let is_path = |span: &&str| {
        ROOTS.iter().any(|root| span.starts_with(root))
            && span.bytes().all(|b| b.is_ascii_alphanumeric() || b"/._-".contains(&b))
    };
    line.split('`').skip(1).step_by(2).filter(is_path).map(|path| path.trim_end_matches('/'))
}

/// Files of the repository that a line cites by their addresses.
fn cited_addresses(line: &str) -> impl Iterator<Item = &str> {
    let end = |address: &str| address.find([')', '#', '>', ' ']).unwrap_or(address.len());
    line.split(ADDRESS).skip(1).map(move |address| &address[..end(address)])
}

/// The number of every `model §n`, and both numbers of `model §§m–n` or `model §§m, n`.
fn cited_sections(line: &str) -> impl Iterator<Item = &str> {
    let cited = |after| -> [&str; 2] {
        let Some(several) = str::strip_prefix(after, '§') else {
            return [leading_digits(after), ""];
        };
        let first = leading_digits(several);
        let last = several[first.len()..].trim_start_matches(['–', ',', ' ']);
        [first, leading_digits(last)]
    };
    line.split("odel §").skip(1).flat_map(cited).filter(|section| !section.is_empty())
}

fn leading_digits(text: &str) -> &str {
    &text[..text.bytes().take_while(u8::is_ascii_digit).count()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines_found(path: &str, content: &str) -> Vec<usize> {
        let text = |path: &str, content: &str| File::new(path, content.as_bytes().to_vec());
        let files = [
            text(MODEL, "# Model\n\n## §1 Space\n\n### §7 not a section\n\n## §12 Last\n"),
            text("crates/a/src/lib.rs", "//! A.\n"),
            text(path, content),
        ];
        dangling(&files).iter().filter_map(|finding| finding.line).collect()
    }

    #[test]
    fn cited_paths_are_there() {
        let content = "`docs/model.md` and `crates/a/`, `crates/a/src`\n`crates/a/src/gone.rs`\n\
            `docs/gone/`, not code: docs/gone, or `crates/<name>`, `cargo docs/gone`\n";
        assert_eq!(lines_found("docs/b.md", content), [2, 3]);
        assert_eq!(lines_found("crates/a/b.rs", "//! `docs/gone.md`\n"), [1]);
        assert!(lines_found("docs/b.txt", content).is_empty());
    }

    #[test]
    fn cited_addresses_are_there() {
        let content = format!(
            "//! [a]({ADDRESS}docs/model.md#1-space) and <{ADDRESS}docs/model.md>\n\
             //! [b]: {ADDRESS}docs/gone.md\n//! [c]({ADDRESS}docs/gone.md), [d]({ADDRESS}crates/a/src)\n"
        );
        assert_eq!(lines_found("crates/a/b.rs", &content), [2, 3]);
    }

    #[test]
    fn unpublished_documents() {
        let content = "//! As `docs/model.md` says.\n// `docs/model.md`\n/// `docs/`: no\n";
        let lines = |path: &str| {
            let findings = unpublished(&File::new(path, content.as_bytes().to_vec()));
            findings.iter().filter_map(|finding| finding.line).collect::<Vec<_>>()
        };
        assert_eq!(lines("crates/a/src/b.rs"), [1, 3]);
        assert!(lines("crates/a/tests/b.rs").is_empty());
        assert!(lines("xtask/src/b.rs").is_empty());
    }

    #[test]
    fn cited_sections_are_there() {
        let content = "//! Model §1, model §12.\n//! model §2\n//! model §§1–3\n//! (paper §7)\n\
            //! (model §7)\n//! model §§1, 12; model §1, 5 of them; model §n\n";
        assert_eq!(lines_found("crates/a/b.rs", content), [2, 3, 5]);
    }
}
