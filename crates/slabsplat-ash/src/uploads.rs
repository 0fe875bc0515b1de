//! Bytes on their way to the device: packed into one buffer that the processor writes, and copied on from
//! there.

use crate::buffers::Buffers;
use crate::commands::{Barrier, Commands};
use crate::memory::Buffer;
use ash::vk;
use slabsplat_gpu::{BufferId, Write};

/// Bytes of a write, or of a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chunk<'a> {
    pub(crate) buffer: BufferId,
    pub(crate) offset: u64,
    pub(crate) bytes: &'a [u8],
}

/// Writes in pieces of at most `max_bytes`, a multiple of 4. All but the last have as many.
pub(crate) fn pieces<'a>(writes: &'a [Write<'_>], max_bytes: usize) -> Vec<Vec<Chunk<'a>>> {
    let mut pieces = Vec::new();
    let mut piece = Vec::new();
    let mut room = max_bytes;
    for write in writes {
        let mut offset = write.offset;
        let mut rest = &*write.bytes;
        while !rest.is_empty() {
            let (bytes, after) = rest.split_at(rest.len().min(room));
            piece.push(Chunk { buffer: write.buffer, offset, bytes });
            offset += bytes.len() as u64;
            room -= bytes.len();
            rest = after;
            if room == 0 {
                pieces.push(std::mem::take(&mut piece));
                room = max_bytes;
            }
        }
    }
    if !piece.is_empty() {
        pieces.push(piece);
    }
    pieces
}

/// Bytes that a piece takes.
pub(crate) fn n_bytes(chunks: &[Chunk<'_>]) -> u64 {
    chunks.iter().map(|chunk| chunk.bytes.len() as u64).sum()
}

/// Puts a piece into `staging` and records the copies from there, in order.
pub(crate) fn record(
    commands: &mut Commands,
    staging: &mut Buffer,
    chunks: &[Chunk<'_>],
    buffers: &Buffers,
) {
    // Copies of one command, and commands without a barrier between, have no order.
    let must_be_ordered = overlap(chunks);
    let mut start = 0;
    let mut ranges = Vec::new();
    let same_copy =
        |one: &Chunk<'_>, next: &Chunk<'_>| !must_be_ordered && one.buffer == next.buffer;
    for (nth, group) in chunks.chunk_by(same_copy).enumerate() {
        if must_be_ordered && 0 < nth {
            commands.barrier(Barrier::BETWEEN_COPIES);
        }
        ranges.clear();
        for chunk in group {
            staging.write(start, chunk.bytes);
            let size = chunk.bytes.len() as u64;
            let range = vk::BufferCopy { src_offset: start, dst_offset: chunk.offset, size };
            ranges.push(range);
            start += size;
        }
        commands.copy(staging, buffers.get(group[0].buffer), &ranges);
    }
}

/// If two chunks go to the same offset.
fn overlap(chunks: &[Chunk<'_>]) -> bool {
    let mut sorted: Vec<_> = chunks.iter().collect();
    sorted.sort_unstable_by_key(|chunk| (chunk.buffer, chunk.offset));
    sorted.windows(2).any(|pair| {
        let end = pair[0].offset + pair[0].bytes.len() as u64;
        pair[0].buffer == pair[1].buffer && pair[1].offset < end
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(buffer: u32, offset: u64, bytes: &[u8]) -> Write<'_> {
        Write { buffer: BufferId(buffer), offset, bytes: bytes.into() }
    }

    #[test]
    fn pieces_keep_order_and_offsets() {
        let bytes: Vec<u8> = (0..40).collect();
        let writes = [write(0, 4, &bytes[..4]), write(1, 0, &[]), write(2, 100, &bytes[4..])];
        let pieces = pieces(&writes, 16);
        let sizes: Vec<_> = pieces.iter().map(|piece| n_bytes(piece)).collect();
        assert_eq!(sizes, [16, 16, 8]);
        let chunk = |buffer, offset, bytes| Chunk { buffer: BufferId(buffer), offset, bytes };
        assert_eq!(pieces[0], [chunk(0, 4, &bytes[..4]), chunk(2, 100, &bytes[4..16])]);
        assert_eq!(pieces[1], [chunk(2, 112, &bytes[16..32])]);
        assert_eq!(pieces[2], [chunk(2, 128, &bytes[32..])]);
    }

    #[test]
    fn pieces_of_nothing_are_none() {
        assert!(pieces(&[], 16).is_empty());
        assert!(pieces(&[write(0, 0, &[])], 16).is_empty());
    }

    #[test]
    fn overlap_minds_buffers_and_ends() {
        let bytes = [0; 8];
        let check = |writes: &[Write<'_>], expected| {
            assert_eq!(overlap(&pieces(writes, 1024).concat()), expected, "{writes:?}");
        };
        check(&[write(0, 0, &bytes), write(0, 8, &bytes)], false);
        check(&[write(0, 0, &bytes), write(1, 4, &bytes)], false);
        check(&[write(0, 4, &bytes), write(1, 0, &bytes), write(0, 0, &bytes)], true);
    }
}
