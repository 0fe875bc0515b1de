//! What unpacks the bytes of a chunk.

use std::io::{self, BufReader, Cursor, Read};

use flate2::bufread::{MultiGzDecoder, ZlibDecoder};

use super::super::placed::Source;
use super::blosc::Blosc;
use super::meta::Codec;

/// Bytes on their way through codecs.
pub(super) struct Unpacked<'r>(Box<dyn Read + 'r>);

impl Read for Unpacked<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.0.read(bytes)
    }
}

impl Source for Unpacked<'_> {}

/// The bytes of a chunk of `n_bytes`.
pub(super) fn unpacked<'r>(
    packed: impl Read + 'r,
    codecs: &[Codec],
    n_bytes: u64,
) -> io::Result<Unpacked<'r>> {
    let mut reader: Box<dyn Read + 'r> = Box::new(packed);
    for codec in codecs.iter().rev() {
        reader = match codec {
            Codec::Gzip => Box::new(MultiGzDecoder::new(BufReader::new(reader))),
            Codec::Zlib => Box::new(ZlibDecoder::new(BufReader::new(reader))),
            Codec::Zstd => {
                let decoder = ruzstd::decoding::StreamingDecoder::new(BufReader::new(reader));
                Box::new(decoder.map_err(io::Error::other)?)
            }
            Codec::Blosc => Box::new(Blosc::open(read_whole(reader, n_bytes)?, n_bytes)?),
            Codec::Crc32c => Box::new(Cursor::new(without_sum(read_whole(reader, n_bytes)?)?)),
        };
    }
    Ok(Unpacked(reader))
}

/// All bytes of a packed chunk, which cannot be much longer than when it is unpacked.
fn read_whole(reader: impl Read, n_bytes: u64) -> io::Result<Vec<u8>> {
    let n_most = n_bytes.saturating_add(n_bytes / 8).saturating_add(1 << 16);
    let mut bytes = Vec::new();
    reader.take(n_most + 1).read_to_end(&mut bytes)?;
    if n_most < bytes.len() as u64 {
        return Err(io::Error::other("it is longer than the samples that it should hold"));
    }
    Ok(bytes)
}

fn without_sum(mut bytes: Vec<u8>) -> io::Result<Vec<u8>> {
    let n_bytes =
        bytes.len().checked_sub(4).ok_or_else(|| io::Error::other("it has no checksum"))?;
    let sum = bytes.split_off(n_bytes);
    if crc32c(&bytes).to_le_bytes() != sum.as_slice() {
        return Err(io::Error::other("it is damaged: its checksum is another"));
    }
    Ok(bytes)
}

const CRC_TABLE: [u32; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0x82f6_3b78 } else { crc >> 1 };
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
};

/// The sum of RFC 3720, appendix B.4.
pub(super) fn crc32c(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc: u32, byte| crc >> 8 ^ CRC_TABLE[usize::from(crc as u8 ^ byte)])
}
