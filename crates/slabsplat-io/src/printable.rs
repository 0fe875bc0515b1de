//! Text out of files, for messages of one line. Headers name files, too, so that a path is such a text.

use std::path::Path;

/// The text without what would end a line or command a terminal.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

/// The path likewise; an empty one is that of the working directory.
pub(crate) fn shown_path(path: &Path) -> String {
    if path.as_os_str().is_empty() {
        return ".".to_owned();
    }
    printable(&path.to_string_lossy())
}

/// A message that is longer than this is shown without its middle.
const MAX_CHARS: usize = 400;

/// How many characters are left of its end, which says what to do.
const END_CHARS: usize = 140;

/// A message that may cite a file: printable, and of a length that a person reads.
pub(crate) fn shown(message: &str) -> String {
    let n_chars = message.chars().count();
    if n_chars <= MAX_CHARS {
        return printable(message);
    }
    let start: String = message.chars().take(MAX_CHARS - END_CHARS).collect();
    let end: String = message.chars().skip(n_chars - END_CHARS).collect();
    printable(&format!("{start} … {end}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printable_has_no_controls() {
        assert_eq!(printable("a b\n\u{1b}[1mc"), "a b\u{fffd}\u{fffd}[1mc");
        assert_eq!(shown_path(Path::new("")), ".");
        assert_eq!(shown_path(Path::new("in/a\u{1b}.raw")), "in/a\u{fffd}.raw");
    }

    #[test]
    fn shown_messages_lose_their_middle() {
        assert_eq!(shown("short\u{7}"), "short\u{fffd}");
        let long = format!("it begins with {}: save it as raw", "ä".repeat(5_000_000));
        let shown = shown(&long);
        assert!(shown.starts_with("it begins with ää") && shown.ends_with("ää: save it as raw"));
        assert_eq!(shown.chars().count(), MAX_CHARS + 3);
    }
}
