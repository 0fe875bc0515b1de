//! Tidy: the rules about files that neither the compiler nor rustfmt nor clippy knows, as far as a reviewer
//! overlooks what they find: files too large or in the wrong place, citations of what is gone, lints that are
//! not inherited.
//!
//! A rule is a function from one file to its findings, and [`FILE_RULES`] lists them all; a rule about the
//! tree as a whole is called in [`findings`].
//! To add one, write it with a test on a bad example, and add it to the list.
//!
//! Rules judge lines, not syntax trees: what needs a parser is clippy's business.

mod citations;
mod layout;
mod manifest;
mod text;

use std::fmt;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use xtask::process::output;

/// A file that belongs to the repository.
pub(crate) struct File {
    /// From the root, with `/` between the parts.
    path: String,
    n_bytes: usize,
    /// What the file says, unless it is binary.
    text: Option<String>,
}

/// A broken rule, and where.
#[derive(Debug, PartialEq)]
pub(crate) struct Finding {
    path: String,
    line: Option<usize>,
    message: String,
}

type FileRule = fn(&File) -> Vec<Finding>;

const FILE_RULES: &[FileRule] = &[
    text::too_long,
    text::untidy_end,
    text::header,
    text::wide_shader,
    text::wide_comment,
    text::bare_todo,
    manifest::crate_name,
    manifest::docs_rs,
    citations::unpublished,
    layout::binary_size,
];

/// All findings in the repository at `root`, by path.
pub(crate) fn check(root: &Path) -> Result<Vec<Finding>> {
    Ok(findings(&files(root)?))
}

fn findings(files: &[File]) -> Vec<Finding> {
    let mut findings = layout::top_level(files);
    findings.extend(manifest::lints(files));
    findings.extend(citations::dangling(files));
    for file in files {
        findings.extend(FILE_RULES.iter().flat_map(|rule| rule(file)));
    }
    findings.sort_by(|a, b| (&a.path, a.line).cmp(&(&b.path, b.line)));
    findings
}

/// What git tracks, or would track if it were added.
fn files(root: &Path) -> Result<Vec<File>> {
    let mut git = Command::new("git");
    git.arg("-C").arg(root).args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]);
    let listing = output(&mut git).context("tidy takes its files from git")?;
    let mut paths: Vec<&str> = listing.split_terminator('\0').collect();
    paths.sort_unstable();
    // During a merge, git lists a file once for each side.
    paths.dedup();
    // A tracked file may be deleted, a link point elsewhere, and a submodule is a directory.
    let is_plain =
        |path: &&str| fs::symlink_metadata(root.join(path)).is_ok_and(|file| file.is_file());
    let read = |path| {
        let bytes = fs::read(root.join(path)).with_context(|| format!("cannot read {path}"))?;
        Ok(File::new(path, bytes))
    };
    paths.into_iter().filter(is_plain).map(read).collect()
}

impl File {
    fn new(path: &str, bytes: Vec<u8>) -> Self {
        let n_bytes = bytes.len();
        // Text without a NUL: the test that git uses, and then what all our tools expect of text.
        let text = String::from_utf8(bytes).ok().filter(|text| !text.contains('\0'));
        Self { path: path.to_owned(), n_bytes, text }
    }

    /// The part after the last dot of the file's name, or nothing.
    fn extension(&self) -> &str {
        Path::new(&self.path).extension().and_then(|extension| extension.to_str()).unwrap_or("")
    }

    /// The text, if this is a text with that extension.
    fn text_if(&self, extension: &str) -> Option<&str> {
        self.text.as_deref().filter(|_| self.extension() == extension)
    }

    fn finding(&self, message: impl Into<String>) -> Finding {
        Finding { path: self.path.clone(), line: None, message: message.into() }
    }

    /// `line` counts from 1.
    fn finding_at(&self, line: usize, message: impl Into<String>) -> Finding {
        Finding { line: Some(line), ..self.finding(message) }
    }

    /// One finding for each line that `is_bad`.
    fn bad_lines(&self, text: &str, is_bad: fn(&str) -> bool, message: &str) -> Vec<Finding> {
        let lines = text.split('\n').enumerate().filter(|(_, line)| is_bad(line));
        lines.map(|(idx, _)| self.finding_at(idx + 1, message)).collect()
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.path, self.message),
            None => write!(f, "{}: {}", self.path, self.message),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use xtask::workspace;

    #[test]
    fn tidy_this_repository() {
        let findings = check(workspace::root()).unwrap();
        let lines: Vec<String> = findings.iter().map(ToString::to_string).collect();
        assert!(lines.is_empty(), "{} findings:\n{}", lines.len(), lines.join("\n"));
    }

    #[test]
    fn files_are_ours_and_sorted() {
        let files = files(workspace::root()).unwrap();
        let paths: Vec<&str> = files.iter().map(|file| file.path.as_str()).collect();
        assert!(paths.contains(&"xtask/src/main.rs"), "our own source is listed");
        assert!(paths.is_sorted(), "by path");
        assert!(!paths.iter().any(|path| path.starts_with("target/")), "no build products");
    }

    #[test]
    fn findings_by_path_and_line() {
        let files = [
            File::new("xtask/b.rs", b"//! B\n \n".to_vec()),
            File::new("notes.txt", b"one\ntwo \n".to_vec()),
        ];
        let lines: Vec<String> = findings(&files).iter().map(ToString::to_string).collect();
        assert_eq!(lines.len(), 3, "{lines:?}");
        assert!(lines[0].starts_with("notes.txt: "), "the tree's finding: {lines:?}");
        assert!(lines[1].starts_with("notes.txt:2: "), "{lines:?}");
        assert!(lines[2].starts_with("xtask/b.rs:2: "), "{lines:?}");
    }

    #[test]
    fn file_binary_has_no_text() {
        assert_eq!(File::new("a", b"a\0b".to_vec()).text, None, "a NUL");
        assert_eq!(File::new("a", vec![0xff, 0xfe]).text, None, "no UTF-8");
        assert_eq!(File::new("a.rs", b"a".to_vec()).text_if("rs"), Some("a"), "text");
    }
}
