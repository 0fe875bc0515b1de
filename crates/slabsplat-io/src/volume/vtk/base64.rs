//! Bytes from base64 (RFC 4648 §4), as they are read. Units that end in padding may follow each other, as
//! the parts of an array in VTK's XML do.

use std::io::{self, Read};

/// Bytes decoded from what another reader has; ends where that has something else than base64.
pub(super) struct Base64<R> {
    reader: R,
    text: Box<[u8]>,
    n_text: usize,
    at: usize,
    decoded: [u8; 3],
    n_decoded: usize,
    n_taken: usize,
}

const PADDING: u8 = 64;
const BLANK: u8 = 65;
const OTHER: u8 = 66;

const VALUES: [u8; 256] = {
    let mut values = [OTHER; 256];
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/=";
    let mut idx = 0;
    while idx < digits.len() {
        values[digits[idx] as usize] = idx as u8;
        idx += 1;
    }
    values[b' ' as usize] = BLANK;
    values[b'\n' as usize] = BLANK;
    values[b'\r' as usize] = BLANK;
    values[b'\t' as usize] = BLANK;
    values
};

impl<R: Read> Base64<R> {
    pub(super) fn new(reader: R) -> Self {
        Self {
            reader,
            text: vec![0; 1 << 14].into(),
            n_text: 0,
            at: 0,
            decoded: [0; 3],
            n_decoded: 0,
            n_taken: 0,
        }
    }

    /// The next character's value; `None` where base64 ends.
    fn next(&mut self) -> io::Result<Option<u8>> {
        loop {
            if self.at == self.n_text {
                self.n_text = self.reader.read(&mut self.text)?;
                self.at = 0;
                if self.n_text == 0 {
                    return Ok(None);
                }
            }
            match VALUES[usize::from(self.text[self.at])] {
                BLANK => self.at += 1,
                OTHER => return Ok(None),
                value => {
                    self.at += 1;
                    return Ok(Some(value));
                }
            }
        }
    }

    /// Decodes four characters; `false` at the end.
    fn decode(&mut self) -> io::Result<bool> {
        let mut values = [PADDING; 4];
        for value in &mut values {
            match self.next()? {
                Some(next) => *value = next,
                None => break,
            }
        }
        let n_values = values.iter().take_while(|value| **value != PADDING).count();
        self.n_taken = 0;
        self.n_decoded = n_values.saturating_sub(1);
        let bits = values.iter().fold(0_u32, |bits, value| bits << 6 | u32::from(value & 63));
        self.decoded.copy_from_slice(&bits.to_be_bytes()[1..]);
        Ok(0 < self.n_decoded)
    }

    /// Decodes as many whole groups as the text at hand has, straight to where they belong.
    fn decode_many(&mut self, bytes: &mut [u8]) -> usize {
        let mut n_done = 0;
        while n_done + 3 <= bytes.len()
            && let Some(group) = self.text[self.at..self.n_text].first_chunk::<4>()
        {
            let values = group.map(|c| VALUES[usize::from(c)]);
            if values.iter().any(|value| PADDING <= *value) {
                break;
            }
            let bits = values.iter().fold(0_u32, |bits, value| bits << 6 | u32::from(*value));
            bytes[n_done..n_done + 3].copy_from_slice(&bits.to_be_bytes()[1..]);
            self.at += 4;
            n_done += 3;
        }
        n_done
    }
}

impl<R: Read> Read for Base64<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let mut n_read = 0;
        while n_read < bytes.len() {
            if self.n_taken == self.n_decoded {
                n_read += self.decode_many(&mut bytes[n_read..]);
                if n_read == bytes.len() || !self.decode()? {
                    break;
                }
            }
            let n_now = (self.n_decoded - self.n_taken).min(bytes.len() - n_read);
            bytes[n_read..n_read + n_now]
                .copy_from_slice(&self.decoded[self.n_taken..self.n_taken + n_now]);
            self.n_taken += n_now;
            n_read += n_now;
        }
        Ok(n_read)
    }
}

#[cfg(test)]
pub(super) fn encoded(bytes: &[u8]) -> String {
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let mut three = [0; 3];
        three[..group.len()].copy_from_slice(group);
        let bits = u32::from_be_bytes([0, three[0], three[1], three[2]]);
        for digit in 0..4 {
            let is_padding = group.len() < digit;
            let value = (bits >> (18 - 6 * digit) & 63) as usize;
            text.push(if is_padding { '=' } else { char::from(digits[value]) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    fn decoded(text: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        Base64::new(text.as_bytes()).read_to_end(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn base64_of_the_standard() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9v\n  YmFy</x", "foobar"),
            ("Zg==Zm9vYg==", "ffoob"),
        ] {
            assert_eq!(decoded(text), bytes.as_bytes(), "{text}");
        }
    }

    #[test]
    fn base64_round_trip_in_pieces() {
        for_each_seed(20, |mut rng| {
            let n_bytes = rng.usize(0..40_000);
            let bytes: Vec<u8> = (0..n_bytes).map(|_| rng.u8(..)).collect();
            let text = encoded(&bytes);
            let mut reader = Base64::new(text.as_bytes());
            let mut got: Vec<u8> = Vec::new();
            loop {
                let mut piece = vec![0; rng.usize(1..9000)];
                let n = reader.read(&mut piece).unwrap();
                if n == 0 {
                    break;
                }
                got.extend(&piece[..n]);
            }
            assert_eq!(got, bytes);
        });
    }
}
