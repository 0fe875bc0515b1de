//! What comes before the pixels of a file (PS3.10 §7), and where these begin.

use std::io::{self, Cursor, Read};
use std::path::Path;

use flate2::read::DeflateDecoder;

use super::dataset::Dataset;
use super::elements::{Elements, UNDEFINED, read_up_to};
use super::syntax::{Syntax, begins_with_meta, headless};
use super::tags::{self, Tag};
use crate::IoError;

/// A file's elements, and where its pixels are.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) dataset: Dataset,
    pub(super) syntax: Syntax,
    /// `None` if the file has no pixels.
    pub(super) pixels: Option<PixelElement>,
}

/// Where pixels begin, and how they are.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelElement {
    pub(super) tag: Tag,
    /// From the file's first byte, or from the first of what is unpacked.
    pub(super) offset: u64,
    /// `None` if they are in fragments.
    pub(super) n_bytes: Option<u32>,
}

impl Header {
    /// Reads what comes before the pixels.
    pub(super) fn read(path: &Path, file: impl Read) -> Result<Self, IoError> {
        let mut elements = Elements::of(file, 0);
        let mut start = [0; 132];
        let n_start = read_up_to(&mut elements, &mut start).map_err(IoError::read(path))?;
        let malformed = |error: io::Error| match error.kind() {
            io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => {
                IoError::malformed(path, format!("not a sound DICOM file: {error}"))
            }
            _ => IoError::Read { path: path.to_owned(), source: error },
        };
        if start.get(128..132) == Some(b"DICM") {
            let meta = elements.meta().map_err(malformed)?;
            return Self::after_meta(path, meta, elements).map_err(malformed)?;
        }
        let start = &start[..n_start];
        let reader = Cursor::new(start.to_vec()).chain(elements.reader);
        if begins_with_meta(start) {
            let mut elements = Elements::of(reader, 0);
            let meta = elements.meta().map_err(malformed)?;
            return Self::after_meta(path, meta, elements).map_err(malformed)?;
        }
        let syntax = headless(start).ok_or_else(|| IoError::malformed(path, "not a DICOM file"))?;
        Self::of_elements(syntax, Elements::of(reader, 0)).map_err(malformed)
    }

    /// With the first element after the meta information, whose tag was read already.
    fn after_meta(
        path: &Path,
        (meta, next): (Dataset, Vec<u8>),
        elements: Elements<impl Read>,
    ) -> io::Result<Result<Self, IoError>> {
        let uid = meta.text(tags::TRANSFER_SYNTAX).unwrap_or("1.2.840.10008.1.2");
        let syntax = match Syntax::of(uid) {
            Ok(syntax) => syntax,
            Err(what) => return Ok(Err(IoError::unsupported(path, what))),
        };
        let n_read = elements.n_read - next.len() as u64;
        let reader = Cursor::new(next).chain(elements.reader);
        if syntax.is_deflated {
            let syntax = Syntax { deflated_from: n_read, ..syntax };
            let reader = DeflateDecoder::new(reader);
            return Self::of_elements(syntax, Elements::of(reader, 0)).map(Ok);
        }
        Self::of_elements(syntax, Elements::of(reader, n_read)).map(Ok)
    }

    fn of_elements(syntax: Syntax, mut elements: Elements<impl Read>) -> io::Result<Self> {
        let mut dataset = Dataset::default();
        let mut pixels = None;
        while let Some(element) = elements.next(syntax)? {
            let is_pixels = tags::PIXELS.contains(&element.tag);
            if is_pixels {
                let n_bytes = (element.n_bytes != UNDEFINED).then_some(element.n_bytes);
                let offset = elements.n_read;
                pixels = Some(PixelElement { tag: element.tag, offset, n_bytes });
                break;
            }
            elements.take_value(&mut dataset, &element, syntax, 0)?;
        }
        Ok(Self { dataset, syntax, pixels })
    }
}
