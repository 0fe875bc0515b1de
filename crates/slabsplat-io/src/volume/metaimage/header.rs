//! The text at the head of a MetaImage, as fields by name. What they mean is decided elsewhere.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::IoError;

/// A header longer than this is none: lists of a hundred thousand files are shorter.
const MAX_HEADER_BYTES: u64 = 4 << 20;

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
    /// The file that the header was read from.
    pub(super) path: PathBuf,
    /// Name in lower case, and text.
    fields: Vec<(String, String)>,
    /// The lines after `ElementDataFile = LIST`.
    pub(super) listed_files: Vec<String>,
    /// Where the header ends, and attached data begin.
    pub(super) n_bytes: u64,
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

impl Header {
    /// Reads up to the name of the data's file, or to the end of a list of them.
    pub(super) fn read(path: &Path) -> Result<Self, IoError> {
        let file = File::open(path).map_err(IoError::read(path))?;
        let mut reader = BufReader::new(file.take(MAX_HEADER_BYTES));
        let mut header =
            Self { path: path.to_owned(), fields: vec![], listed_files: vec![], n_bytes: 0 };
        while header.get(DATA_FILE).is_none() {
            let Some(line) = header.next_line(&mut reader)? else {
                return Err(header.malformed("the header does not say ElementDataFile"));
            };
            header.take_line(&line)?;
        }
        if header.is_list() {
            while let Some(line) = header.next_line(&mut reader)? {
                let name = line.trim();
                header.listed_files.extend((!name.is_empty()).then(|| name.to_owned()));
            }
        }
        if header.n_bytes == MAX_HEADER_BYTES {
            return Err(header.malformed("the header does not end within 4 MiB"));
        }
        Ok(header)
    }

    /// The next line without its end; `None` at the end of the file. What is not UTF-8 becomes `�`: it only
    /// matters in the name of a file, which then is not there.
    fn next_line(&mut self, reader: &mut impl BufRead) -> Result<Option<String>, IoError> {
        let mut bytes = Vec::new();
        let n_read = reader.read_until(b'\n', &mut bytes).map_err(IoError::read(&self.path))?;
        self.n_bytes += n_read as u64;
        let line = String::from_utf8_lossy(&bytes);
        Ok((0 < n_read).then(|| line.trim_end_matches(['\n', '\r']).to_owned()))
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
            self.fields.push((name, text.to_owned()));
        }
        Ok(())
    }

    /// Whether the data are in files that are listed.
    pub(super) fn is_list(&self) -> bool {
        self.get(DATA_FILE).is_some_and(|text| text.split_whitespace().next() == Some("LIST"))
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

    /// A field that is true or false.
    pub(super) fn is_true(&self, name: &str) -> Result<Option<bool>, IoError> {
        match self.get(name).map(str::to_lowercase).as_deref() {
            None => Ok(None),
            Some("true" | "t" | "1") => Ok(Some(true)),
            Some("false" | "f" | "0") => Ok(Some(false)),
            Some(other) => Err(self.malformed(format!("{name} is {other:?}, not True or False"))),
        }
    }

    /// A field that is `n` numbers with blanks between.
    pub(super) fn numbers<T: FromStr>(
        &self,
        name: &str,
        n: usize,
    ) -> Result<Option<Vec<T>>, IoError> {
        let Some(text) = self.get(name) else { return Ok(None) };
        let numbers: Option<Vec<T>> =
            text.split_whitespace().map(|token| token.parse().ok()).collect();
        match numbers {
            Some(numbers) if numbers.len() == n => Ok(Some(numbers)),
            _ => Err(self.malformed(format!("{name} should be {n} numbers, not {text:?}"))),
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

    pub(super) fn malformed(&self, what: impl Into<String>) -> IoError {
        IoError::malformed(&self.path, what)
    }

    pub(super) fn unsupported(&self, what: impl Into<String>) -> IoError {
        IoError::unsupported(&self.path, what)
    }
}
