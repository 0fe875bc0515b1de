//! How a file's elements are written: by its transfer syntax, or by what it begins with.

use super::super::Endian;

/// How a file's elements are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Syntax {
    pub(super) endian: Endian,
    pub(super) is_explicit: bool,
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

/// Whether a file begins as one of DICOM does: after 128 bytes of anything, or, as old ones, with its first
/// elements.
pub(super) fn is_begun_by(start: &[u8]) -> bool {
    start.get(128..132) == Some(b"DICM") || begins_with_meta(start) || headless(start).is_some()
}

/// Whether the meta information is at the front, without the preamble that should be before it.
pub(super) fn begins_with_meta(start: &[u8]) -> bool {
    let &[0x02, 0x00, element, 0x00, a, b, ..] = start else { return false };
    // Its length, its version, or the names of class, instance and syntax, in explicit elements.
    matches!(element, 0x00..=0x03 | 0x10) && [a, b].iter().all(u8::is_ascii_uppercase)
}

/// How a file is written that has no more than elements.
pub(super) fn headless(start: &[u8]) -> Option<Syntax> {
    let &[0x08, 0x00, element, 0x00, a, b, c, d, ..] = start else { return None };
    let is_known = matches!(element, 0x00 | 0x05 | 0x08 | 0x16);
    let is_explicit = matches!(&[a, b], b"UL" | b"CS" | b"UI");
    let n_bytes = u32::from_le_bytes([a, b, c, d]);
    let is_short = (2..256).contains(&n_bytes) && n_bytes.is_multiple_of(2);
    let syntax = Syntax { is_explicit, ..Syntax::EXPLICIT };
    (is_known && (is_explicit || is_short)).then_some(syntax)
}

impl Syntax {
    pub(super) const EXPLICIT: Self = Self {
        endian: Endian::Little,
        is_explicit: true,
        is_deflated: false,
        deflated_from: 0,
        packing: Packing::None,
    };

    /// By its name (PS3.6 §A).
    pub(super) fn of(uid: &str) -> Result<Self, String> {
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
