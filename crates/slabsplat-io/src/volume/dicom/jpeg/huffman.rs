//! Bits of a scan, and the codes that they are (T.81 §C, §F.2.2).

use super::super::segments::Broken;

const CUT_OFF: Broken = "it is cut off";

/// The bits of a scan up to a marker.
pub(super) struct Bits<'p> {
    bytes: &'p [u8],
    at: usize,
    /// The last bits that were taken from bytes, of which `n_bits` are left.
    word: u32,
    n_bits: u32,
}

impl<'p> Bits<'p> {
    pub(super) fn of(bytes: &'p [u8]) -> Self {
        Self { bytes, at: 0, word: 0, n_bits: 0 }
    }

    /// An unsigned number of up to 16 bits, the first the highest.
    pub(super) fn read(&mut self, n_bits: u32) -> Result<u32, Broken> {
        while self.n_bits < n_bits {
            self.word = self.word << 8 | u32::from(self.next_byte()?);
            self.n_bits += 8;
        }
        self.n_bits -= n_bits;
        Ok(self.word >> self.n_bits & ((1 << n_bits) - 1))
    }

    /// A byte of the scan: a zero after a byte of ones is no part of it (§F.1.2.3).
    fn next_byte(&mut self) -> Result<u8, Broken> {
        match self.bytes.get(self.at..).unwrap_or_default() {
            [0xff, 0, ..] => {
                self.at += 2;
                Ok(0xff)
            }
            [0xff, ..] | [] => Err(CUT_OFF),
            [byte, ..] => {
                self.at += 1;
                Ok(*byte)
            }
        }
    }

    /// Goes on behind the restart marker that must be next (§F.2.2.5).
    pub(super) fn restart(&mut self) -> Result<(), Broken> {
        self.n_bits = 0;
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let n_fill = rest.iter().take_while(|byte| **byte == 0xff).count();
        match rest.get(n_fill) {
            Some(0xd0..=0xd7) if 0 < n_fill => {
                self.at += n_fill + 1;
                Ok(())
            }
            _ => Err("a restart marker is missing"),
        }
    }

    /// A number of so many bits, the lower half of which are negative ones (§F.2.2.1, EXTEND).
    pub(super) fn extended(&mut self, n_bits: u32) -> Result<i32, Broken> {
        if n_bits == 0 {
            return Ok(0);
        }
        let number = self.read(n_bits)? as i32;
        let half = 1 << (n_bits - 1);
        Ok(if number < half { number + 1 - 2 * half } else { number })
    }
}

/// Huffman codes.
#[derive(Clone, Debug)]
pub(super) struct Codes {
    /// Of each length from 1 bit on: the first code, how many there are, and where their symbols begin.
    lengths: [Codeword; 16],
    symbols: Vec<u8>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Codeword {
    first: u32,
    n: u32,
    symbols_from: usize,
}

impl Codes {
    /// Of how many codes each length has, and of their symbols (§C.2); the rest of `data` too.
    pub(super) fn of(data: &[u8]) -> Result<(Self, &[u8]), Broken> {
        let (counts, rest) = data.split_at_checked(16).ok_or(CUT_OFF)?;
        let mut lengths = [Codeword::default(); 16];
        let (mut code, mut n_symbols) = (0_u32, 0);
        for (length, &n) in lengths.iter_mut().zip(counts) {
            code <<= 1;
            *length = Codeword { first: code, n: u32::from(n), symbols_from: n_symbols };
            code += u32::from(n);
            n_symbols += usize::from(n);
        }
        let (symbols, rest) = rest.split_at_checked(n_symbols).ok_or(CUT_OFF)?;
        Ok((Self { lengths, symbols: symbols.to_vec() }, rest))
    }

    /// The symbol of the next code.
    pub(super) fn read(&self, bits: &mut Bits<'_>) -> Result<u8, Broken> {
        let mut code = 0;
        for length in &self.lengths {
            code = code << 1 | bits.read(1)?;
            let nth = code.wrapping_sub(length.first);
            if nth < length.n {
                return Ok(self.symbols[length.symbols_from + nth as usize]);
            }
        }
        Err("it has a code that stands for nothing")
    }
}
