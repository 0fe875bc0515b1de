//! The header of an array: the text of a Python dictionary with three keys.

use std::io::{self, Read};

use super::super::Endian;
use super::super::stored::StoredType;

/// What an array holds.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    pub(super) stored: StoredType,
    pub(super) endian: Endian,
    /// Whether the first axis is the fastest, not the last.
    pub(super) is_fortran: bool,
    /// Items along each axis.
    pub(super) shape: Vec<usize>,
    /// Bytes before the first item.
    pub(super) n_bytes: u64,
}

/// Why there is none.
#[derive(Debug, PartialEq)]
pub(super) enum HeaderError {
    Malformed(String),
    Unsupported(String),
}

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// NumPy writes 80 bytes; structured types have more.
const MAX_BYTES: u32 = 1 << 20;

impl Header {
    /// Reads up to the first item.
    pub(super) fn read(reader: &mut impl Read) -> io::Result<Result<Self, HeaderError>> {
        let cut_off = || Ok(Err(malformed("the header of the array is cut off")));
        let mut start = [0; 8];
        if !fill(reader, &mut start)? {
            return cut_off();
        }
        if !start.starts_with(MAGIC) {
            return Ok(Err(malformed("not a NumPy array: it does not begin as one")));
        }
        let n_length = match start[6] {
            1 => 2,
            2 | 3 => 4,
            version => {
                let what = format!("NumPy arrays of version {version} cannot be read");
                return Ok(Err(HeaderError::Unsupported(what)));
            }
        };
        let mut length = [0; 4];
        if !fill(reader, &mut length[..n_length])? {
            return cut_off();
        }
        let n_text = u32::from_le_bytes(length);
        if MAX_BYTES < n_text {
            return Ok(Err(malformed("the header of the array is longer than 1 MiB")));
        }
        let mut text = Vec::new();
        reader.by_ref().take(u64::from(n_text)).read_to_end(&mut text)?;
        if text.len() < n_text as usize {
            return cut_off();
        }
        let n_bytes = 8 + n_length as u64 + u64::from(n_text);
        Ok(Self::parse(&String::from_utf8_lossy(&text), n_bytes))
    }

    fn parse(text: &str, n_bytes: u64) -> Result<Self, HeaderError> {
        let broken =
            || malformed("the header of the array is no dictionary of descr, order and shape");
        let fields = fields(text).ok_or_else(broken)?;
        let field = |name: &str| {
            let field = fields.iter().find(|(key, _)| *key == name);
            field.map(|(_, value)| *value).ok_or_else(broken)
        };
        let (stored, endian) = stored_type(field("descr")?)?;
        let is_fortran = match field("fortran_order")? {
            "True" => true,
            "False" => false,
            _ => return Err(broken()),
        };
        let shape = field("shape")?.strip_prefix('(').and_then(|s| s.strip_suffix(')'));
        let lens = shape.ok_or_else(broken)?.split(',').map(str::trim);
        // Python 2 wrote long integers with an L.
        let lens = lens.filter(|len| !len.is_empty()).map(|len| len.trim_end_matches('L').parse());
        let shape = lens.collect::<Result<Vec<usize>, _>>().map_err(|_| broken())?;
        Ok(Self { stored, endian, is_fortran, shape, n_bytes })
    }
}

fn malformed(what: &str) -> HeaderError {
    HeaderError::Malformed(what.to_owned())
}

fn fill(reader: &mut impl Read, bytes: &mut [u8]) -> io::Result<bool> {
    match reader.read_exact(bytes) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}

/// Keys without their quotes, and the text of their values.
fn fields(text: &str) -> Option<Vec<(&str, &str)>> {
    let inside = text.trim().strip_prefix('{')?.strip_suffix('}')?;
    let parts = split_outside(inside, ',');
    let field = |part: &&'_ str| !part.trim().is_empty();
    parts
        .into_iter()
        .filter(field)
        .map(|part| {
            let [key, value] = split_outside(part, ':').try_into().ok()?;
            Some((unquoted(key.trim())?, value.trim()))
        })
        .collect()
}

/// Splits where `separator` is outside of brackets and quotes.
fn split_outside(text: &str, separator: char) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut start, mut depth, mut quote) = (0, 0_usize, None);
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), _) => quote = quote.filter(|_| c != open),
            (None, '\'' | '"') => quote = Some(c),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth = depth.saturating_sub(1),
            (None, _) if c == separator && depth == 0 => {
                parts.push(&text[start..at]);
                start = at + c.len_utf8();
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

fn unquoted(text: &str) -> Option<&str> {
    ['\'', '"'].iter().find_map(|&quote| text.strip_prefix(quote)?.strip_suffix(quote))
}

/// The type and the byte order of a description such as `'<f4'`.
fn stored_type(descr: &str) -> Result<(StoredType, Endian), HeaderError> {
    let unsupported = |what: String| Err(HeaderError::Unsupported(what));
    let Some(descr) = unquoted(descr) else {
        return unsupported("records of several fields are no samples: save one field".to_owned());
    };
    let (order, code) = match descr.chars().next() {
        Some(order @ ('<' | '>' | '=' | '|')) => (order, &descr[1..]),
        _ => ('=', descr),
    };
    let endian = if order == '>' { Endian::Big } else { Endian::Little };
    if let Some(stored) = StoredType::of_code(code) {
        return Ok((stored, endian));
    }
    let what = match code.chars().next() {
        Some('O') => "Python objects, which only Python can unpickle",
        Some('c') => "complex numbers: save their absolute values, or real parts",
        Some('S' | 'U' | 'a') => "text",
        Some('M' | 'm') => "times",
        Some('V') => "records: save one field",
        Some('f') => "floats of more than 64 bits: save them as float64",
        _ => return unsupported(format!("items of type {:?} are unknown", shown(code))),
    };
    unsupported(format!("items of type {:?} cannot be samples: they are {what}", shown(code)))
}

fn shown(code: &str) -> String {
    code.chars().take(20).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn npy_header_parses() {
        let check = |text: &str, code: &str, endian, is_fortran, shape: &[usize]| {
            let header = Header::parse(text, 128).unwrap();
            let stored = StoredType::of_code(code).unwrap();
            let shape = shape.to_vec();
            assert_eq!(
                header,
                Header { stored, endian, is_fortran, shape, n_bytes: 128 },
                "{text}"
            );
        };
        let text = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), }        \n";
        check(text, "f4", Endian::Little, false, &[3, 4, 5]);
        let text = "{\"shape\":(3L,),'fortran_order':True,'descr':'>u2'}";
        check(text, "u2", Endian::Big, true, &[3]);
        let text = "{'descr': '|b1', 'fortran_order': False, 'shape': ()}";
        check(text, "b1", Endian::Little, false, &[]);
    }

    #[test]
    fn npy_header_refuses() {
        let check = |descr: &str, rest: &str, expected: &str| {
            let error = Header::parse(&format!("{{'descr': {descr}, {rest}}}"), 0).unwrap_err();
            let (HeaderError::Malformed(what) | HeaderError::Unsupported(what)) = error;
            assert!(what.contains(expected), "{what}");
        };
        let rest = "'fortran_order': False, 'shape': (3, 4, 5)";
        check("'|O'", rest, "Python objects");
        check("'<c8'", rest, "complex numbers");
        check("'<U7'", rest, "they are text");
        check("'<f16'", rest, "more than 64 bits");
        check("'<M8[ns]'", rest, "times");
        check("'|V5'", rest, "records");
        check("'<x9'", rest, "\"x9\" are unknown");
        check("[('a', '<f4'), ('b', '<i2', (2,))]", rest, "several fields");
        for rest in ["'shape': (3,)", "'fortran_order': 1, 'shape': (3,)", "}"] {
            check("'<f4'", rest, "no dictionary");
        }
        check("'<f4'", "'fortran_order': False, 'shape': (3, -4, 5)", "no dictionary");
        check("'<f4'", "'fortran_order': False, 'shape': 3", "no dictionary");
    }
}
