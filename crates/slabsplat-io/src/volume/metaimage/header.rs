//! The text at the head of a MetaImage, as fields by name. What they mean is decided elsewhere.

use std::io::{BufReader, Read};
use std::ops::Deref;
use std::path::Path;

use super::super::header_fields::{HeaderFields, MAX_HEADER_BYTES};
use crate::IoError;
use crate::store::Store;

/// With what a header may begin.
const FIRST_FIELDS: &[&str] = &[
    "objecttype",
    "ndims",
    "comment",
    "name",
    "id",
    "binarydata",
    "dimsize",
    "elementtype",
    "elementspacing",
    "elementsize",
    "transformmatrix",
    "offset",
    "position",
];

/// Other names of fields, and the one that is used here.
const SYNONYMS: &[(&str, &str)] = &[
    ("position", "offset"),
    ("origin", "offset"),
    ("rotation", "transformmatrix"),
    ("orientation", "transformmatrix"),
];

/// The last field of every header.
const DATA_FILE: &str = "elementdatafile";

/// The fields of a header.
#[derive(Debug)]
pub(super) struct Header {
    fields: HeaderFields,
    /// The lines after `ElementDataFile = LIST`.
    pub(super) listed_files: Vec<String>,
}

/// Whether a file that begins like this may have such a header.
pub(super) fn is_first_line(start: &[u8]) -> bool {
    let line = start.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let Ok(line) = str::from_utf8(line) else { return false };
    field(line).is_some_and(|(name, _)| FIRST_FIELDS.contains(&name.as_str()))
}

/// `Name = text`.
fn field(line: &str) -> Option<(String, &str)> {
    let (name, text) = line.split_once('=')?;
    Some((name.trim().to_lowercase(), text.trim()))
}

impl Deref for Header {
    type Target = HeaderFields;

    fn deref(&self) -> &HeaderFields {
        &self.fields
    }
}

impl Header {
    /// Reads up to the name of the data's file, or to the end of a list of them.
    pub(super) fn read(store: Store<'_>, path: &Path) -> Result<Self, IoError> {
        let file = store.open(path)?;
        let mut reader = BufReader::new(file.take(MAX_HEADER_BYTES));
        let mut header = Self { fields: HeaderFields::new(path), listed_files: vec![] };
        while header.get(DATA_FILE).is_none() {
            let Some(line) = header.fields.next_line(&mut reader)? else {
                return Err(header.malformed("the header does not say ElementDataFile"));
            };
            header.take_line(&line)?;
        }
        if header.is_list() {
            while let Some(line) = header.fields.next_line(&mut reader)? {
                let name = line.trim();
                header.listed_files.extend((!name.is_empty()).then(|| name.to_owned()));
            }
        }
        header.check_length()?;
        Ok(header)
    }

    fn take_line(&mut self, line: &str) -> Result<(), IoError> {
        if line.trim().is_empty() {
            return Ok(());
        }
        let Some((name, text)) = field(line) else {
            let shown: String = line.chars().take(80).collect();
            return Err(self.malformed(format!("{shown:?} in the header is no field")));
        };
        let synonym = SYNONYMS.iter().find(|(other, _)| *other == name).map(|(_, ours)| *ours);
        let name = synonym.map_or(name, str::to_owned);
        // Of a field that is given twice the first counts, as comments may be.
        if self.get(&name).is_none() {
            self.fields.push(name, text);
        }
        Ok(())
    }

    /// Whether the data are in files that are listed.
    pub(super) fn is_list(&self) -> bool {
        self.get(DATA_FILE).is_some_and(|text| text.split_whitespace().next() == Some("LIST"))
    }

    /// A field that is true or false.
    pub(super) fn is_true(&self, name: &str) -> Result<Option<bool>, IoError> {
        match self.get(name).map(str::to_lowercase).as_deref() {
            None => Ok(None),
            Some("true" | "t" | "1") => Ok(Some(true)),
            Some("false" | "f" | "0") => Ok(Some(false)),
            Some(other) => Err(self.malformed(format!("{name} is {other:?}, not True or False"))),
        }
    }

    /// The voxels along all axes, of which there are 2 to 10.
    pub(super) fn sizes(&self) -> Result<Vec<usize>, IoError> {
        let n_dims: usize = self.parsed("ndims")?.unwrap_or(3);
        if !(2..=10).contains(&n_dims) {
            return Err(self.malformed(format!("the file has {n_dims} axes, and a volume needs 3")));
        }
        let sizes = self.numbers("dimsize", n_dims)?;
        sizes.ok_or_else(|| self.malformed("the header has no field \"dimsize\""))
    }
}
