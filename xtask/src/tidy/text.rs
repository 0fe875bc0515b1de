//! Rules for every text file; one is for sources only.

use super::rust_text::split;
use super::{File, Finding};

const MAX_LINES: usize = 1000;

/// Formats whose files may be written as some other program writes them.
const DATA_EXTENSIONS: &[&str] = &["csv", "hdr", "mhd", "nhdr", "nrrd", "svg"];

pub(super) fn too_long(file: &File) -> Vec<Finding> {
    let Some(text) = handwritten(file) else { return Vec::new() };
    let n_lines = text.lines().count();
    if n_lines <= MAX_LINES {
        return Vec::new();
    }
    vec![file.finding(format!("{n_lines} lines, {MAX_LINES} is the cap: split it by subject"))]
}

pub(super) fn trailing_whitespace(file: &File) -> Vec<Finding> {
    let Some(text) = handwritten(file) else { return Vec::new() };
    // A carriage return is another rule's.
    let is_bad = |line: &str| line.trim_end_matches('\r').ends_with([' ', '\t']);
    file.bad_lines(text, is_bad, "trailing whitespace")
}

pub(super) fn carriage_return(file: &File) -> Vec<Finding> {
    let Some(text) = handwritten(file) else { return Vec::new() };
    let findings = file.bad_lines(text, |line| line.contains('\r'), "line ends in CR LF, not LF");
    // All lines of such a file end alike: the first says it.
    findings.into_iter().take(1).collect()
}

pub(super) fn final_newline(file: &File) -> Vec<Finding> {
    match handwritten(file) {
        Some(text) if !text.is_empty() && !text.ends_with('\n') => {
            vec![file.finding("no newline at the end of the file")]
        }
        _ => Vec::new(),
    }
}

/// Rust and shaders look alike in every editor; other formats may need their tabs.
pub(super) fn tab(file: &File) -> Vec<Finding> {
    let Some(text) = file.text_if("rs").or(file.text_if("wgsl")) else { return Vec::new() };
    let message = "tab: indent with spaces, write `\\t` in strings";
    file.bad_lines(text, |line| line.contains('\t'), message)
}

/// Work left over names the issue in which it will be done; quoted in backticks it is only talked about.
pub(super) fn bare_todo(file: &File) -> Vec<Finding> {
    let Some(text) = handwritten(file) else { return Vec::new() };
    let is_bad = |line: &str| has_bare_todo(&without_code_spans(line));
    let message = "work left over must name its issue: `TODO(#12): what is left`";
    if file.extension() == "rs" {
        file.bad_lines(&split(text).comments, is_bad, message)
    } else {
        file.bad_lines(text, is_bad, message)
    }
}

fn has_bare_todo(line: &str) -> bool {
    let words = line.split_inclusive(|c: char| !c.is_alphanumeric() && c != '_');
    let mut start = 0;
    for word in words {
        let end = start + word.len();
        match word.trim_end_matches(|c: char| !c.is_alphanumeric()) {
            "FIXME" | "XXX" => return true,
            "TODO" if !names_issue(&line[start + "TODO".len()..]) => return true,
            _ => start = end,
        }
    }
    false
}

/// Whether this is `(#12): ` and something more.
fn names_issue(rest: &str) -> bool {
    let Some((number, rest)) = rest.strip_prefix("(#").and_then(|rest| rest.split_once("): "))
    else {
        return false;
    };
    !number.is_empty()
        && number.bytes().all(|byte| byte.is_ascii_digit())
        && !rest.trim().is_empty()
}

/// The line with each code span replaced by one letter, which is neither space nor punctuation nor a capital.
pub(super) fn without_code_spans(line: &str) -> String {
    let mut plain = String::new();
    let mut rest = line;
    while let Some((before, from)) = rest.find('`').map(|start| rest.split_at(start)) {
        let fence = &from[..from.len() - from.trim_start_matches('`').len()];
        let inside = &from[fence.len()..];
        plain.push_str(before);
        match inside.find(fence) {
            Some(end) => {
                plain.push('c');
                rest = &inside[end + fence.len()..];
            }
            None => {
                plain.push_str(fence);
                rest = inside;
            }
        }
    }
    plain + rest
}

/// The text of a file that people write: neither a lock file nor data.
fn handwritten(file: &File) -> Option<&str> {
    let is_written = file.path == "Cargo.lock" || DATA_EXTENSIONS.contains(&file.extension());
    file.text.as_deref().filter(|_| !is_written)
}

#[cfg(test)]
mod tests {
    use super::super::{NONE, lines_found};
    use super::*;

    #[test]
    fn too_long_cap() {
        assert_eq!(lines_found(too_long, "a.rs", &"\n".repeat(1000)), NONE, "1000 lines");
        assert_eq!(lines_found(too_long, "a.rs", &"\n".repeat(1001)), [0], "1001 lines");
        assert_eq!(lines_found(too_long, "Cargo.lock", &"\n".repeat(2000)), NONE, "generated");
    }

    #[test]
    fn trailing_whitespace_lines() {
        let found = lines_found(trailing_whitespace, "a.toml", "a = 1\nb = 2 \n\t\nc\n");
        assert_eq!(found, [2, 3], "a space and a tab");
    }

    #[test]
    fn carriage_return_once() {
        assert_eq!(lines_found(carriage_return, "a.md", "a\nb\r\nc\r\n"), [2], "the first line");
        assert_eq!(lines_found(carriage_return, "a.nhdr", "a\r\n"), NONE, "a data file");
    }

    #[test]
    fn tab_anywhere() {
        assert_eq!(lines_found(tab, "a.rs", "a\n\tb\n\"\t\"\n"), [2, 3], "two lines");
        assert_eq!(lines_found(tab, "a.wgsl", "a\n\tb\n"), [2], "a shader");
        assert_eq!(lines_found(tab, "Makefile", "\ta\n"), NONE, "another format");
    }

    #[test]
    fn final_newline_missing() {
        assert_eq!(lines_found(final_newline, "a.rs", "//! A"), [0], "missing");
        assert_eq!(lines_found(final_newline, "a.rs", "//! A\n"), NONE, "there");
        assert_eq!(lines_found(final_newline, "a", ""), NONE, "empty");
    }

    #[test]
    fn bare_todo_spellings() {
        let check = |line: &str, is_bad: bool| {
            let found = lines_found(bare_todo, "a.sh", line);
            assert_eq!(found, if is_bad { vec![1] } else { NONE.to_vec() }, "line {line:?}");
        };
        check("# TODO", true);
        check("# TODO: later", true);
        check("# TODO(me): later", true);
        check("# TODO(#): later", true);
        check("# TODO(#12) later", true);
        check("# TODO(#12): ", true);
        check("# TODO(#12): later", false);
        check("# TODO(#12): later, FIXME", true);
        check("# XXX", true);
        check("# TODOS, XXXL, mXXX", false);
        check("# a bare `TODO` fails", false);
    }

    #[test]
    fn bare_todo_in_rust_comments_only() {
        let found = lines_found(bare_todo, "a.rs", "let a = \"TODO\"; // fine\n// TODO later\n");
        assert_eq!(found, [2], "the string is not a comment");
    }

    #[test]
    fn without_code_spans_pairs() {
        let check = |line: &str, expected: &str| assert_eq!(without_code_spans(line), expected);
        check("a `b. C` d", "a c d");
        check("``a ` b`` d", "c d");
        check("a ` b", "a ` b");
    }
}
