//! The elements of a file up to its pixels, as far as they say what the pixels are (PS3.5 §7, PS3.10 §7).
//!
//! Own code, and not the crate `dicom-object`: that takes memory for as many bytes as an element claims to
//! have, 4 GiB for a file of 200 bytes. Here a value grows with what comes, and what is not wanted is passed
//! over.

use std::io::{self, Cursor, Read};
use std::path::Path;

use flate2::read::DeflateDecoder;

use super::super::Endian;
use super::tags::{self, Tag};
use crate::IoError;

/// Sequences in sequences; functional groups have three.
const MAX_DEPTH: usize = 16;

/// No wanted value is longer: a number, a name, a point.
const MAX_VALUE_BYTES: u32 = 4096;

/// Of all before the pixels, unpacked if they are: ten thousand frames have some 20 MiB.
const MAX_BYTES: u64 = 512 << 20;

/// Items that are kept: as many as a hundred thousand frames have, of ten groups each.
const MAX_ITEMS: usize = 1 << 20;

/// An element that stands for the end of something, or is part of a sequence.
const ITEM: Tag = (0xfffe, 0xe000);
const ITEM_END: Tag = (0xfffe, 0xe00d);
const SEQUENCE_END: Tag = (0xfffe, 0xe0dd);

/// The length of what ends by an element of its own.
const UNDEFINED: u32 = u32::MAX;

/// Value representations whose length has 32 bits.
const LONG: &[&[u8; 2]] =
    &[b"OB", b"OD", b"OF", b"OL", b"OV", b"OW", b"SQ", b"SV", b"UC", b"UN", b"UR", b"UT", b"UV"];

/// How a file's elements are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Syntax {
    pub(super) endian: Endian,
    is_explicit: bool,
    /// All after the first group is packed.
    pub(super) is_deflated: bool,
    /// Where that begins.
    pub(super) deflated_from: u64,
    /// How pixels are packed.
    pub(super) packing: Packing,
}

/// How pixels are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    None,
    Rle,
    Jpeg,
    JpegLs,
    Jpeg2000,
}

/// The elements of a file, or of an item in it.
#[derive(Clone, Debug, Default)]
pub(super) struct Dataset {
    elements: Vec<(Tag, Value)>,
}

#[derive(Clone, Debug)]
enum Value {
    Bytes(Vec<u8>, Endian),
    Items(Vec<Dataset>),
}

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

/// Whether a file begins as one of DICOM does: after 128 bytes of anything, or, as old ones, with its first
/// elements.
pub(super) fn is_begun_by(start: &[u8]) -> bool {
    start.get(128..132) == Some(b"DICM") || begins_with_meta(start) || headless(start).is_some()
}

/// Whether the meta information is at the front, without the preamble that should be before it.
fn begins_with_meta(start: &[u8]) -> bool {
    let &[0x02, 0x00, element, 0x00, a, b, ..] = start else { return false };
    // Its length, its version, or the names of class, instance and syntax, in explicit elements.
    matches!(element, 0x00..=0x03 | 0x10) && [a, b].iter().all(u8::is_ascii_uppercase)
}

/// How a file is written that has no more than elements.
fn headless(start: &[u8]) -> Option<Syntax> {
    let &[0x08, 0x00, element, 0x00, a, b, c, d, ..] = start else { return None };
    let is_known = matches!(element, 0x00 | 0x05 | 0x08 | 0x16);
    let is_explicit = matches!(&[a, b], b"UL" | b"CS" | b"UI");
    let n_bytes = u32::from_le_bytes([a, b, c, d]);
    let is_short = (2..256).contains(&n_bytes) && n_bytes.is_multiple_of(2);
    let syntax = Syntax { is_explicit, ..Syntax::EXPLICIT };
    (is_known && (is_explicit || is_short)).then_some(syntax)
}

impl Syntax {
    const EXPLICIT: Self = Self {
        endian: Endian::Little,
        is_explicit: true,
        is_deflated: false,
        deflated_from: 0,
        packing: Packing::None,
    };

    /// By its name (PS3.6 §A).
    fn of(uid: &str) -> Result<Self, String> {
        let packed = |packing| Ok(Self { packing, ..Self::EXPLICIT });
        let name = match uid {
            "1.2.840.10008.1.2" => return Ok(Self { is_explicit: false, ..Self::EXPLICIT }),
            "1.2.840.10008.1.2.1" => return Ok(Self::EXPLICIT),
            "1.2.840.10008.1.2.1.99" => return Ok(Self { is_deflated: true, ..Self::EXPLICIT }),
            "1.2.840.10008.1.2.2" => return Ok(Self { endian: Endian::Big, ..Self::EXPLICIT }),
            "1.2.840.10008.1.2.5" => return packed(Packing::Rle),
            "1.2.840.10008.1.2.4.50"
            | "1.2.840.10008.1.2.4.51"
            | "1.2.840.10008.1.2.4.57"
            | "1.2.840.10008.1.2.4.70" => return packed(Packing::Jpeg),
            "1.2.840.10008.1.2.4.80" | "1.2.840.10008.1.2.4.81" => return packed(Packing::JpegLs),
            "1.2.840.10008.1.2.4.90" | "1.2.840.10008.1.2.4.91" => {
                return packed(Packing::Jpeg2000);
            }
            "1.2.840.10008.1.2.4.201" | "1.2.840.10008.1.2.4.202" | "1.2.840.10008.1.2.4.203" => {
                "HTJ2K"
            }
            other => {
                let other: String = other.chars().take(64).collect();
                return Err(format!(
                    "its transfer syntax {other:?} cannot be read: unpack it by gdcmconv --raw"
                ));
            }
        };
        Err(format!(
            "its pixels are packed as {name}, which cannot be read: save it as JPEG 2000, or unpacked"
        ))
    }
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

/// Fills `bytes` as far as there is anything.
fn read_up_to(reader: &mut impl Read, bytes: &mut [u8]) -> io::Result<usize> {
    let mut n_read = 0;
    while n_read < bytes.len() {
        match reader.read(&mut bytes[n_read..])? {
            0 => break,
            n => n_read += n,
        }
    }
    Ok(n_read)
}

/// Elements as they come.
struct Elements<R> {
    reader: R,
    n_read: u64,
    /// Items that were kept.
    n_items: usize,
}

#[derive(Clone, Copy)]
struct Element {
    tag: Tag,
    representation: [u8; 2],
    n_bytes: u32,
}

impl<R: Read> Read for Elements<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let n_read = self.reader.read(bytes)?;
        self.n_read += n_read as u64;
        if MAX_BYTES < self.n_read {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "there is no end to its elements",
            ));
        }
        Ok(n_read)
    }
}

impl<R: Read> Elements<R> {
    fn of(reader: R, n_read: u64) -> Self {
        Self { reader, n_read, n_items: 0 }
    }

    fn array<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    fn u16(&mut self, endian: Endian) -> io::Result<u16> {
        let bytes = self.array()?;
        Ok(match endian {
            Endian::Little => u16::from_le_bytes(bytes),
            Endian::Big => u16::from_be_bytes(bytes),
        })
    }

    fn u32(&mut self, endian: Endian) -> io::Result<u32> {
        let bytes = self.array()?;
        Ok(match endian {
            Endian::Little => u32::from_le_bytes(bytes),
            Endian::Big => u32::from_be_bytes(bytes),
        })
    }

    /// The elements of the first group, and the bytes of the tag that comes after them.
    fn meta(&mut self) -> io::Result<(Dataset, Vec<u8>)> {
        let mut meta = Dataset::default();
        loop {
            let mut next = [0; 4];
            let n_next = read_up_to(self, &mut next)?;
            if n_next < 4 || next[..2] != [2, 0] {
                return Ok((meta, next[..n_next].to_vec()));
            }
            let tag = (2, u16::from_le_bytes([next[2], next[3]]));
            let element = self.after_tag(tag, Syntax::EXPLICIT)?;
            self.take_value(&mut meta, &element, Syntax::EXPLICIT, 0)?;
        }
    }

    /// `None` at the end of the file.
    fn next(&mut self, syntax: Syntax) -> io::Result<Option<Element>> {
        let mut tag = [0; 4];
        if read_up_to(self, &mut tag)? < 4 {
            return Ok(None);
        }
        let half = |bytes: [u8; 2]| match syntax.endian {
            Endian::Little => u16::from_le_bytes(bytes),
            Endian::Big => u16::from_be_bytes(bytes),
        };
        let tag = (half([tag[0], tag[1]]), half([tag[2], tag[3]]));
        self.after_tag(tag, syntax).map(Some)
    }

    fn after_tag(&mut self, tag: Tag, syntax: Syntax) -> io::Result<Element> {
        let endian = syntax.endian;
        if !syntax.is_explicit || tag.0 == ITEM.0 {
            return Ok(Element { tag, representation: *b"UN", n_bytes: self.u32(endian)? });
        }
        let representation = self.array()?;
        let n_bytes = if LONG.contains(&&representation) {
            self.u16(endian)?;
            self.u32(endian)?
        } else {
            u32::from(self.u16(endian)?)
        };
        Ok(Element { tag, representation, n_bytes })
    }

    /// Keeps the value of an element that is wanted, and passes over any other.
    fn take_value(
        &mut self,
        dataset: &mut Dataset,
        element: &Element,
        syntax: Syntax,
        depth: usize,
    ) -> io::Result<()> {
        let Element { tag, representation, n_bytes } = *element;
        let is_sequence = tags::SEQUENCES.contains(&tag);
        if n_bytes == UNDEFINED || is_sequence {
            // What a writer did not know is written implicitly.
            let is_unknown = n_bytes == UNDEFINED && representation == *b"UN" && !is_sequence;
            let is_explicit = syntax.is_explicit && !is_unknown;
            let items =
                self.items(n_bytes, Syntax { is_explicit, ..syntax }, depth, is_sequence)?;
            if is_sequence {
                dataset.add(tag, Value::Items(items));
            }
            return Ok(());
        }
        if !tags::VALUES.contains(&tag) || MAX_VALUE_BYTES < n_bytes {
            return self.skip(u64::from(n_bytes));
        }
        let mut bytes = vec![0; n_bytes as usize];
        self.read_exact(&mut bytes)?;
        dataset.add(tag, Value::Bytes(bytes, syntax.endian));
        Ok(())
    }

    fn skip(&mut self, n_bytes: u64) -> io::Result<()> {
        let n_skipped = io::copy(&mut self.by_ref().take(n_bytes), &mut io::sink())?;
        if n_skipped < n_bytes {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(())
    }

    /// The items of a sequence, to its last byte or to the element that ends it.
    fn items(
        &mut self,
        n_bytes: u32,
        syntax: Syntax,
        depth: usize,
        is_wanted: bool,
    ) -> io::Result<Vec<Dataset>> {
        if MAX_DEPTH < depth {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "its sequences are too deep"));
        }
        let mut items = Vec::new();
        let end = end_of(self.n_read, n_bytes);
        while self.n_read < end {
            let Some(element) = self.next(syntax)? else {
                return Err(io::ErrorKind::UnexpectedEof.into());
            };
            match element.tag {
                ITEM => {
                    self.n_items += usize::from(is_wanted);
                    if MAX_ITEMS < self.n_items {
                        let what = "its sequences have more than a million items";
                        return Err(io::Error::new(io::ErrorKind::InvalidData, what));
                    }
                    let item = self.item(element.n_bytes, syntax, depth, is_wanted)?;
                    items.extend(is_wanted.then_some(item));
                }
                SEQUENCE_END => break,
                _ => {
                    let what = "a sequence holds something other than items";
                    return Err(io::Error::new(io::ErrorKind::InvalidData, what));
                }
            }
        }
        Ok(items)
    }

    fn item(
        &mut self,
        n_bytes: u32,
        syntax: Syntax,
        depth: usize,
        is_wanted: bool,
    ) -> io::Result<Dataset> {
        let mut item = Dataset::default();
        if n_bytes != UNDEFINED && !is_wanted {
            return self.skip(u64::from(n_bytes)).map(|()| item);
        }
        let end = end_of(self.n_read, n_bytes);
        while self.n_read < end {
            let Some(element) = self.next(syntax)? else {
                return Err(io::ErrorKind::UnexpectedEof.into());
            };
            if element.tag == ITEM_END {
                break;
            }
            self.take_value(&mut item, &element, syntax, depth + 1)?;
        }
        Ok(item)
    }
}

fn end_of(n_read: u64, n_bytes: u32) -> u64 {
    if n_bytes == UNDEFINED { u64::MAX } else { n_read + u64::from(n_bytes) }
}

impl Dataset {
    /// What comes twice is kept once, so that no dataset has more elements than there are tags.
    fn add(&mut self, tag: Tag, value: Value) {
        if self.get(tag).is_none() {
            self.elements.push((tag, value));
        }
    }

    fn get(&self, tag: Tag) -> Option<&Value> {
        self.elements.iter().find(|(other, _)| *other == tag).map(|(_, value)| value)
    }

    /// The items of a sequence; none if it is not there.
    pub(super) fn items(&self, tag: Tag) -> &[Self] {
        match self.get(tag) {
            Some(Value::Items(items)) => items,
            _ => &[],
        }
    }

    /// A text, without the blanks that fill it up.
    pub(super) fn text(&self, tag: Tag) -> Option<&str> {
        let Value::Bytes(bytes, _) = self.get(tag)? else { return None };
        let text = str::from_utf8(bytes).ok()?.trim_matches([' ', '\0']);
        (!text.is_empty()).then_some(text)
    }

    /// A number that is written as text.
    pub(super) fn decimal(&self, tag: Tag) -> Option<f64> {
        self.text(tag)?.split('\\').next()?.trim().parse().ok().filter(|n: &f64| n.is_finite())
    }

    /// Numbers that are written as text, all of them finite.
    pub(super) fn decimals<const N: usize>(&self, tag: Tag) -> Option<[f64; N]> {
        let numbers = self.text(tag)?.split('\\').map(|n| n.trim().parse().ok());
        let numbers: Vec<f64> = numbers.collect::<Option<_>>()?;
        let numbers: [f64; N] = numbers.try_into().ok()?;
        numbers.iter().all(|n| n.is_finite()).then_some(numbers)
    }

    /// A whole number that is written as text.
    pub(super) fn whole(&self, tag: Tag) -> Option<i64> {
        self.text(tag)?.split('\\').next()?.trim().parse().ok()
    }

    /// A number of 16 or 32 bits.
    pub(super) fn unsigned(&self, tag: Tag) -> Option<u32> {
        let Value::Bytes(bytes, endian) = self.get(tag)? else { return None };
        let mut number = [0; 4];
        let n_bytes = bytes.len().min(if bytes.len() < 4 { 2 } else { 4 });
        number.get_mut(..n_bytes)?.copy_from_slice(bytes.get(..n_bytes)?);
        if *endian == Endian::Big {
            number[..n_bytes].reverse();
        }
        (n_bytes != 0).then(|| u32::from_le_bytes(number))
    }

    /// A float of 64 bits.
    pub(super) fn double(&self, tag: Tag) -> Option<f64> {
        let Value::Bytes(bytes, endian) = self.get(tag)? else { return None };
        let bytes = bytes.get(..8)?.try_into().ok()?;
        let number = match endian {
            Endian::Little => f64::from_le_bytes(bytes),
            Endian::Big => f64::from_be_bytes(bytes),
        };
        number.is_finite().then_some(number)
    }
}
