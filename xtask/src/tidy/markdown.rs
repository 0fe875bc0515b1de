//! Markdown: one sentence a line, so that a difference shows the sentence that changed.
//!
//! The rule finds a line in which a sentence ends and another begins: a mark, a space, a capital.
//! It is a heuristic that would rather miss one than cry wolf: abbreviations, initials and numbers of lists do not end
//! sentences, and headings, tables, code, link texts and formulas are not looked at.
//! A sentence broken over two lines is not found.

use super::text::without_code_spans;
use super::{File, Finding};

/// What may stand before a full stop in the midst of a sentence, beside single letters and `e.g`.
const ABBREVIATIONS: &[&str] = &[
    "al", "approx", "ca", "cf", "ch", "dr", "ed", "eds", "eq", "eqs", "etc", "ex", "fig", "figs",
    "inc", "incl", "jr", "ltd", "mr", "mrs", "ms", "no", "nos", "pp", "prof", "ref", "refs",
    "resp", "sec", "secs", "sect", "st", "tab", "viz", "vol", "vols", "vs",
];

pub(super) fn one_sentence_a_line(file: &File) -> Vec<Finding> {
    let Some(text) = file.text_if("md") else { return Vec::new() };
    let second = |(line, prose): (usize, String)| {
        let message = format!("one sentence a line: break before \"{}\"", second_sentence(&prose)?);
        Some(file.finding_at(line, message))
    };
    prose(text).filter_map(second).collect()
}

/// The lines of prose, reduced to their words.
fn prose(text: &str) -> impl Iterator<Item = (usize, String)> {
    let mut fence = None;
    text.lines().enumerate().filter_map(move |(idx, line)| {
        let line = line.trim_start_matches([' ', '>']);
        let mark = ["```", "~~~"].into_iter().find(|mark| line.starts_with(mark));
        match (fence, mark) {
            (None, Some(_)) => fence = mark,
            (Some(_), _) if fence == mark => fence = None,
            (None, None) if !is_apart(line) => return Some((idx + 1, words_only(line))),
            _ => {}
        }
        None
    })
}

/// Headings, rows of tables, and where a link's name is defined.
fn is_apart(line: &str) -> bool {
    line.starts_with(['#', '|']) || (line.starts_with('[') && line.contains("]: "))
}

/// The line without its code, formulas and links.
fn words_only(line: &str) -> String {
    let plain = without_code_spans(line);
    // A formula is an odd piece between dollars; without a partner, a dollar is money.
    let pieces: Vec<&str> = plain.split('$').collect();
    let plain = if pieces.len() % 2 == 1 {
        pieces.into_iter().step_by(2).collect::<Vec<_>>().join("c")
    } else {
        plain
    };
    without_links(&plain)
}

fn without_links(line: &str) -> String {
    let mut plain = String::new();
    let mut rest = line;
    while let Some((before, from)) = rest.find('[').map(|start| rest.split_at(start)) {
        plain.push_str(before);
        match link_len(from) {
            Some(n_bytes) => {
                plain.push('c');
                rest = &from[n_bytes..];
            }
            None => {
                plain.push('[');
                rest = &from[1..];
            }
        }
    }
    plain + rest
}

/// The length of `[text](target)` or `[text][name]`.
fn link_len(from: &str) -> Option<usize> {
    let text = from.find(']')? + 1;
    let close = match from[text..].chars().next()? {
        '(' => ')',
        '[' => ']',
        _ => return None,
    };
    Some(text + from[text..].find(close)? + 1)
}

/// The first word of the second sentence in the line.
fn second_sentence(line: &str) -> Option<&str> {
    line.match_indices(' ').find_map(|(space, _)| {
        let word = line[space..].split_whitespace().next()?;
        let is_capital = bare(word).starts_with(char::is_uppercase);
        (is_capital && ends_sentence(&line[..space])).then_some(word)
    })
}

fn ends_sentence(before: &str) -> bool {
    let closed = before.trim_end_matches([')', ']', '*', '_', '"', '\'', '”', '’', '»']);
    if closed.ends_with(['!', '?']) {
        return true;
    }
    let Some(sentence) = closed.strip_suffix('.') else { return false };
    // The dots of an ellipsis end nothing.
    if sentence.ends_with('.') {
        return false;
    }
    let word = sentence.rsplit(|c: char| c.is_whitespace()).next().unwrap_or("");
    let is_first = sentence.trim_start().len() == word.len();
    let word = bare(word);
    let is_list_number = is_first && word.bytes().all(|byte| byte.is_ascii_digit());
    !word.is_empty() && !is_list_number && !is_abbreviation(word)
}

fn is_abbreviation(word: &str) -> bool {
    // Initials and `e.g`; the letter of a code span is a word of its own.
    let is_letters = word != "c" && word.split('.').all(|part| part.chars().count() == 1);
    let is_number = word.bytes().all(|byte| byte.is_ascii_digit());
    (is_letters && !is_number) || ABBREVIATIONS.contains(&word.to_lowercase().as_str())
}

/// The word without what opens before it.
fn bare(word: &str) -> &str {
    word.trim_start_matches(['(', '[', '*', '_', '"', '\'', '“', '‘', '«', '§'])
}

#[cfg(test)]
mod tests {
    use super::super::{NONE, lines_found};
    use super::*;

    fn check(line: &str, is_bad: bool) {
        let found = lines_found(one_sentence_a_line, "a.md", line);
        assert_eq!(found, if is_bad { vec![1] } else { NONE.to_vec() }, "line {line:?}");
    }

    #[test]
    fn sentences_two_a_line() {
        check("One ends. Two begins.", true);
        check("Does one end? It does.", true);
        check("It ends! *Two* begins.", true);
        check("- It ends (here.) \"Two\" begins.", true);
        check("> Quoted. Twice.", true);
        check("It takes `a`. Then `b`.", true);
        check("The sum is 2. Then it stops.", true);
        check("1. The first. The second.", true);
    }

    #[test]
    fn sentences_one_a_line() {
        check("One ends.", false);
        check("1. The first", false);
        check("Kernels, e.g. Gaussians, i.e. K. Mueller's, vs. X, see Fig. 2 and eq. (3).", false);
        check("Mueller et al. 1999, Swan et al. In a footnote, vol. IV, pp. XI", false);
        check("Version 1.2 of v0.3.4 in slabsplat.rs is `a. B`.", false);
        check("See [One. Two](a. B) and ![A. B][c. D] and $a. B$.", false);
        check("It takes... Time", false);
    }

    #[test]
    fn sentences_only_in_prose() {
        let text =
            "# A. B\n\n| A. B | C. D |\n\n```rust\nA. B\n~~~\nA. B\n```\n[a]: x \"A. B\"\nA a. B\n";
        assert_eq!(
            lines_found(one_sentence_a_line, "a.md", text),
            NONE,
            "single letters, and code"
        );
        let text = "```\nA b. C\n```\nOne ends. Two begins.\n";
        assert_eq!(lines_found(one_sentence_a_line, "a.md", text), [4], "after the code");
        assert_eq!(
            lines_found(one_sentence_a_line, "a.txt", "One ends. Two begins."),
            NONE,
            "text"
        );
    }
}
