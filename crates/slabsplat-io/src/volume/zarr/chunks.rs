//! The chunks that the volume has a part in, each unpacked to where its samples belong.

use std::io::{self, Read};
use std::sync::Arc;

use slabsplat_core::Samples;

use super::super::buffer::ReadFailure;
use super::super::formats::Input;
use super::super::parallel;
use super::super::placed::{Axis, PlacedSamples, Source};
use super::ChunkCache;
use super::codecs::{self, crc32c};
use super::image::Image;
use super::meta::{Chunks, Shard};
use super::tree::{Part, Tree};
use crate::IoError;
use crate::progress::ReadMeter;

/// Each is looked for, which takes a microsecond or two even if it is not there. The most voxels that a grid
/// has are as many chunks of 16³.
const MAX_CHUNKS: usize = 1 << 20;

/// A volume of so many bytes needs no chunks at all.
const MAX_UNBACKED_BYTES: u64 = 256 << 20;

/// Zstandard has packed zeros as well as this.
const MAX_RATIO: u64 = 1 << 15;

/// Chunks of a shard.
const MAX_IN_SHARD: usize = 1 << 24;

/// What an index says of a chunk that is not there.
const NONE: u64 = u64::MAX;

/// A read under way.
struct Reading<'a> {
    tree: &'a Tree<'a>,
    image: &'a Image,
    meter: &'a ReadMeter,
    cache: Option<&'a ChunkCache>,
    samples: PlacedSamples,
    /// Of the volume.
    n_bytes: u64,
    n_found: usize,
}

/// Where the chunks of a shard are.
struct InShard<'a> {
    chunks: &'a Chunks,
    /// Where the shard begins in the array.
    start: &'a [usize],
    /// How many chunks it has along each axis.
    n_each: Vec<usize>,
    /// Where each chunk is in the shard, and how long.
    index: Vec<[u64; 2]>,
}

impl InShard<'_> {
    /// Where a chunk begins in the array.
    fn first_of(&self, at: usize) -> Vec<usize> {
        first_of(at, self.start, &self.n_each, &self.chunks.shape)
    }

    /// Where a chunk is in the shard, and how long, if it is there.
    fn range_of(&self, at: usize) -> Option<[u64; 2]> {
        Some(self.index[at]).filter(|place| *place != [NONE; 2])
    }
}

/// Of the chunks that are unpacked at once, beside a volume of so many bytes.
const MAX_SHARE: u64 = 8;

/// Of a chunk of the array, unpacked.
fn chunk_bytes(image: &Image) -> u64 {
    unpacked_bytes(image, &image.array.chunks)
}

fn unpacked_bytes(image: &Image, chunks: &Chunks) -> u64 {
    let n_items = chunks.shape.iter().fold(1, |n: u64, len| n.saturating_mul(*len as u64));
    n_items.saturating_mul(image.array.stored.size_bytes() as u64)
}

pub(super) fn read(
    input: &Input<'_>,
    tree: &Tree<'_>,
    image: &Image,
    n_samples: usize,
    warnings: &mut Vec<String>,
) -> Result<Samples, IoError> {
    let all = Indices::of(&image.axes, &image.array.chunks.shape);
    if all.len().is_none_or(|n| MAX_CHUNKS < n) {
        let what = "the array has more than a million chunks: save it with larger ones";
        return Err(IoError::unsupported(input.path, what));
    }
    let is_zero = image.array.fill.iter().all(|byte| *byte == 0);
    let mut keys = all.clone().map(|index| key(image, &index));
    // Zeros take no memory until something else is written over them.
    if !is_zero && !image.is_box && !keys.any(|key| tree.has(&key)) {
        return Err(IoError::malformed(input.path, "no chunk of the array is there"));
    }
    let n_bytes =
        (n_samples as u64).saturating_mul(image.array.stored.widest().size_bytes() as u64);
    if MAX_UNBACKED_BYTES < n_bytes {
        check_backed(input, tree, all.clone().map(|index| key(image, &index)), n_bytes)?;
    }
    let endian = image.array.chunks.innermost().endian;
    let samples = input.room(image.array.stored, endian, n_samples);
    let samples = samples.map_err(|_| IoError::Read {
        path: input.path.to_owned(),
        source: io::ErrorKind::OutOfMemory.into(),
    })?;
    let meter = input.meter((all.len().unwrap_or(0) as u64).saturating_mul(chunk_bytes(image)));
    let cache = input.options.chunks.as_ref();
    let mut reading = Reading { tree, image, meter: &meter, cache, samples, n_bytes, n_found: 0 };
    reading.read_all(&all.collect::<Vec<_>>())?;
    if reading.n_found == 0 && !image.is_box {
        warnings.push("no chunk of the array is there: all voxels have its fill value".to_owned());
    }
    Ok(reading.samples.finish(warnings))
}

/// That the chunks there could unpack to a volume.
fn check_backed(
    input: &Input<'_>,
    tree: &Tree<'_>,
    keys: impl Iterator<Item = String>,
    n_bytes: u64,
) -> Result<(), IoError> {
    let mut n_backed = MAX_UNBACKED_BYTES;
    for key in keys {
        if let Some(part) = tree.part(&key)? {
            n_backed = n_backed.saturating_add(part.n_bytes().saturating_mul(MAX_RATIO));
        }
        if n_bytes <= n_backed {
            return Ok(());
        }
    }
    let what = format!("{n_bytes} bytes of samples cannot be in the few chunks that are there");
    Err(IoError::malformed(input.path, what))
}

fn key(image: &Image, index: &[usize]) -> String {
    let keys = &image.array.keys;
    let separator = keys.separator.to_string();
    let numbers = index.iter().map(usize::to_string).collect::<Vec<_>>().join(&separator);
    let name = if keys.prefix.is_empty() {
        numbers
    } else {
        format!("{}{separator}{numbers}", keys.prefix)
    };
    if image.key.is_empty() { name } else { format!("{}/{name}", image.key) }
}

impl<'a> Reading<'a> {
    /// The chunks of all files.
    fn read_all(&mut self, indices: &[Vec<usize>]) -> Result<(), IoError> {
        let (tree, image) = (self.tree, self.image);
        let chunks = &image.array.chunks;
        let n_workers = parallel::n_workers(indices.len());
        let has_room = self.has_room_for(n_workers, chunk_bytes(image));
        if chunks.shard.is_some() || n_workers == 1 || !has_room {
            return indices.iter().try_for_each(|index| self.read_file(index));
        }
        let cache = self.cache;
        let unpack = |(): &mut (), index: &Vec<usize>| {
            let start = start_of(image, index);
            if let Some(bytes) = cache.and_then(|cache| cache.get(&image.key, &start)) {
                return Ok(Some(bytes));
            }
            let key = key(image, index);
            let Some(part) = tree.part(&key)? else { return Ok(None) };
            let unpacked = unpacked_chunk(image, chunks, part);
            let unpacked = unpacked.map(|bytes| retained(cache, image, (chunks, &start), bytes));
            unpacked.map(Some).map_err(|failure| failed(tree, &key, failure))
        };
        parallel::in_order(&mut vec![(); n_workers], indices, unpack, |index, chunk| {
            let start = start_of(image, index);
            match chunk {
                None => self.fill(&start, &chunks.shape),
                Some(chunk) => {
                    self.n_found += 1;
                    let placed = self.place(&mut &chunk[..], chunks, &start);
                    placed.map_err(|failure| failed(tree, &key(image, index), failure))?;
                }
            }
            Ok(self.meter.advance(chunk_bytes(image))?)
        })
    }

    fn read_file(&mut self, index: &[usize]) -> Result<(), IoError> {
        let chunks = &self.image.array.chunks;
        let start = start_of(self.image, index);
        let key = key(self.image, index);
        self.meter.advance(chunk_bytes(self.image))?;
        if chunks.shard.is_none()
            && let Some(bytes) = self.cached(&start)
        {
            self.n_found += 1;
            let placed = self.place(&mut &bytes[..], chunks, &start);
            return placed.map_err(|failure| failed(self.tree, &key, failure));
        }
        let Some(part) = self.tree.part(&key)? else {
            self.fill(&start, &chunks.shape);
            return Ok(());
        };
        self.n_found += 1;
        let done = match &chunks.shard {
            None => self.read_chunk(part, chunks, &start),
            Some(shard) => self.read_shard(part, shard, (&key, &start)),
        };
        done.map_err(|failure| failed(self.tree, &key, failure))
    }

    fn read_shard(
        &mut self,
        mut part: Part<'a>,
        shard: &Shard,
        (key, start): (&str, &[usize]),
    ) -> Result<(), ReadFailure> {
        let outer = &self.image.array.chunks;
        let index = read_index(&mut part, shard, outer).map_err(ReadFailure::Io)?;
        let chunks = &shard.chunks;
        let n_each = outer.shape.iter().zip(&chunks.shape).map(|(outer, inner)| outer / inner);
        let places = InShard { chunks, start, n_each: n_each.collect(), index };
        let is_kept = |at: &usize| self.axes_of(&places.first_of(*at), &chunks.shape).is_some();
        let kept = (0..places.index.len()).filter(is_kept).collect::<Vec<usize>>();
        let mut readers = self.readers(part, key, shard, kept.len());
        if let [part] = readers.as_mut_slice() {
            return kept.iter().try_for_each(|&at| self.read_inner(part, &places, at));
        }
        let (image, cache) = (self.image, self.cache);
        let unpack = |part: &mut Part<'_>, &at: &usize| {
            let Some([offset, n_bytes]) = places.range_of(at) else { return Ok(None) };
            let first = places.first_of(at);
            if let Some(bytes) = cache.and_then(|cache| cache.get(&image.key, &first)) {
                return Ok(Some(bytes));
            }
            part.go_to(offset).map_err(ReadFailure::Io)?;
            let bytes = unpacked_chunk(image, chunks, part.take(n_bytes))?;
            Ok(Some(retained(cache, image, (chunks, &first), bytes)))
        };
        parallel::in_order(&mut readers, &kept, unpack, |&at, unpacked| {
            let first = places.first_of(at);
            match unpacked {
                None => self.fill(&first, &chunks.shape),
                Some(bytes) => self.place(&mut &bytes[..], chunks, &first)?,
            }
            Ok(())
        })
    }

    /// A chunk of a shard, straight to where its samples belong.
    fn read_inner(
        &mut self,
        part: &mut Part<'_>,
        places: &InShard<'_>,
        at: usize,
    ) -> Result<(), ReadFailure> {
        let first = places.first_of(at);
        let Some([offset, n_bytes]) = places.range_of(at) else {
            self.fill(&first, &places.chunks.shape);
            return Ok(());
        };
        if let Some(bytes) = self.cached(&first) {
            return self.place(&mut &bytes[..], places.chunks, &first);
        }
        part.go_to(offset).map_err(ReadFailure::Io)?;
        self.read_chunk(part.take(n_bytes), places.chunks, &first)
    }

    /// The shard, opened for each worker, if there is room for so many chunks beside the volume.
    fn readers(&self, part: Part<'a>, key: &str, shard: &Shard, n_chunks: usize) -> Vec<Part<'a>> {
        let n_workers = parallel::n_workers(n_chunks);
        let has_room = self.has_room_for(n_workers, unpacked_bytes(self.image, &shard.chunks));
        let n_more = if has_room && part.is_file() { n_workers - 1 } else { 0 };
        let more = (0..n_more).map_while(|_| self.tree.part(key).ok().flatten());
        std::iter::once(part).chain(more).collect()
    }

    /// Whether so many chunks in memory are few beside the volume.
    fn has_room_for(&self, n_workers: usize, chunk_bytes: u64) -> bool {
        (n_workers as u64).saturating_mul(chunk_bytes) <= self.n_bytes / MAX_SHARE
    }

    fn read_chunk(
        &mut self,
        packed: impl Read,
        chunks: &Chunks,
        start: &[usize],
    ) -> Result<(), ReadFailure> {
        if self.axes_of(start, &chunks.shape).is_none() {
            return Ok(());
        }
        let n_bytes = unpacked_bytes(self.image, chunks);
        if self.cache.is_some_and(|cache| cache.takes(n_bytes)) {
            let bytes = unpacked_chunk(self.image, chunks, packed)?;
            let bytes = retained(self.cache, self.image, (chunks, start), bytes);
            return self.place(&mut &bytes[..], chunks, start);
        }
        let mut source =
            codecs::unpacked(packed, &chunks.codecs, n_bytes).map_err(ReadFailure::Io)?;
        self.place(&mut source, chunks, start)
    }

    /// A chunk that another box had unpacked.
    fn cached(&self, start: &[usize]) -> Option<Arc<[u8]>> {
        self.cache?.get(&self.image.key, start)
    }

    /// What is kept of an unpacked chunk goes to its place.
    fn place(
        &mut self,
        source: &mut impl Source,
        chunks: &Chunks,
        start: &[usize],
    ) -> Result<(), ReadFailure> {
        let Some((axes, first)) = self.axes_of(start, &chunks.shape) else { return Ok(()) };
        // By bytes, the fastest first.
        let in_order: Vec<Axis> =
            chunks.order.iter().rev().map(|&axis| axes[axis].clone()).collect();
        self.samples.place(source, &in_order, first)
    }

    /// A chunk that is not there.
    fn fill(&mut self, start: &[usize], shape: &[usize]) {
        let fill = &self.image.array.fill;
        let Some((axes, first)) = self.axes_of(start, shape) else { return };
        if fill.iter().all(|byte| *byte == 0) {
            return;
        }
        let along: Vec<&Axis> = axes.iter().filter(|axis| 1 < axis.kept.len()).collect();
        let [outer @ .., row] = along.as_slice() else {
            self.samples.fill(fill, first, 1, 1);
            return;
        };
        let n_rows = outer.iter().map(|axis| axis.kept.len()).product::<usize>();
        for at in 0..n_rows {
            let (mut rest, mut first) = (at, first);
            for axis in outer {
                first += rest % axis.kept.len() * axis.stride;
                rest /= axis.kept.len();
            }
            self.samples.fill(fill, first, row.stride, row.kept.len());
        }
    }

    /// What is kept of a chunk that begins there, and where its first voxel goes; `None` if nothing is.
    fn axes_of(&self, start: &[usize], shape: &[usize]) -> Option<(Vec<Axis>, usize)> {
        let mut first = 0;
        let mut axes = Vec::new();
        for ((axis, &start), &len) in self.image.axes.iter().zip(start).zip(shape) {
            let from = axis.kept.start.max(start);
            let to = axis.kept.end.min(start.saturating_add(len));
            if to <= from {
                return None;
            }
            first += (from - axis.kept.start) * axis.stride;
            axes.push(Axis { len, kept: from - start..to - start, stride: axis.stride });
        }
        Some((axes, first))
    }
}

/// Retains an unpacked chunk for other boxes; not one that is cut off.
fn retained(
    cache: Option<&ChunkCache>,
    image: &Image,
    (chunks, start): (&Chunks, &[usize]),
    bytes: Vec<u8>,
) -> Arc<[u8]> {
    match cache {
        Some(cache) if bytes.len() as u64 == unpacked_bytes(image, chunks) => {
            cache.put(&image.key, start, bytes)
        }
        _ => bytes.into(),
    }
}

/// Where the chunks of a file begin in the array.
fn start_of(image: &Image, index: &[usize]) -> Vec<usize> {
    index.iter().zip(&image.array.chunks.shape).map(|(i, len)| i * len).collect()
}

/// Where a chunk of a shard begins that begins at `start` and has so many along each axis.
fn first_of(at: usize, start: &[usize], n_each: &[usize], inner: &[usize]) -> Vec<usize> {
    let mut rest = at;
    let mut first = start.to_vec();
    for axis in (0..n_each.len()).rev() {
        first[axis] += rest % n_each[axis] * inner[axis];
        rest /= n_each[axis];
    }
    first
}

/// All bytes of a chunk; memory grows with what comes.
fn unpacked_chunk(
    image: &Image,
    chunks: &Chunks,
    packed: impl Read,
) -> Result<Vec<u8>, ReadFailure> {
    let n_bytes = unpacked_bytes(image, chunks);
    let source = codecs::unpacked(packed, &chunks.codecs, n_bytes).map_err(ReadFailure::Io)?;
    let mut bytes = Vec::new();
    source.take(n_bytes).read_to_end(&mut bytes).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => ReadFailure::TooShort(bytes.len() as u64),
        _ => ReadFailure::Io(error),
    })?;
    Ok(bytes)
}

fn failed(tree: &Tree<'_>, key: &str, failure: ReadFailure) -> IoError {
    let path = tree.path_of(key);
    match failure {
        ReadFailure::TooShort(_) => {
            IoError::malformed(path, "a chunk unpacks to less than it should")
        }
        ReadFailure::Io(error) => match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied => {
                IoError::Read { path, source: error }
            }
            _ => IoError::malformed(path, format!("a chunk cannot be unpacked: {error}")),
        },
    }
}

/// Where each chunk of a shard is, and how long.
fn read_index(part: &mut Part<'_>, shard: &Shard, outer: &Chunks) -> io::Result<Vec<[u64; 2]>> {
    let invalid = |what: &'static str| io::Error::new(io::ErrorKind::InvalidData, what);
    let n_each = outer.shape.iter().zip(&shard.chunks.shape).map(|(outer, inner)| outer / inner);
    let n_chunks = n_each.fold(1, |n: usize, each| n.saturating_mul(each));
    let n_bytes = n_chunks as u64 * 16 + if shard.has_sum { 4 } else { 0 };
    if MAX_IN_SHARD < n_chunks || part.n_bytes() < n_bytes {
        return Err(invalid("a shard is too short for its index"));
    }
    part.go_to(if shard.index_is_at_end { part.n_bytes() - n_bytes } else { 0 })?;
    let mut bytes = Vec::new();
    part.take(n_bytes).read_to_end(&mut bytes)?;
    if shard.has_sum {
        let sum = bytes.split_off(bytes.len() - 4);
        if crc32c(&bytes).to_le_bytes() != sum.as_slice() {
            return Err(invalid("the index of a shard is damaged: its checksum is another"));
        }
    }
    let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |n, byte| n << 8 | u64::from(*byte));
    Ok(bytes.chunks_exact(16).map(|pair| [word(&pair[..8]), word(&pair[8..])]).collect())
}

/// The indices of all chunks that are kept of an array.
#[derive(Clone)]
struct Indices {
    ranges: Vec<std::ops::Range<usize>>,
    next: Option<Vec<usize>>,
}

impl Indices {
    fn of(axes: &[Axis], chunk: &[usize]) -> Self {
        let ranges = axes
            .iter()
            .zip(chunk)
            .map(|(axis, &len)| axis.kept.start / len..(axis.kept.end - 1) / len + 1);
        let ranges: Vec<_> = ranges.collect();
        let next = Some(ranges.iter().map(|range| range.start).collect());
        Self { ranges, next }
    }

    fn len(&self) -> Option<usize> {
        self.ranges.iter().try_fold(1_usize, |n, range| n.checked_mul(range.len()))
    }
}

impl Iterator for Indices {
    type Item = Vec<usize>;

    fn next(&mut self) -> Option<Vec<usize>> {
        let index = self.next.take()?;
        let mut next = index.clone();
        for (at, range) in self.ranges.iter().enumerate().rev() {
            next[at] += 1;
            if next[at] < range.end {
                self.next = Some(next);
                break;
            }
            next[at] = range.start;
        }
        Some(index)
    }
}
