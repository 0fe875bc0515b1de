//! The text at the head of an NRRD file, as fields by name. What they mean is decided elsewhere.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::IoError;

/// A header longer than this is none: lists of a hundred thousand files are shorter.
const MAX_HEADER_BYTES: u64 = 4 << 20;

/// The fields that decide what is read; all others are left to whoever wrote them.
const FIELDS: &[&str] = &[
    "dimension",
    "type",
    "sizes",
    "encoding",
    "endian",
    "data file",
    "line skip",
    "byte skip",
    "kinds",
    "spacings",
    "axis mins",
    "space",
    "space directions",
    "space origin",
];

/// Older spellings of fields, and today's.
const SYNONYMS: &[(&str, &str)] =
    &[("datafile", "data file"), ("lineskip", "line skip"), ("byteskip", "byte skip")];

/// The fields of a header.
#[derive(Debug)]
pub(super) struct Header {
    /// The file that the header was read from.
    pub(super) path: PathBuf,
    /// Name in lower case, and text.
    fields: Vec<(String, String)>,
    /// The lines after `data file: LIST`.
    pub(super) listed_files: Vec<String>,
    /// Where the header ends, and attached data begin.
    pub(super) n_bytes: u64,
}

impl Header {
    /// Reads up to the first empty line, or to the end of the file.
    pub(super) fn read(path: &Path) -> Result<Self, IoError> {
        let file = File::open(path).map_err(IoError::read(path))?;
        Self::parse(path, &mut BufReader::new(file.take(MAX_HEADER_BYTES)))
    }

    fn parse(path: &Path, reader: &mut impl BufRead) -> Result<Self, IoError> {
        let mut header =
            Self { path: path.to_owned(), fields: vec![], listed_files: vec![], n_bytes: 0 };
        let magic = header.next_line(reader)?.unwrap_or_default();
        header.check_magic(&magic)?;
        while let Some(line) = header.next_line(reader)?.filter(|line| !line.is_empty()) {
            header.take_line(&line)?;
        }
        if header.n_bytes == MAX_HEADER_BYTES {
            return Err(header.malformed("the header does not end within 4 MiB"));
        }
        Ok(header)
    }

    /// The next line without its end; `None` at the end of the file.
    ///
    /// Comments and contents are often not UTF-8, so that what is not becomes `�`; where it matters,
    /// in a number or the name of a file, that fails later and is shown.
    fn next_line(&mut self, reader: &mut impl BufRead) -> Result<Option<String>, IoError> {
        let mut bytes = Vec::new();
        let n_read = reader.read_until(b'\n', &mut bytes).map_err(IoError::read(&self.path))?;
        self.n_bytes += n_read as u64;
        let line = String::from_utf8_lossy(&bytes);
        Ok((0 < n_read).then(|| line.trim_end_matches(['\n', '\r']).to_owned()))
    }

    fn check_magic(&self, line: &str) -> Result<(), IoError> {
        match line.trim_end().strip_prefix("NRRD000") {
            Some("1" | "2" | "3" | "4" | "5") => Ok(()),
            _ => Err(self.unsupported(
                "the first line is not NRRD0001 to NRRD0005: unpack the file if it is packed as a \
                 whole",
            )),
        }
    }

    /// Keeps a field; comments and key/value pairs are not ours.
    fn take_line(&mut self, line: &str) -> Result<(), IoError> {
        if self.is_list() {
            self.listed_files.push(line.to_owned());
            return Ok(());
        }
        if line.starts_with('#') {
            return Ok(());
        }
        let Some((name, text)) = line.split_once(':') else {
            let what = format!("{line:?} in the header is neither a field nor a comment");
            return Err(self.malformed(what));
        };
        if text.starts_with('=') {
            return Ok(());
        }
        let name = name.trim().to_lowercase();
        let synonym = SYNONYMS.iter().find(|(old, _)| *old == name).map(|(_, new)| *new);
        let name = synonym.map_or(name, str::to_owned);
        if !FIELDS.contains(&name.as_str()) {
            return Ok(());
        }
        if self.get(&name).is_some() {
            return Err(self.malformed(format!("the header gives {name:?} twice")));
        }
        self.fields.push((name, text.trim().to_owned()));
        Ok(())
    }

    fn is_list(&self) -> bool {
        self.get("data file").is_some_and(|text| text.split_whitespace().next() == Some("LIST"))
    }

    /// The text of a field.
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

    pub(super) fn malformed(&self, what: impl Into<String>) -> IoError {
        IoError::malformed(&self.path, what)
    }

    pub(super) fn unsupported(&self, what: impl Into<String>) -> IoError {
        IoError::unsupported(&self.path, what)
    }
}

#[cfg(test)]
impl Header {
    /// The header of an imaginary file of these lines.
    pub(super) fn of(lines: &str) -> Self {
        let text = format!("NRRD0005\n{lines}");
        Self::parse(Path::new("a.nrrd"), &mut text.as_bytes()).unwrap()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_keeps_fields_only() {
        let header = Header::of("# c: d\nSizes: 1 2\r\nkey:=sizes: 3\nDataFile: a b\r\n\r\nx: y\n");
        assert_eq!(header.get("sizes"), Some("1 2"));
        assert_eq!(header.get("data file"), Some("a b"));
        assert_eq!(header.fields.len(), 2);
        assert_eq!(header.n_bytes, 59);
        assert_eq!(header.numbers::<usize>("sizes", 2).unwrap(), Some(vec![1, 2]));
        assert!(header.numbers::<usize>("sizes", 3).is_err());
        assert_eq!(header.parsed::<i64>("byte skip").unwrap(), None);
    }

    #[test]
    fn header_lists_files_to_the_end() {
        let header = Header::of("data file: LIST 2\na.raw\n# b.raw\n\nc.raw");
        assert_eq!(header.listed_files, ["a.raw", "# b.raw"]);
    }

    #[test]
    fn header_rejects_nonsense() {
        let parse = |text: &str| {
            let err = Header::parse(Path::new("a.nrrd"), &mut text.as_bytes()).unwrap_err();
            err.to_string()
        };
        assert!(parse("NRRD0009\n").contains("NRRD0001 to NRRD0005"));
        assert!(parse("").contains("NRRD0001 to NRRD0005"));
        assert!(parse("NRRD0004\nhello\n").contains("\"hello\""));
        assert!(parse("NRRD0004\ntype: a\nTYPE: b\n").contains("twice"));
    }
}
