//! The bits of a scan, and the codes of limited length that they are (T.87 §A.5.3, §C.1).

use super::super::segments::Broken;

const CUT_OFF: Broken = "it is cut off";

/// The bits of a scan up to a marker.
pub(super) struct Bits<'p> {
    bytes: &'p [u8],
    at: usize,
    /// Bits that are left, at the upper end; zeros after them.
    word: u64,
    n_bits: u32,
}

impl<'p> Bits<'p> {
    pub(super) fn of(bytes: &'p [u8]) -> Self {
        Self { bytes, at: 0, word: 0, n_bits: 0 }
    }

    /// Bytes that were taken. Those that follow are a marker, or have not been asked for.
    pub(super) fn n_read(&self) -> usize {
        self.at - (self.n_bits / 8) as usize
    }

    /// An unsigned number of up to 16 bits.
    pub(super) fn read(&mut self, n_bits: u32) -> Result<u32, Broken> {
        if n_bits == 0 {
            return Ok(0);
        }
        self.fill();
        let number = self.word >> (64 - n_bits);
        self.take(n_bits)?;
        Ok(number as u32)
    }

    /// Counts zeros up to a one, which is passed over, too.
    fn zeros(&mut self, n_most: u32) -> Result<u32, Broken> {
        self.fill();
        let n_zeros = self.word.leading_zeros().min(self.n_bits);
        // More than there are, since 49 bits are there at least but at the end.
        if n_zeros == self.n_bits || n_most < n_zeros {
            return self.many_zeros(n_most);
        }
        self.take(n_zeros + 1)?;
        Ok(n_zeros)
    }

    /// The same, a bit after the other.
    fn many_zeros(&mut self, n_most: u32) -> Result<u32, Broken> {
        for n_zeros in 0..=n_most {
            if self.read(1)? == 1 {
                return Ok(n_zeros);
            }
        }
        Err("it has a code that is too long")
    }

    /// A number that is mostly small: its upper bits as so many zeros, and its `k` lower ones. If the zeros
    /// would be too many for `limit` bits in all, it is written in `n_bits` after as many as there may be.
    pub(super) fn golomb(&mut self, k: u32, limit: u32, n_bits: u32) -> Result<i32, Broken> {
        let n_most = limit - n_bits - 1;
        let n_zeros = self.zeros(n_most)?;
        Ok(if n_zeros < n_most {
            (n_zeros << k | self.read(k)?) as i32
        } else {
            self.read(n_bits)? as i32 + 1
        })
    }

    fn take(&mut self, n_bits: u32) -> Result<(), Broken> {
        self.n_bits = self.n_bits.checked_sub(n_bits).ok_or(CUT_OFF)?;
        self.word <<= n_bits;
        Ok(())
    }

    /// Takes bytes while a whole one has room. After a byte of ones the highest bit of the next is no part
    /// of the scan, and if it is set, both are a marker.
    fn fill(&mut self) {
        while self.n_bits <= 56 {
            let last = self.at.checked_sub(1).map(|at| self.bytes[at]);
            let n_new = if last == Some(0xff) { 7 } else { 8 };
            match self.bytes.get(self.at..).unwrap_or_default() {
                [] | [0xff] | [0xff, 0x80..=0xff, ..] => return,
                [byte, ..] => {
                    let new = u64::from(*byte) & ((1 << n_new) - 1);
                    self.word |= new << (64 - n_new - self.n_bits);
                    self.n_bits += n_new;
                    self.at += 1;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_after_a_byte_of_ones() {
        let mut bits = Bits::of(&[0xff, 0x7f, 0x80, 0xff, 0xd9]);
        assert_eq!(bits.read(15), Ok(0x7fff));
        assert_eq!(bits.read(8), Ok(0x80));
        assert_eq!(bits.read(1), Err(CUT_OFF));
        assert_eq!(bits.n_read(), 3);
    }

    #[test]
    fn golomb_codes() {
        // 0 001 01 → two zeros and the lower bits 01; 0001 and 1010 after too many zeros.
        let mut bits = Bits::of(&[0b0010_1000, 0b1101_0000]);
        assert_eq!(bits.golomb(2, 32, 8), Ok(2 << 2 | 1));
        assert_eq!(bits.golomb(0, 8, 4), Ok(0b1010 + 1));
        let mut zeros = Bits::of(&[0; 9]);
        assert_eq!(zeros.golomb(0, 64, 8), Err("it has a code that is too long"));
        assert_eq!(zeros.golomb(0, 64, 8), Err(CUT_OFF));
    }
}
