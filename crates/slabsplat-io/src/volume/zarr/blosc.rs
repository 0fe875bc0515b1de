//! Blosc 1: a buffer cut into blocks, each with its bytes or bits sorted by their place in an item, and
//! packed.
//!
//! Format: <https://github.com/Blosc/c-blosc/blob/main/README_CHUNK_FORMAT.rst>. Not read: Snappy, which is
//! rare.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;

/// A buffer that is unpacked block by block.
pub(super) struct Blosc {
    packed: Vec<u8>,
    header: Header,
    block_idx: usize,
    block: Vec<u8>,
    n_taken: usize,
}

struct Header {
    flags: u8,
    item_bytes: usize,
    n_bytes: usize,
    block_bytes: usize,
}

/// Blocks are unpacked into memory one by one, and made as large as a processor's cache.
const MAX_BLOCK_BYTES: usize = 256 << 20;

const N_HEADER_BYTES: usize = 16;
const SHUFFLED: u8 = 1;
const COPIED: u8 = 2;
const BIT_SHUFFLED: u8 = 4;
const WHOLE: u8 = 16;

impl Blosc {
    /// Of a buffer that should unpack to `n_bytes`.
    pub(super) fn open(packed: Vec<u8>, n_bytes: u64) -> io::Result<Self> {
        let too_short = || invalid("it is too short for Blosc");
        let header = packed.get(..N_HEADER_BYTES).ok_or_else(too_short)?;
        let header = Header {
            flags: header[2],
            item_bytes: usize::from(header[3]).max(1),
            n_bytes: number(header, 4).ok_or_else(too_short)?,
            block_bytes: number(header, 8).ok_or_else(too_short)?,
        };
        if header.n_bytes as u64 != n_bytes {
            return Err(invalid("it holds another number of bytes than its shape"));
        }
        if 0 < header.n_bytes && header.block_bytes == 0 {
            return Err(invalid("its blocks are empty"));
        }
        if MAX_BLOCK_BYTES < header.n_bytes.min(header.block_bytes) {
            return Err(invalid("its blocks are larger than 256 MiB"));
        }
        Ok(Self { packed, header, block_idx: 0, block: Vec::new(), n_taken: 0 })
    }

    /// Unpacks the next block; `false` if there is none.
    fn unpack(&mut self) -> io::Result<bool> {
        let Header { flags, item_bytes, n_bytes, block_bytes } = self.header;
        let start = self.block_idx.saturating_mul(block_bytes);
        if n_bytes <= start {
            return Ok(false);
        }
        let size = block_bytes.min(n_bytes - start);
        let broken = || invalid("it breaks off");
        self.n_taken = 0;
        if flags & COPIED != 0 {
            let at = N_HEADER_BYTES + start;
            self.block = self.packed.get(at..at + size).ok_or_else(broken)?.to_vec();
            self.block_idx += 1;
            return Ok(true);
        }
        let at = number(&self.packed, N_HEADER_BYTES + 4 * self.block_idx).ok_or_else(broken)?;
        let is_last_short = size < block_bytes;
        // Each byte of an item packed by itself, where blocks are long enough.
        let is_split = flags & WHOLE == 0
            && item_bytes <= 16
            && 128 <= block_bytes / item_bytes
            && !is_last_short;
        let n_parts = if is_split { item_bytes } else { 1 };
        let part_bytes = size / n_parts;
        let mut rest = self.packed.get(at..).ok_or_else(broken)?;
        let mut block = Vec::new();
        for _ in 0..n_parts {
            let n_packed = number(rest, 0).ok_or_else(broken)?;
            let part = rest.get(4..).and_then(|rest| rest.get(..n_packed)).ok_or_else(broken)?;
            if n_packed == part_bytes {
                block.extend(part);
            } else {
                unpack_part(part, flags >> 5, part_bytes, &mut block)?;
            }
            rest = &rest[4 + n_packed..];
        }
        if block.len() != size {
            return Err(invalid("a block unpacks to another length than it says"));
        }
        self.block = if flags & SHUFFLED != 0 && 1 < item_bytes {
            unshuffled(&block, item_bytes)
        } else if flags & BIT_SHUFFLED != 0 {
            bits_unshuffled(&block, item_bytes)
        } else {
            block
        };
        self.block_idx += 1;
        Ok(true)
    }
}

impl Read for Blosc {
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

fn unpack_part(part: &[u8], codec: u8, size: usize, block: &mut Vec<u8>) -> io::Result<()> {
    let n_before = block.len();
    match codec {
        0 => {
            unpack_blosclz(part, size, block).ok_or_else(|| invalid("BloscLZ cannot unpack it"))?;
        }
        1 => {
            // It packs 255 bytes into one at best.
            if part.len().saturating_mul(256) < size {
                return Err(invalid("LZ4 cannot unpack it"));
            }
            block.resize(n_before + size, 0);
            let n = lz4_flex::block::decompress_into(part, &mut block[n_before..])
                .map_err(|_| invalid("LZ4 cannot unpack it"))?;
            block.truncate(n_before + n);
        }
        3 => {
            ZlibDecoder::new(part).take(size as u64).read_to_end(block)?;
        }
        4 => {
            let decoder =
                ruzstd::decoding::StreamingDecoder::new(part).map_err(io::Error::other)?;
            decoder.take(size as u64).read_to_end(block)?;
        }
        _ => {
            return Err(invalid("it is packed by Snappy, which is not read: use LZ4 or Zstandard"));
        }
    }
    if block.len() - n_before != size {
        return Err(invalid("a block unpacks to less than it says"));
    }
    Ok(())
}

/// BloscLZ: literals, and matches of what came before; `None` if it breaks its rules.
fn unpack_blosclz(part: &[u8], size: usize, out: &mut Vec<u8>) -> Option<()> {
    const MAX_NEAR: usize = 8191;
    let end = out.len() + size;
    let start = out.len();
    let mut rest = part.iter();
    let mut control = usize::from(*rest.next()? & 31);
    loop {
        if control < 32 {
            let n = control + 1;
            let literals = rest.as_slice().get(..n)?;
            if end < out.len() + n {
                return None;
            }
            out.extend(literals);
            rest.nth(n - 1);
        } else {
            let mut len = (control >> 5) - 1;
            let mut far = (control & 31) << 8;
            if len == 6 {
                loop {
                    let more = usize::from(*rest.next()?);
                    len += more;
                    if more != 255 {
                        break;
                    }
                }
            }
            let near = usize::from(*rest.next()?);
            let mut back = far + near + 1;
            if near == 255 && far == 31 << 8 {
                far = usize::from(*rest.next()?) << 8;
                far += usize::from(*rest.next()?);
                back = far + MAX_NEAR + 1;
            }
            let from = out.len().checked_sub(back).filter(|from| start <= *from)?;
            if end < out.len() + len + 3 {
                return None;
            }
            for at in from..from + len + 3 {
                out.push(out[at]);
            }
        }
        match rest.next() {
            Some(next) => control = usize::from(*next),
            None => return Some(()),
        }
    }
}

/// First bytes of all items first; what is left of the last item as it is.
fn unshuffled(block: &[u8], item_bytes: usize) -> Vec<u8> {
    let n_items = block.len() / item_bytes;
    let mut bytes = block.to_vec();
    for byte_idx in 0..item_bytes {
        let plane = &block[byte_idx * n_items..][..n_items];
        for (item_idx, byte) in plane.iter().enumerate() {
            bytes[item_idx * item_bytes + byte_idx] = *byte;
        }
    }
    bytes
}

/// First bits of all items first; where they would not fill whole bytes, c-blosc leaves the block as it is.
fn bits_unshuffled(block: &[u8], item_bytes: usize) -> Vec<u8> {
    let n_items = block.len() / item_bytes;
    let mut bytes = block.to_vec();
    if !n_items.is_multiple_of(8) {
        return bytes;
    }
    bytes[..n_items * item_bytes].fill(0);
    let n_plane = n_items / 8;
    for bit_idx in 0..8 * item_bytes {
        for (eighth, bits) in block[bit_idx * n_plane..][..n_plane].iter().enumerate() {
            for bit in 0..8 {
                let item_idx = 8 * eighth + bit;
                bytes[item_idx * item_bytes + bit_idx / 8] |= (bits >> bit & 1) << (bit_idx % 8);
            }
        }
    }
    bytes
}

fn number(bytes: &[u8], at: usize) -> Option<usize> {
    let bytes = bytes.get(at..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*bytes) as usize)
}

fn invalid(what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}
