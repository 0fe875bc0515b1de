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

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

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
