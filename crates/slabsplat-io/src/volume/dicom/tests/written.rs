//! Files written element by element.

use super::super::tags::{self, Tag};

pub(super) const EXPLICIT: &str = "1.2.840.10008.1.2.1";
pub(super) const IMPLICIT: &str = "1.2.840.10008.1.2";
pub(super) const BIG: &str = "1.2.840.10008.1.2.2";
pub(super) const DEFLATED: &str = "1.2.840.10008.1.2.1.99";
pub(super) const RLE: &str = "1.2.840.10008.1.2.5";

/// An element's value, as it is written.
#[derive(Clone)]
pub(super) enum Value {
    Text(String),
    Short(u16),
    Items(Vec<Vec<(Tag, Value)>>),
    Words(Vec<u16>),
    Fragments(Vec<Vec<u8>>),
}

pub(super) use Value::{Fragments, Items, Short, Text, Words};

pub(super) fn text(text: &str) -> Value {
    Text(text.to_owned())
}

/// Of a slice of 2 × 2 pixels at a height.
pub(super) fn slice(z: f64, pixels: [u16; 4]) -> Vec<(Tag, Value)> {
    vec![
        (tags::IMAGE_TYPE, text("ORIGINAL\\PRIMARY\\AXIAL")),
        (tags::MODALITY, text("CT")),
        (tags::SERIES_DESCRIPTION, text("head")),
        (tags::SERIES_UID, text("1.2.3")),
        (tags::SERIES_NUMBER, text("7")),
        (tags::INSTANCE_NUMBER, text(&format!("{}", 100.0 - z))),
        (tags::IMAGE_POSITION, text(&format!("10\\20\\{z}"))),
        (tags::IMAGE_ORIENTATION, text("1\\0\\0\\0\\1\\0")),
        (tags::SAMPLES_PER_PIXEL, Short(1)),
        (tags::PHOTOMETRIC, text("MONOCHROME2")),
        (tags::ROWS, Short(2)),
        (tags::COLUMNS, Short(2)),
        (tags::PIXEL_SPACING, text("3\\2")),
        (tags::BITS_ALLOCATED, Short(16)),
        (tags::BITS_STORED, Short(12)),
        (tags::HIGH_BIT, Short(11)),
        (tags::PIXEL_REPRESENTATION, Short(0)),
        (tags::INTERCEPT, text("-1024")),
        (tags::SLOPE, text("1")),
        (tags::PIXEL_DATA, Words(pixels.to_vec())),
    ]
}

/// The same with other elements, in their order.
pub(super) fn with(mut elements: Vec<(Tag, Value)>, changes: &[(Tag, Value)]) -> Vec<(Tag, Value)> {
    for (tag, value) in changes {
        elements.retain(|(other, _)| other != tag);
        elements.push((*tag, value.clone()));
    }
    elements.sort_by_key(|(tag, _)| *tag);
    elements
}

struct Writer {
    is_explicit: bool,
    is_big: bool,
    bytes: Vec<u8>,
}

impl Writer {
    fn short(&mut self, number: u16) {
        self.bytes.extend(if self.is_big { number.to_be_bytes() } else { number.to_le_bytes() });
    }

    fn long(&mut self, number: u32) {
        self.bytes.extend(if self.is_big { number.to_be_bytes() } else { number.to_le_bytes() });
    }

    fn element(&mut self, (group, element): Tag, representation: &[u8; 2], value: &[u8], n: u32) {
        self.short(group);
        self.short(element);
        let is_long = matches!(representation, b"SQ" | b"OW" | b"OB");
        if self.is_explicit && group != 0xfffe {
            self.bytes.extend(representation);
            if is_long {
                self.short(0);
                self.long(n);
            } else {
                self.short(n as u16);
            }
        } else {
            self.long(n);
        }
        self.bytes.extend(value);
    }

    fn all(&mut self, elements: &[(Tag, Value)]) {
        for (tag, value) in elements {
            self.one(*tag, value);
        }
    }

    fn one(&mut self, tag: Tag, value: &Value) {
        let part = |this: &Self, write: &dyn Fn(&mut Self)| {
            let mut part = Self { bytes: vec![], ..*this };
            write(&mut part);
            part.bytes
        };
        match value {
            Text(text) => {
                let mut bytes = text.clone().into_bytes();
                bytes.resize(bytes.len().next_multiple_of(2), b' ');
                let is_code = tag == tags::IMAGE_TYPE;
                let representation = if is_code { b"CS" } else { b"LO" };
                self.element(tag, representation, &bytes, bytes.len() as u32);
            }
            Short(number) => {
                let bytes = part(self, &|part| part.short(*number));
                self.element(tag, b"US", &bytes, 2);
            }
            Words(words) => {
                let bytes = part(self, &|part| words.iter().for_each(|word| part.short(*word)));
                self.element(tag, b"OW", &bytes, bytes.len() as u32);
            }
            // Every second sequence ends by an element, and every second item.
            Items(items) => {
                let bytes = part(self, &|part| {
                    for (idx, item) in items.iter().enumerate() {
                        let mut inner = Self { bytes: vec![], ..*part };
                        inner.all(item);
                        let n = inner.bytes.len() as u32;
                        let is_open = idx.is_multiple_of(2);
                        let item = (0xfffe, 0xe000);
                        part.element(item, b"UN", &inner.bytes, if is_open { u32::MAX } else { n });
                        if is_open {
                            part.element((0xfffe, 0xe00d), b"UN", &[], 0);
                        }
                    }
                });
                let is_open = items.len() % 2 == 1;
                let n = if is_open { u32::MAX } else { bytes.len() as u32 };
                self.element(tag, b"SQ", &bytes, n);
                if is_open {
                    self.element((0xfffe, 0xe0dd), b"UN", &[], 0);
                }
            }
            Fragments(fragments) => {
                let bytes = part(self, &|part| {
                    for fragment in fragments {
                        part.element((0xfffe, 0xe000), b"UN", fragment, fragment.len() as u32);
                    }
                    part.element((0xfffe, 0xe0dd), b"UN", &[], 0);
                });
                self.element(tag, b"OB", &bytes, u32::MAX);
            }
        }
    }
}

/// A file of these elements in a transfer syntax.
pub(super) fn file(syntax: &str, elements: &[(Tag, Value)]) -> Vec<u8> {
    let mut meta = Writer { is_explicit: true, is_big: false, bytes: vec![0; 128] };
    meta.bytes.extend(b"DICM");
    meta.one(tags::TRANSFER_SYNTAX, &text(syntax));
    let mut writer =
        Writer { is_explicit: syntax != IMPLICIT, is_big: syntax == BIG, bytes: Vec::new() };
    writer.all(elements);
    let mut body = writer.bytes;
    if syntax == DEFLATED {
        use std::io::Write;
        let level = flate2::Compression::fast();
        let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), level);
        encoder.write_all(&body).unwrap();
        body = encoder.finish().unwrap();
    }
    [meta.bytes, body].concat()
}
