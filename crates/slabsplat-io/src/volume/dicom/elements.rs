//! The elements of a file up to its pixels, as far as they say what the pixels are (PS3.5 §7, PS3.10 §7).
//!
//! Own code, and not the crate `dicom-object`: that takes memory for as many bytes as an element claims to
//! have, 4 GiB for a file of 200 bytes. Here a value grows with what comes, and what is not wanted is passed
//! over.

use std::io::{self, Read};

use super::super::Endian;
use super::dataset::{Dataset, Value};
use super::syntax::Syntax;
use super::tags::{self, Tag};

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
pub(super) const UNDEFINED: u32 = u32::MAX;

/// Value representations whose length has 32 bits.
const LONG: &[&[u8; 2]] =
    &[b"OB", b"OD", b"OF", b"OL", b"OV", b"OW", b"SQ", b"SV", b"UC", b"UN", b"UR", b"UT", b"UV"];

/// Elements as they come.
pub(super) struct Elements<R> {
    pub(super) reader: R,
    pub(super) n_read: u64,
    /// Items that were kept.
    n_items: usize,
}

#[derive(Clone, Copy)]
pub(super) struct Element {
    pub(super) tag: Tag,
    representation: [u8; 2],
    pub(super) n_bytes: u32,
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
    pub(super) fn of(reader: R, n_read: u64) -> Self {
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
    pub(super) fn meta(&mut self) -> io::Result<(Dataset, Vec<u8>)> {
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
    pub(super) fn next(&mut self, syntax: Syntax) -> io::Result<Option<Element>> {
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
    pub(super) fn take_value(
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

/// Fills `bytes` as far as there is anything.
pub(super) fn read_up_to(reader: &mut impl Read, bytes: &mut [u8]) -> io::Result<usize> {
    let mut n_read = 0;
    while n_read < bytes.len() {
        match reader.read(&mut bytes[n_read..])? {
            0 => break,
            n => n_read += n,
        }
    }
    Ok(n_read)
}
