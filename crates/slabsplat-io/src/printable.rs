//! Names out of files, for messages of one line. Headers name files, too, so that a path is such a name.

use std::path::Path;

/// The text without what would end a line or command a terminal.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

/// The path likewise.
pub(crate) fn shown(path: &Path) -> String {
    printable(&path.to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printable_has_no_controls() {
        assert_eq!(printable("a b\n\u{1b}[1mc"), "a b\u{fffd}\u{fffd}[1mc");
        assert_eq!(shown(Path::new("in/a\u{1b}.raw")), "in/a\u{fffd}.raw");
    }
}
