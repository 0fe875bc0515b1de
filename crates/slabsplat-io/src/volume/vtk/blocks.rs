//! The packed blocks that an array in VTK's XML is cut into: their number, the bytes of each unpacked and of
//! the last, the packed bytes of each, and then the blocks.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;

use super::super::Endian;
use super::super::stream::MAX_GZIP_RATIO;

/// How blocks are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
}

/// The words in front of an array: 32 bits or 64, in the file's byte order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Words {
    pub(super) n_bytes: usize,
    pub(super) endian: Endian,
}

/// The bytes of an array, block by block.
pub(super) struct Blocks<R> {
    reader: R,
    compressor: Compressor,
    /// Unpacked bytes of each block but the last, and of the last.
    sizes: [u64; 2],
    /// Packed bytes of each block, the last first.
    n_packed: Vec<u64>,
    packed: Vec<u8>,
    block: Vec<u8>,
    n_taken: usize,
}

/// VTK's default is 32 KiB; a block is in memory whole.
const MAX_BLOCK_BYTES: u64 = 1 << 30;

impl Words {
    pub(super) fn read(self, reader: &mut impl Read) -> io::Result<u64> {
        let mut bytes = [0; 8];
        let word = &mut bytes[..self.n_bytes];
        reader.read_exact(word)?;
        if self.endian == Endian::Big {
            word.reverse();
        }
        Ok(u64::from_le_bytes(bytes))
    }
}

impl<R: Read> Blocks<R> {
    /// Reads the words in front; no more than `n_left` bytes can follow.
    pub(super) fn open(
        mut reader: R,
        compressor: Compressor,
        words: Words,
        n_left: u64,
    ) -> io::Result<Self> {
        let n_blocks = words.read(&mut reader)?;
        let size = words.read(&mut reader)?;
        let last = words.read(&mut reader)?;
        if n_left / (words.n_bytes as u64) < n_blocks || MAX_BLOCK_BYTES < size || size < last {
            return Err(invalid("the blocks of the array cannot be that many, or that large"));
        }
        let n_packed = (0..n_blocks).map(|_| words.read(&mut reader));
        let mut n_packed = n_packed.collect::<io::Result<Vec<u64>>>()?;
        n_packed.reverse();
        let sizes = [size, if last == 0 { size } else { last }];
        let (packed, block) = (Vec::new(), Vec::new());
        Ok(Self { reader, compressor, sizes, n_packed, packed, block, n_taken: 0 })
    }

    /// Unpacks the next block; `false` if there is none.
    fn unpack(&mut self) -> io::Result<bool> {
        let Some(n_packed) = self.n_packed.pop() else { return Ok(false) };
        let size = self.sizes[usize::from(self.n_packed.is_empty())];
        self.packed.clear();
        let n_read = self.reader.by_ref().take(n_packed).read_to_end(&mut self.packed)? as u64;
        if n_read < n_packed {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        if n_packed.saturating_mul(MAX_GZIP_RATIO) < size {
            return Err(invalid("a block of the array is too short to unpack to what it says"));
        }
        self.block.clear();
        self.n_taken = 0;
        match self.compressor {
            Compressor::Zlib => {
                ZlibDecoder::new(self.packed.as_slice())
                    .take(size)
                    .read_to_end(&mut self.block)
                    .map_err(|_| invalid("a block of the array cannot be unpacked by zlib"))?;
            }
            Compressor::Lz4 => {
                self.block.resize(size as usize, 0);
                let n = lz4_flex::block::decompress_into(&self.packed, &mut self.block)
                    .map_err(|_| invalid("a block of the array cannot be unpacked by LZ4"))?;
                self.block.truncate(n);
            }
        }
        if (self.block.len() as u64) < size {
            return Err(invalid("a block of the array unpacks to less than it says"));
        }
        Ok(true)
    }
}

impl<R: Read> Read for Blocks<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        while self.n_taken == self.block.len() {
            if !self.unpack()? {
                return Ok(0);
            }
        }
        let n = bytes.len().min(self.block.len() - self.n_taken);
        bytes[..n].copy_from_slice(&self.block[self.n_taken..self.n_taken + n]);
        self.n_taken += n;
        Ok(n)
    }
}

fn invalid(what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}
