//! What a scene file does wrong, in one line that a person can act on: the line of the file, and
//! for a misspelt key, the key that was meant.

use std::path::Path;

use crate::IoError;
use crate::printable::shown;
use crate::text::in_plain_words;

/// Something wrong with a scene file.
#[derive(Debug, PartialEq)]
pub(super) struct Diagnostic {
    what: String,
    place: Place,
}

#[derive(Debug, PartialEq)]
enum Place {
    Unknown,
    Line(usize),
    /// A key of a section, of the scene or of an item of a list; an empty key is the section itself, and an
    /// empty section the item.
    Key {
        item: Option<Item>,
        section: &'static str,
        key: &'static str,
    },
}

/// Which item of which list has the section.
type Item = (&'static str, usize);

impl Diagnostic {
    /// About a key of a section, or with an empty key, about the section.
    pub(super) fn at(section: &'static str, key: &'static str, what: impl Into<String>) -> Self {
        Self { what: what.into(), place: Place::Key { item: None, section, key } }
    }

    /// About the scene as a whole.
    pub(super) fn general(what: impl Into<String>) -> Self {
        Self { what: what.into(), place: Place::Unknown }
    }

    /// The same in the sections of a layer.
    pub(super) fn in_layer(mut self, idx: usize) -> Self {
        if let Place::Key { item, .. } = &mut self.place {
            *item = Some(("layers", idx));
        }
        self
    }

    /// The same in the sections of a key frame.
    pub(super) fn in_key(mut self, idx: usize) -> Self {
        self.what = format!("key {idx} of the film: {}", self.what);
        if let Place::Key { item, .. } = &mut self.place {
            *item = Some(("film.keys", idx));
        }
        self
    }

    /// The error, with the line in which the key stands.
    pub(super) fn in_file(self, path: &Path, text: &str) -> IoError {
        let line = match self.place {
            Place::Unknown => None,
            Place::Line(line) => Some(line),
            Place::Key { item, section, key } => line_of_key(text, item, section, key),
        };
        IoError::Scene { path: path.to_owned(), line, what: shown(&self.what) }
    }
}

/// Puts an error of the TOML reader into our words.
pub(super) fn from_toml(error: &toml::de::Error, text: &str) -> Diagnostic {
    let line =
        error.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count());
    let what =
        line.and_then(|line| unknown_key(error.message(), text, line)).unwrap_or_else(|| {
            let message = error.message().lines().collect::<Vec<_>>().join("; ");
            let message = in_plain_words(&message);
            match line.and_then(|line| key_of_line(text, line)) {
                Some(key) if message.starts_with("invalid ") => format!("{key}: {message}"),
                _ => message,
            }
        });
    Diagnostic { what, place: line.map_or(Place::Unknown, Place::Line) }
}

/// The key that a line gives a value to.
fn key_of_line(text: &str, line: usize) -> Option<&str> {
    let (key, _) = text.lines().nth(line - 1)?.split_once('=')?;
    let key = key.trim();
    let is_key = |c: char| c.is_ascii_alphanumeric() || "_-.\"".contains(c);
    (!key.is_empty() && key.chars().all(is_key)).then_some(key)
}

/// Takes serde's ``unknown field `a`, expected one of `b`, `c` `` apart.
fn unknown_key(message: &str, text: &str, line: usize) -> Option<String> {
    let quoted = message.strip_prefix("unknown field ")?;
    let mut names = quoted.split('`').skip(1).step_by(2);
    let key = names.next()?;
    let known: Vec<&str> = names.collect();
    let advice = match nearest(key, &known) {
        Some(name) => format!("did you mean {name:?}?"),
        None => format!("known are {}", known.join(", ")),
    };
    // A section that is not known is a key of the document.
    Some(match section_of_line(text, line) {
        Some(section) if section != key => format!("unknown key {key:?} in [{section}]; {advice}"),
        Some(_) => format!("unknown section [{key}]; {advice}"),
        None => format!("unknown key {key:?}; {advice}"),
    })
}

/// The known name that `key` most looks like, if it does at all.
fn nearest<'n>(key: &str, known: &[&'n str]) -> Option<&'n str> {
    let distance = |name: &str| edit_distance(&key.to_lowercase(), name);
    let best = known.iter().copied().min_by_key(|name| distance(name))?;
    (distance(best) <= 1 + best.len() / 4).then_some(best)
}

/// Letters to add, drop or change (Levenshtein).
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (n_before, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = n_before + 1;
        for (idx, &to) in b.iter().enumerate() {
            let change = diagonal + usize::from(from != to);
            diagonal = row[idx + 1];
            row[idx + 1] = change.min(diagonal + 1).min(row[idx] + 1);
        }
    }
    row[b.len()]
}

/// The section that a line is in, or opens.
fn section_of_line(text: &str, line: usize) -> Option<&str> {
    let mut before = text.lines().take(line).collect::<Vec<_>>().into_iter().rev();
    before.find_map(section_name)
}

fn section_name(line: &str) -> Option<&str> {
    let rest = line.trim_start().strip_prefix('[')?;
    let (name, _) = rest.trim_start_matches('[').split_once(']')?;
    let is_name = name.chars().all(|c| c.is_ascii_alphanumeric() || " _-.\"".contains(c));
    // A line of numbers in an array begins with a bracket as well.
    let is_number = name.trim().parse::<f64>().is_ok();
    (is_name && !is_number && !name.trim().is_empty()).then(|| name.trim())
}

/// The line, counted from 1, where a section, of the scene or of an item of a list, sets a key; else where it
/// begins.
fn line_of_key(text: &str, item: Option<Item>, section: &str, key: &str) -> Option<usize> {
    let sets_key = |line: &str| {
        let name = line.split_once('=').map(|(name, _)| name.trim());
        name.is_some_and(|name| name == key)
    };
    let (mut n_items, mut in_section) = (0, false);
    let mut section_line = None;
    for (idx, line) in text.lines().enumerate() {
        if let Some(name) = section_name(line) {
            let is_item = item.is_some_and(|(list, _)| name == list);
            n_items += usize::from(is_item);
            let is_in_item = item.is_some_and(|(_, idx)| n_items == idx + 1);
            in_section = match item {
                None => name == section,
                Some(_) if !is_in_item => false,
                Some(_) if section.is_empty() => is_item,
                Some((list, _)) => {
                    let below = name.strip_prefix(list).and_then(|rest| rest.strip_prefix('.'));
                    below == Some(section)
                }
            };
            // An item without that section.
            if in_section || (is_item && is_in_item) {
                section_line = Some(idx + 1);
            }
        } else if in_section && sets_key(line) {
            return Some(idx + 1);
        }
    }
    section_line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diagnostic_finds_the_nearest_key() {
        let known = ["slab_width", "sections", "method"];
        assert_eq!(nearest("slabwidth", &known), Some("slab_width"));
        assert_eq!(nearest("Section", &known), Some("sections"));
        assert_eq!(nearest("brightness", &known), None);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
    }

    #[test]
    fn diagnostic_finds_the_line() {
        let text = "[a]\nx = 1\n[b]\ny = [\n  [1.0]\n]\n\n# x = 3\nx = 2\n";
        assert_eq!(line_of_key(text, None, "b", "x"), Some(9));
        assert_eq!(line_of_key(text, None, "b", "z"), Some(3));
        assert_eq!(line_of_key(text, None, "c", "x"), None);
        assert_eq!(section_of_line(text, 9), Some("b"));
        let text = "[[layers]]\n[layers.a]\nx = 1\n[[layers]]\nname = 2\n[layers.a]\n\nx = 2\n";
        let line = |layer, section, key| line_of_key(text, Some(("layers", layer)), section, key);
        assert_eq!([line(0, "a", "x"), line(1, "a", "x")], [Some(3), Some(8)]);
        assert_eq!([line(1, "a", "y"), line(1, "b", "y")], [Some(6), Some(4)]);
    }
}
