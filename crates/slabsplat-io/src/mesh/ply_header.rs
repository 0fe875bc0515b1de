//! The header of a PLY file: which elements follow, and what each of them consists of.

use super::numbers::{quoted, words};

/// What a header says.
#[derive(Debug)]
pub(super) struct Header<'a> {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element<'a>>,
    /// What follows the header.
    pub(super) data: &'a [u8],
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// So many things, each of which has these properties.
#[derive(Debug)]
pub(super) struct Element<'a> {
    pub(super) name: &'a [u8],
    pub(super) n: u64,
    pub(super) properties: Vec<Property<'a>>,
}

/// A number, or a list of numbers after their count.
#[derive(Debug)]
pub(super) struct Property<'a> {
    pub(super) name: &'a [u8],
    pub(super) count: Option<Scalar>,
    pub(super) scalar: Scalar,
}

/// What a number is stored as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Result<Self, String> {
        match name {
            b"char" | b"int8" => Ok(Self::I8),
            b"uchar" | b"uint8" => Ok(Self::U8),
            b"short" | b"int16" => Ok(Self::I16),
            b"ushort" | b"uint16" => Ok(Self::U16),
            b"int" | b"int32" => Ok(Self::I32),
            b"uint" | b"uint32" => Ok(Self::U32),
            b"float" | b"float32" => Ok(Self::F32),
            b"double" | b"float64" => Ok(Self::F64),
            _ => Err(format!("{} is no type of a PLY file", quoted(name))),
        }
    }

    /// What stands for 1 where such numbers are colours.
    pub(super) fn full_color(self) -> f64 {
        match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::I32 => i32::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// Whether a file begins as they do.
pub(super) fn is_ply(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") || bytes.starts_with(b"ply ")
}

impl<'a> Header<'a> {
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, String> {
        if !is_ply(bytes) {
            return Err("not a PLY file: it does not begin with ply".to_owned());
        }
        let (mut encoding, mut elements, mut rest) = (None, Vec::new(), bytes);
        loop {
            let end = rest.iter().position(|byte| *byte == b'\n');
            let end = end.ok_or("cut off within the header: there is no end_header")?;
            let (line, data) = (&rest[..end], &rest[end + 1..]);
            rest = data;
            let words: Vec<&[u8]> = words(line).collect();
            match words[..] {
                [b"end_header"] => break,
                [b"format", name, _] => encoding = Some(Encoding::named(name)?),
                [b"element", name, _]
                    if elements.iter().any(|it: &Element<'_>| it.name == name) =>
                {
                    return Err(format!("there are two elements {}", quoted(name)));
                }
                [b"element", name, n] => elements.push(Element::new(name, n)?),
                [b"property", ref of_property @ ..] => {
                    let element = elements.last_mut().ok_or("a property before any element")?;
                    element.properties.push(Property::new(of_property)?);
                }
                [] | [b"ply" | b"comment" | b"obj_info", ..] => {}
                _ => return Err(format!("{} is no line of a PLY header", quoted(line))),
            }
        }
        let encoding = encoding.ok_or("the header has no format")?;
        Ok(Self { encoding, elements, data: rest })
    }
}

impl Encoding {
    fn named(name: &[u8]) -> Result<Self, String> {
        match name {
            b"ascii" => Ok(Self::Text),
            b"binary_little_endian" => Ok(Self::LittleEndian),
            b"binary_big_endian" => Ok(Self::BigEndian),
            _ => Err(format!("{} is no format of a PLY file", quoted(name))),
        }
    }
}

impl<'a> Element<'a> {
    fn new(name: &'a [u8], n: &[u8]) -> Result<Self, String> {
        let parsed = std::str::from_utf8(n).ok().and_then(|n| n.parse().ok());
        let n = parsed.ok_or_else(|| format!("{} is not a number of elements", quoted(n)))?;
        Ok(Self { name, n, properties: Vec::new() })
    }
}

impl<'a> Property<'a> {
    fn new(words: &[&'a [u8]]) -> Result<Self, String> {
        match *words {
            [b"list", count, scalar, name] => {
                let (count, scalar) = (Scalar::named(count)?, Scalar::named(scalar)?);
                Ok(Self { name, count: Some(count), scalar })
            }
            [scalar, name] => Ok(Self { name, count: None, scalar: Scalar::named(scalar)? }),
            _ => Err("a property has a type and a name, or is a list of such".to_owned()),
        }
    }
}
