//! Small text files: scenes, descriptions, colour maps.

use std::io::Read;
use std::path::Path;

use crate::IoError;
use crate::store::Store;

/// No text that a person writes is longer.
const MAX_BYTES: u64 = 16 << 20;

/// The whole text of a file, which must be UTF-8 and not absurdly long.
pub(crate) fn read(path: &Path) -> Result<String, IoError> {
    read_from(Store::Disk, path)
}

pub(crate) fn read_from(store: Store<'_>, path: &Path) -> Result<String, IoError> {
    let file = store.open(path)?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(IoError::read(path))?;
    if MAX_BYTES < bytes.len() as u64 {
        return Err(IoError::malformed(path, "longer than 16 MiB: not a text of this kind"));
    }
    String::from_utf8(bytes)
        .map_err(|_| IoError::malformed(path, "not a text in UTF-8: save it as such"))
}

/// What serde says of a value, with people's words for its types.
pub(crate) fn in_plain_words(message: &str) -> String {
    const WORDS: &[(&str, &str)] = &[
        ("u8", "a whole number from 0 to 255"),
        ("u16", "a whole number of at least 0"),
        ("u32", "a whole number of at least 0"),
        ("u64", "a whole number of at least 0"),
        ("usize", "a whole number of at least 0"),
        ("i64", "a whole number"),
        ("f32", "a number"),
        ("f64", "a number"),
        ("a sequence", "a list"),
    ];
    let Some((before, expected)) = message.rsplit_once("expected ") else {
        return message.to_owned();
    };
    let (word, after) = expected.split_once(" at line ").unwrap_or((expected, ""));
    let plain = WORDS.iter().find(|(theirs, _)| *theirs == word).map_or(word, |(_, ours)| *ours);
    let separator = if after.is_empty() { "" } else { " at line " };
    format!("{before}expected {plain}{separator}{after}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    #[test]
    fn words_of_serde_are_plain() {
        for (message, expected) in [
            (
                "invalid type: map, expected u32",
                "invalid type: map, expected a whole number of at least 0",
            ),
            (
                "invalid type: null, expected f64 at line 1 column 2",
                "invalid type: null, expected a number at line 1 column 2",
            ),
            ("missing field `a`", "missing field `a`"),
            ("expected `=`", "expected `=`"),
        ] {
            assert_eq!(in_plain_words(message), expected);
        }
    }

    #[test]
    fn text_must_be_short_utf8() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.toml");
        std::fs::write(&path, "grün").unwrap();
        assert_eq!(read(&path).unwrap(), "grün");
        std::fs::write(&path, [0xff, 0xfe]).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("UTF-8"));
        File::create(&path).unwrap().set_len(17 << 20).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("16 MiB"));
    }
}
