//! Rules for Rust files.
//!
//! Clippy denies some of this too; here it holds in every crate whatever its settings, and in code that no build compiles.

use super::rust_text::{is_word, split};
use super::{File, Finding};

/// Crates, modules, tests, examples and benchmarks alike.
pub(super) fn header(file: &File) -> Vec<Finding> {
    match file.text_if("rs") {
        Some(text) if !text.starts_with("//!") => {
            vec![
                file.finding_at(
                    1,
                    "must open with `//!`: what this is, why, and what it does not do",
                ),
            ]
        }
        _ => Vec::new(),
    }
}

pub(super) fn unfinished_macro(file: &File) -> Vec<Finding> {
    let Some(text) = file.text_if("rs") else { return Vec::new() };
    let is_bad = |line: &str| {
        ["todo", "unimplemented", "dbg"].into_iter().any(|name| is_followed(line, name, "!"))
    };
    file.bad_lines(
        &split(text).code,
        is_bad,
        "`todo!`, `unimplemented!` and `dbg!` are not for keeps",
    )
}

pub(super) fn ignored_test(file: &File) -> Vec<Finding> {
    let message = "an ignored test hides its failure: assert what happens today, and say why";
    bad_attributes(file, |attribute| sets(attribute, "ignore"), message)
}

pub(super) fn silenced_lint(file: &File) -> Vec<Finding> {
    let message =
        "write `#[expect(lint, reason = \"..\")]`: it is found when it is no longer needed";
    let is_bad = |attribute: &str| {
        sets(attribute, "allow") || (sets(attribute, "expect") && !has_word(attribute, "reason"))
    };
    bad_attributes(file, is_bad, message)
}

fn bad_attributes(file: &File, is_bad: fn(&str) -> bool, message: &str) -> Vec<Finding> {
    let Some(text) = file.text_if("rs") else { return Vec::new() };
    let code = split(text).code;
    let bad = attributes(&code).filter(|(_, attribute)| is_bad(attribute));
    bad.map(|(line, _)| file.finding_at(line, message)).collect()
}

/// What stands between the brackets of each attribute, and the line where it starts.
fn attributes(code: &str) -> impl Iterator<Item = (usize, &str)> {
    code.match_indices('#').filter_map(|(start, _)| {
        let after = code[start + 1..].trim_start();
        let inside = after.strip_prefix('!').unwrap_or(after).trim_start().strip_prefix('[')?;
        let line = code[..start].matches('\n').count() + 1;
        Some((line, until_bracket(inside)))
    })
}

fn until_bracket(inside: &str) -> &str {
    let mut depth = 0_usize;
    for (at, c) in inside.char_indices() {
        match c {
            '[' => depth += 1,
            ']' if depth == 0 => return &inside[..at],
            ']' => depth -= 1,
            _ => {}
        }
    }
    inside
}

/// Whether the attribute is `name`, or sets it under a condition.
fn sets(attribute: &str, name: &str) -> bool {
    let attribute = attribute.trim_start();
    let path = &attribute[..attribute.find(|c| !is_word(c)).unwrap_or(attribute.len())];
    path == name || (path == "cfg_attr" && has_word(attribute, name))
}

fn has_word(text: &str, word: &str) -> bool {
    is_followed(text, word, "")
}

/// Whether `word` stands there, whole, with `next` right behind it.
fn is_followed(text: &str, word: &str, next: &str) -> bool {
    text.match_indices(word).any(|(start, _)| {
        let after = &text[start + word.len()..];
        !text[..start].ends_with(is_word) && !after.starts_with(is_word) && after.starts_with(next)
    })
}

#[cfg(test)]
mod tests {
    use super::super::{NONE, lines_found};
    use super::*;

    #[test]
    fn header_missing() {
        assert_eq!(lines_found(header, "a.rs", "//! A\n"), NONE, "there");
        assert_eq!(lines_found(header, "a.rs", "// A\n"), [1], "a plain comment");
        assert_eq!(lines_found(header, "a.rs", ""), [1], "an empty file");
        assert_eq!(lines_found(header, "a.wgsl", "// A\n"), NONE, "no Rust");
    }

    #[test]
    fn unfinished_macro_in_code() {
        let source =
            "todo!();\na(dbg!(b));\n// todo!()\n\"dbg!\";\nmy_dbg!();\nstd::unimplemented!()\n";
        assert_eq!(lines_found(unfinished_macro, "a.rs", source), [1, 2, 6], "not in comments");
    }

    #[test]
    fn ignored_test_spellings() {
        let source = "#[test]\n#[ignore]\nfn a() {}\n#[ignore = \"slow\"]\n#[cfg_attr(miri, ignore)]\n\
                      // #[ignore]\n#[serde(ignore)]\n";
        assert_eq!(lines_found(ignored_test, "a.rs", source), [2, 4, 5], "attributes");
    }

    #[test]
    fn silenced_lint_spellings() {
        let bad = "#![allow(dead_code)]\n#[allow(\n    clippy::all)]\n#[cfg_attr(test, allow(unused))]\n\
                   #[expect(dead_code)]\n";
        assert_eq!(lines_found(silenced_lint, "a.rs", bad), [1, 2, 4, 5], "allowed or no reason");
        let good = "#[expect(clippy::too_many_lines, reason = \"one [table]\")]\n#[derive(Debug)]\n\
                    // #[allow(x)]\nlet a = b.expect(\"c\")[0];\n#[arg(allow_hyphen_values = true)]\n";
        assert_eq!(lines_found(silenced_lint, "a.rs", good), NONE, "a reason, and no attributes");
    }

    #[test]
    fn attributes_over_lines() {
        let found: Vec<(usize, &str)> = attributes("a\n#[b(c = [1],\n d)]\n#! [e]").collect();
        assert_eq!(found, [(2, "b(c = [1],\n d)"), (4, "e")], "nested brackets, and spaces");
    }
}
