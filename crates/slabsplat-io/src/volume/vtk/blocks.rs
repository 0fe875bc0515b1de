//! The packed blocks that an array in VTK's XML is cut into: their number, the bytes of each unpacked and of
//! the last, the packed bytes of each, and then the blocks.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;

use super::super::Endian;
use super::super::parallel;
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

/// The bytes of an array, some blocks at a time.
pub(super) struct Blocks<R> {
    reader: R,
    compressor: Compressor,
    /// Unpacked bytes of each block but the last, and of the last.
    sizes: [u64; 2],
    /// Packed bytes of each block, the last first.
    n_packed: Vec<u64>,
    /// How many are unpacked at once.
    n_workers: usize,
    /// Unpacked blocks, and how much of them was read.
    unpacked: Vec<u8>,
    n_taken: usize,
    /// What is wrong with the block behind them.
    failure: Option<io::Error>,
}

/// A block as it is in the file, and what it unpacks to.
struct Packed {
    bytes: Vec<u8>,
    unpacked_bytes: u64,
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
        let n_workers = parallel::n_workers(n_packed.len());
        let (unpacked, n_taken, failure) = (Vec::new(), 0, None);
        Ok(Self { reader, compressor, sizes, n_packed, n_workers, unpacked, n_taken, failure })
    }

    /// Unpacks the next blocks, up to the first that cannot be; `false` if there is none.
    fn unpack(&mut self) -> io::Result<bool> {
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        self.unpacked.clear();
        self.n_taken = 0;
        let packed = self.read_packed();
        let compressor = self.compressor;
        let unpacked = parallel::in_order(
            &mut vec![(); self.n_workers],
            &packed,
            |(), block| block.unpack(compressor),
            |_, block| {
                self.unpacked.extend(block);
                Ok(())
            },
        );
        if let Err(failure) = unpacked {
            self.failure = Some(failure);
        }
        Ok(!packed.is_empty() || self.failure.is_some())
    }

    /// The next blocks that are there, one for each worker.
    fn read_packed(&mut self) -> Vec<Packed> {
        let mut blocks = Vec::new();
        while blocks.len() < self.n_workers
            && let Some(n_packed) = self.n_packed.pop()
        {
            let unpacked_bytes = self.sizes[usize::from(self.n_packed.is_empty())];
            match read_exactly(&mut self.reader, n_packed) {
                Ok(bytes) => blocks.push(Packed { bytes, unpacked_bytes }),
                Err(failure) => {
                    self.failure = Some(failure);
                    break;
                }
            }
        }
        blocks
    }
}

/// So many bytes; memory grows with what comes.
fn read_exactly(reader: &mut impl Read, n_bytes: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let n_read = reader.take(n_bytes).read_to_end(&mut bytes)? as u64;
    if n_read < n_bytes {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(bytes)
}

impl Packed {
    fn unpack(&self, compressor: Compressor) -> io::Result<Vec<u8>> {
        let Self { ref bytes, unpacked_bytes } = *self;
        if (bytes.len() as u64).saturating_mul(MAX_GZIP_RATIO) < unpacked_bytes {
            return Err(invalid("a block of the array is too short to unpack to what it says"));
        }
        let unpacked = match compressor {
            Compressor::Zlib => unpacked_by_zlib(bytes, unpacked_bytes)?,
            Compressor::Lz4 => unpacked_by_lz4(bytes, unpacked_bytes)?,
        };
        if (unpacked.len() as u64) < unpacked_bytes {
            return Err(invalid("a block of the array unpacks to less than it says"));
        }
        Ok(unpacked)
    }
}

fn unpacked_by_zlib(packed: &[u8], n_bytes: u64) -> io::Result<Vec<u8>> {
    let mut unpacked = Vec::new();
    let read = ZlibDecoder::new(packed).take(n_bytes).read_to_end(&mut unpacked);
    read.map_err(|_| invalid("a block of the array cannot be unpacked by zlib"))?;
    Ok(unpacked)
}

fn unpacked_by_lz4(packed: &[u8], n_bytes: u64) -> io::Result<Vec<u8>> {
    let mut unpacked = vec![0; n_bytes as usize];
    let n = lz4_flex::block::decompress_into(packed, &mut unpacked)
        .map_err(|_| invalid("a block of the array cannot be unpacked by LZ4"))?;
    unpacked.truncate(n);
    Ok(unpacked)
}

impl<R: Read> Read for Blocks<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        while self.n_taken == self.unpacked.len() {
            if !self.unpack()? {
                return Ok(0);
            }
        }
        let n = bytes.len().min(self.unpacked.len() - self.n_taken);
        bytes[..n].copy_from_slice(&self.unpacked[self.n_taken..self.n_taken + n]);
        self.n_taken += n;
        Ok(n)
    }
}

fn invalid(what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::ZlibEncoder;

    use super::*;

    const WORDS: Words = Words { n_bytes: 4, endian: Endian::Little };
    const BLOCK_BYTES: usize = 50;

    fn packed(block: &[u8], compressor: Compressor) -> Vec<u8> {
        match compressor {
            Compressor::Lz4 => lz4_flex::block::compress(block),
            Compressor::Zlib => {
                let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
                encoder.write_all(block).unwrap();
                encoder.finish().unwrap()
            }
        }
    }

    /// The array as it is in a file.
    fn stored(data: &[u8], compressor: Compressor) -> Vec<u8> {
        let blocks: Vec<_> =
            data.chunks(BLOCK_BYTES).map(|block| packed(block, compressor)).collect();
        let sizes = [blocks.len(), BLOCK_BYTES, data.len() % BLOCK_BYTES];
        let words = sizes.into_iter().chain(blocks.iter().map(Vec::len));
        let words = words.flat_map(|word| (word as u32).to_le_bytes());
        words.chain(blocks.concat()).collect()
    }

    /// What comes before the first failure, and that.
    fn unpacked(stored: &[u8], compressor: Compressor) -> (Vec<u8>, Option<String>) {
        let mut blocks =
            Blocks::open(stored, compressor, WORDS, stored.len() as u64).expect("words are there");
        let mut bytes = Vec::new();
        let failure = blocks.read_to_end(&mut bytes).err();
        (bytes, failure.map(|failure| failure.to_string()))
    }

    /// So many that they go to all threads, and the last is shorter.
    #[test]
    fn blocks_come_in_their_order_up_to_the_first_that_is_broken() {
        let data: Vec<u8> = (0..4019_u32).map(|n| (n * n / 7) as u8).collect();
        for compressor in [Compressor::Zlib, Compressor::Lz4] {
            let stored = stored(&data, compressor);
            assert_eq!(unpacked(&stored, compressor), (data.clone(), None), "{compressor:?}");
            let (bytes, failure) = unpacked(&stored[..stored.len() - 1], compressor);
            assert_eq!(bytes, data[..4000], "{compressor:?}");
            assert_eq!(failure.unwrap(), io::Error::from(io::ErrorKind::UnexpectedEof).to_string());
        }
        // The first byte of the 31st block, which zlib's header is.
        let mut stored = stored(&data, Compressor::Zlib);
        let n_packed =
            |idx: usize| u32::from_le_bytes(stored[12 + 4 * idx..][..4].try_into().unwrap());
        let at = 12 + 4 * 81 + (0..30).map(|idx| n_packed(idx) as usize).sum::<usize>();
        stored[at] = 0xff;
        let (bytes, failure) = unpacked(&stored, Compressor::Zlib);
        assert_eq!(bytes, data[..30 * BLOCK_BYTES]);
        assert!(failure.unwrap().contains("cannot be unpacked by zlib"));
    }
}
