//! Names out of files, for messages of one line.

/// The text without what would end a line or command a terminal.
pub(super) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printable_has_no_controls() {
        assert_eq!(printable("a b\n\u{1b}[1mc"), "a b\u{fffd}\u{fffd}[1mc");
    }
}
