//! Rust source taken apart into code and comments, so that a rule about one is not misled by the other.
//!
//! This is a lexer of the least kind: it knows comments, strings, characters and raw strings, and calls all else code.
//! Both results keep the lines of the source; what belongs elsewhere is blank, and so are the contents of literals.

/// The code of a source and its comments.
pub(super) struct Split {
    pub(super) code: String,
    pub(super) comments: String,
}

pub(super) fn split(source: &str) -> Split {
    let mut split = Split { code: String::new(), comments: String::new() };
    let mut rest = source;
    while !rest.is_empty() {
        let (kind, n_bytes) = token(rest);
        let (text, after) = rest.split_at(n_bytes);
        let blank: String = text.chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect();
        split.code.push_str(if kind == Kind::Code { text } else { &blank });
        split.comments.push_str(if kind == Kind::Comment { text } else { &blank });
        rest = after;
    }
    split
}

#[derive(PartialEq)]
enum Kind {
    Code,
    Comment,
    Literal,
}

/// The kind and the length in bytes of what `rest`, which is not empty, begins with.
fn token(rest: &str) -> (Kind, usize) {
    if rest.starts_with("//") {
        return (Kind::Comment, rest.find('\n').unwrap_or(rest.len()));
    }
    if rest.starts_with("/*") {
        return (Kind::Comment, block_comment(rest));
    }
    if rest.starts_with('"') {
        return (Kind::Literal, string(rest));
    }
    if let Some(n_bytes) = raw_string(rest).or_else(|| character(rest)) {
        return (Kind::Literal, n_bytes);
    }
    // A word is taken whole: the `r` of `for"` starts no raw string.
    let n_word_bytes = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
    let n_first_bytes = rest.chars().next().map_or(0, char::len_utf8);
    (Kind::Code, n_word_bytes.max(n_first_bytes))
}

pub(super) fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn block_comment(rest: &str) -> usize {
    let mut depth = 0_usize;
    let mut at = 0;
    while let Some(offset) = rest[at..].find(['/', '*']) {
        at += offset;
        let step = match rest.get(at..at + 2) {
            Some("/*") => {
                depth += 1;
                2
            }
            Some("*/") => {
                depth -= 1;
                2
            }
            _ => 1,
        };
        at += step;
        if depth == 0 {
            return at;
        }
    }
    rest.len()
}

fn string(rest: &str) -> usize {
    let mut is_escaped = false;
    for (at, c) in rest.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

fn raw_string(rest: &str) -> Option<usize> {
    let after = ["r", "br", "cr"].into_iter().find_map(|prefix| {
        rest.strip_prefix(prefix).filter(|after| after.starts_with(['#', '"']))
    })?;
    let n_hashes = after.len() - after.trim_start_matches('#').len();
    let inside = after[n_hashes..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(n_hashes));
    let n_before = rest.len() - inside.len();
    Some(inside.find(&end).map_or(rest.len(), |at| n_before + at + end.len()))
}

/// A character between quotes; a quote without a partner is a lifetime.
fn character(rest: &str) -> Option<usize> {
    let inside = rest.strip_prefix('\'')?;
    let mut chars = inside.chars();
    let first = chars.next()?;
    if first == '\\' {
        let n_escape = 1 + chars.next()?.len_utf8();
        return inside[n_escape..].find('\'').map(|at| 1 + n_escape + at + 1);
    }
    (chars.next()? == '\'').then_some(1 + first.len_utf8() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(source: &str, code: &str, comments: &str) {
        let split = split(source);
        let squeezed = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(squeezed(&split.code), code, "code of {source:?}");
        assert_eq!(squeezed(&split.comments), comments, "comments of {source:?}");
        let n_lines = source.lines().count();
        assert_eq!(split.code.lines().count(), n_lines, "lines of {source:?}");
    }

    #[test]
    fn split_comments() {
        check("a; // b\nc", "a; c", "// b");
        check("a /* b /* c */ d */ e", "a e", "/* b /* c */ d */");
        check("a / b * c", "a / b * c", "");
        check("a /* b", "a", "/* b");
        check("a /*/ b */ c", "a c", "/*/ b */");
    }

    #[test]
    fn split_strings() {
        check(r#"a("b // \" c", d)"#, "a( , d)", "");
        check("a(r#\"b \" // c\"#, d) // e", "a( , d)", "// e");
        check("a(br\"b\\\", c)", "a( , c)", "");
        check("for\"a\"", "for", "");
        check("let r#type = 1;", "let r#type = 1;", "");
    }

    #[test]
    fn split_characters_and_lifetimes() {
        check("a('\"', '\\'', '\\u{e9}', 'é') // b", "a( , , , )", "// b");
        check("fn a<'a>(b: &'a str) {} // 'c", "fn a<'a>(b: &'a str) {}", "// 'c");
    }
}
