//! The text at the head of a file, as lines, and as fields by name: what NRRD and MetaImage have in common.

use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::IoError;

/// A header longer than this is none: lists of a hundred thousand files are shorter.
pub(super) const MAX_HEADER_BYTES: u64 = 4 << 20;

/// The fields of a header, as far as it has been read.
#[derive(Debug)]
pub(super) struct HeaderFields {
    /// The file that the header is read from.
    pub(super) path: PathBuf,
    /// Name in lower case, and text.
    fields: Vec<(String, String)>,
    /// Where the lines that were read end.
    pub(super) n_bytes: u64,
}

impl HeaderFields {
    pub(super) fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), fields: Vec::new(), n_bytes: 0 }
    }

    /// The next line without its end; `None` at the end of the file.
    ///
    /// Comments and contents are often not UTF-8, so that what is not becomes `�`; where it matters,
    /// in a number or the name of a file, that fails later and is shown.
    pub(super) fn next_line(
        &mut self,
        reader: &mut impl BufRead,
    ) -> Result<Option<String>, IoError> {
        let mut bytes = Vec::new();
        let n_read = reader.read_until(b'\n', &mut bytes).map_err(IoError::read(&self.path))?;
        self.n_bytes += n_read as u64;
        let line = String::from_utf8_lossy(&bytes);
        Ok((0 < n_read).then(|| line.trim_end_matches(['\n', '\r']).to_owned()))
    }

    /// That the header is one, and not a file without an end.
    pub(super) fn check_length(&self) -> Result<(), IoError> {
        if self.n_bytes == MAX_HEADER_BYTES {
            return Err(self.malformed("the header does not end within 4 MiB"));
        }
        Ok(())
    }

    pub(super) fn push(&mut self, name: String, text: &str) {
        self.fields.push((name, text.to_owned()));
    }

    /// The text of a field, by its name in lower case.
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        self.fields.iter().find(|(n, _)| n == name).map(|(_, text)| text.as_str())
    }

    /// The text of a field that every file must have.
    pub(super) fn needed(&self, name: &str) -> Result<&str, IoError> {
        self.get(name).ok_or_else(|| self.malformed(format!("the header has no field {name:?}")))
    }

    /// A field that is one number.
    pub(super) fn parsed<T: FromStr>(&self, name: &str) -> Result<Option<T>, IoError> {
        let parse = |text: &str| {
            let what = || format!("{name} is {text:?}, which is not a number that it can be");
            text.parse().map_err(|_| self.malformed(what()))
        };
        self.get(name).map(parse).transpose()
    }

    /// A field that is `n` numbers with blanks between.
    pub(super) fn numbers<T: FromStr>(
        &self,
        name: &str,
        n: usize,
    ) -> Result<Option<Vec<T>>, IoError> {
        let Some(text) = self.get(name) else {
            return Ok(None);
        };
        let numbers: Option<Vec<T>> =
            text.split_whitespace().map(|token| token.parse().ok()).collect();
        match numbers {
            Some(numbers) if numbers.len() == n => Ok(Some(numbers)),
            _ => Err(self.malformed(format!("{name} should be {n} numbers, not {text:?}"))),
        }
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.fields.len()
    }

    pub(super) fn malformed(&self, what: impl Into<String>) -> IoError {
        IoError::malformed(&self.path, what)
    }

    pub(super) fn unsupported(&self, what: impl Into<String>) -> IoError {
        IoError::unsupported(&self.path, what)
    }
}
