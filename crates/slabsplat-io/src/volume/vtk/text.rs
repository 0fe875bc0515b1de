//! Numbers in text, as the bytes that they would be in a binary file.

use std::io::{self, BufRead, Read};

use super::super::stored::StoredType;
use slabsplat_core::SampleType;

/// Bytes of numbers, in this machine's byte order. Ends at a `<`, as text in XML does.
pub(super) struct NumbersInText<R> {
    reader: R,
    stored: StoredType,
    /// Whether they are shares of the largest number of that type.
    are_shares: bool,
    token: Vec<u8>,
    bytes: Vec<u8>,
    n_taken: usize,
    /// What is no number, and comes after those in `bytes`, maybe after the last that is wanted.
    broken: Option<String>,
}

/// No number needs more digits: a 64-bit float written out in full has 1077.
const MAX_TOKEN_BYTES: usize = 2048;

/// Bytes that are made at once.
const CHUNK_BYTES: usize = 1 << 14;

impl<R: BufRead> NumbersInText<R> {
    pub(super) fn new(reader: R, stored: StoredType) -> Self {
        Self {
            reader,
            stored,
            are_shares: false,
            token: Vec::new(),
            bytes: Vec::new(),
            n_taken: 0,
            broken: None,
        }
    }

    /// Bytes that are written as shares of 255, as colours are.
    pub(super) fn of_shares(reader: R) -> Self {
        Self { are_shares: true, ..Self::new(reader, StoredType::U8_SAMPLE) }
    }

    fn fill(&mut self) -> io::Result<()> {
        self.bytes.clear();
        self.n_taken = 0;
        if let Some(what) = self.broken.take() {
            return Err(io::Error::new(io::ErrorKind::InvalidData, what));
        }
        while self.bytes.len() < CHUNK_BYTES && next_token(&mut self.reader, &mut self.token)? {
            let token = str::from_utf8(&self.token).unwrap_or("\u{fffd}");
            let pushed = match self.are_shares {
                true => push_share(&mut self.bytes, token),
                false => push(&mut self.bytes, token, self.stored),
            };
            if pushed.is_none() {
                let shown: String = token.chars().take(40).collect();
                let what = format!("{shown:?} is not a number of {}", self.stored.name());
                if self.bytes.is_empty() {
                    return Err(io::Error::new(io::ErrorKind::InvalidData, what));
                }
                self.broken = Some(what);
                break;
            }
        }
        Ok(())
    }
}

/// Reads a run of bytes without blanks; `false` if there is none before a `<` or the end.
pub(super) fn next_token(reader: &mut impl BufRead, token: &mut Vec<u8>) -> io::Result<bool> {
    token.clear();
    loop {
        let bytes = reader.fill_buf()?;
        let Some(&first) = bytes.first() else { break };
        if token.is_empty() && first.is_ascii_whitespace() {
            let n = bytes.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            reader.consume(n);
            continue;
        }
        let is_end = |byte: &u8| byte.is_ascii_whitespace() || *byte == b'<';
        let n = bytes.iter().position(is_end).unwrap_or(bytes.len());
        let ends_here = n < bytes.len();
        token.extend(&bytes[..n]);
        reader.consume(n);
        if MAX_TOKEN_BYTES < token.len() {
            let what = "the data are not numbers in text";
            return Err(io::Error::new(io::ErrorKind::InvalidData, what));
        }
        if ends_here {
            break;
        }
    }
    Ok(!token.is_empty())
}

fn push_share(bytes: &mut Vec<u8>, token: &str) -> Option<()> {
    let share: f64 = token.parse().ok()?;
    bytes.push((255.0 * share.clamp(0.0, 1.0)).round() as u8);
    Some(())
}

fn push(bytes: &mut Vec<u8>, token: &str, stored: StoredType) -> Option<()> {
    use SampleType::{F32, F64, I8, I16, I32, U8, U16, U32};
    match stored {
        StoredType::Sample(U8) => bytes.extend(token.parse::<u8>().ok()?.to_ne_bytes()),
        StoredType::Sample(I8) => bytes.extend(token.parse::<i8>().ok()?.to_ne_bytes()),
        StoredType::Sample(U16) => bytes.extend(token.parse::<u16>().ok()?.to_ne_bytes()),
        StoredType::Sample(I16) => bytes.extend(token.parse::<i16>().ok()?.to_ne_bytes()),
        StoredType::Sample(U32) => bytes.extend(token.parse::<u32>().ok()?.to_ne_bytes()),
        StoredType::Sample(I32) => bytes.extend(token.parse::<i32>().ok()?.to_ne_bytes()),
        StoredType::Sample(F32) => bytes.extend(token.parse::<f32>().ok()?.to_ne_bytes()),
        StoredType::Sample(F64) => bytes.extend(token.parse::<f64>().ok()?.to_ne_bytes()),
        StoredType::I64 => bytes.extend(token.parse::<i64>().ok()?.to_ne_bytes()),
        StoredType::U64 => bytes.extend(token.parse::<u64>().ok()?.to_ne_bytes()),
        StoredType::F16 => return None,
    }
    Some(())
}

impl<R: BufRead> Read for NumbersInText<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.n_taken == self.bytes.len() {
            self.fill()?;
        }
        let n = bytes.len().min(self.bytes.len() - self.n_taken);
        bytes[..n].copy_from_slice(&self.bytes[self.n_taken..self.n_taken + n]);
        self.n_taken += n;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(text: &str, stored: &str) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let mut numbers = NumbersInText::new(text.as_bytes(), StoredType::named(stored).unwrap());
        numbers.read_to_end(&mut bytes).map_err(|error| error.to_string())?;
        Ok(bytes)
    }

    #[test]
    fn text_becomes_bytes() {
        assert_eq!(bytes(" 1\n255\t0 </x>9", "uint8").unwrap(), [1, 255, 0]);
        let floats = [0.5_f32, f32::NAN, f32::NEG_INFINITY].map(f32::to_ne_bytes).concat();
        assert_eq!(bytes("0.5 nan -inf", "float32").unwrap(), floats);
        assert_eq!(bytes("-7", "int64").unwrap(), (-7_i64).to_ne_bytes());
        let many = "12 ".repeat(50_000);
        assert_eq!(bytes(&many, "int8").unwrap(), vec![12; 50_000]);
        assert!(bytes("1 x", "int8").unwrap_err().contains("\"x\" is not a number of int8"));
        assert!(bytes("1 300", "uint8").is_err());
        assert!(bytes(&"1".repeat(5000), "float64").is_err());
    }
}
