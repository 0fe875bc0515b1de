//! The text at the head of an NRRD file, as fields by name. What they mean is decided elsewhere.

use std::io::{BufRead, BufReader, Read};
use std::ops::Deref;
use std::path::Path;

use super::super::header_fields::{HeaderFields, MAX_HEADER_BYTES};
use crate::IoError;
use crate::store::Store;

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
    "centers",
    "units",
    "space units",
    "space",
    "space directions",
    "space origin",
];

/// Older spellings of fields, and today's.
const SYNONYMS: &[(&str, &str)] = &[
    ("datafile", "data file"),
    ("lineskip", "line skip"),
    ("byteskip", "byte skip"),
    ("centerings", "centers"),
];

/// The fields of a header.
#[derive(Debug)]
pub(super) struct Header {
    fields: HeaderFields,
    /// The lines after `data file: LIST`.
    pub(super) listed_files: Vec<String>,
}

impl Deref for Header {
    type Target = HeaderFields;

    fn deref(&self) -> &HeaderFields {
        &self.fields
    }
}

impl Header {
    /// Reads up to the first empty line, or to the end of the file.
    pub(super) fn read(store: Store<'_>, path: &Path) -> Result<Self, IoError> {
        let file = store.open(path)?;
        Self::parse(path, &mut BufReader::new(file.take(MAX_HEADER_BYTES)))
    }

    fn parse(path: &Path, reader: &mut impl BufRead) -> Result<Self, IoError> {
        let mut header = Self { fields: HeaderFields::new(path), listed_files: vec![] };
        let magic = header.fields.next_line(reader)?.unwrap_or_default();
        header.check_magic(&magic)?;
        while let Some(line) = header.fields.next_line(reader)?.filter(|line| !line.is_empty()) {
            header.take_line(&line)?;
        }
        header.check_length()?;
        Ok(header)
    }

    fn check_magic(&self, line: &str) -> Result<(), IoError> {
        let line = line.trim_end();
        match line.strip_prefix("NRRD000") {
            Some("1" | "2" | "3" | "4" | "5") => Ok(()),
            _ if line.starts_with("NRRD") => Err(self.unsupported(format!(
                "there is no version {line:?} of the format yet: NRRD0001 to NRRD0005 are read"
            ))),
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
        self.fields.push(name, text.trim());
        Ok(())
    }

    fn is_list(&self) -> bool {
        self.get("data file").is_some_and(|text| text.split_whitespace().next() == Some("LIST"))
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
        assert!(parse("NRRD0012\n").contains("no version \"NRRD0012\""));
        assert!(parse("").contains("unpack the file"));
        assert!(parse("").contains("NRRD0001 to NRRD0005"));
        assert!(parse("NRRD0004\nhello\n").contains("\"hello\""));
        assert!(parse("NRRD0004\ntype: a\nTYPE: b\n").contains("twice"));
    }
}
