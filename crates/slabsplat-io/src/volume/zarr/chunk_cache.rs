//! Chunks of arrays that were unpacked, for who reads several boxes of them: a chunk that two boxes meet is
//! unpacked once, as long as there is room for it.
//!
//! What was used last stays. Chunks are counted by their bytes, which are all that they take but for a key.

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Unpacked chunks of one file's arrays, within so many bytes. A clone has the same; two are equal if one is
/// a clone of the other.
#[derive(Clone, Default)]
pub(crate) struct ChunkCache(Arc<Mutex<Chunks>>);

#[derive(Default)]
struct Chunks {
    most_bytes: u64,
    n_bytes: u64,
    by_key: HashMap<ChunkKey, Chunk>,
    /// The key that was used at each moment.
    by_use: BTreeMap<u64, ChunkKey>,
    now: u64,
    counts: [u64; 2],
}

/// A chunk of an array, by the array's key and where the chunk begins.
type ChunkKey = (Arc<str>, Vec<usize>);

struct Chunk {
    bytes: Arc<[u8]>,
    used: u64,
}

/// No chunk that takes more than this part of all room is retained: others would go for it.
const MOST_OF_ALL: u64 = 4;

impl ChunkCache {
    fn lock(&self) -> MutexGuard<'_, Chunks> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// From now on it may have so many bytes.
    pub(crate) fn set_room(&self, most_bytes: u64) {
        let mut chunks = self.lock();
        chunks.most_bytes = most_bytes;
        chunks.make_room(0);
    }

    /// Whether chunks of that many bytes are retained.
    pub(crate) fn takes(&self, chunk_bytes: u64) -> bool {
        0 < chunk_bytes && chunk_bytes <= self.lock().most_bytes / MOST_OF_ALL
    }

    /// A chunk, if it is there.
    pub(crate) fn get(&self, array: &str, start: &[usize]) -> Option<Arc<[u8]>> {
        let mut chunks = self.lock();
        chunks.now += 1;
        let key = (Arc::from(array), start.to_vec());
        let Chunks { by_key, by_use, now, counts, .. } = &mut *chunks;
        let found = by_key.get_mut(&key);
        counts[usize::from(found.is_some())] += 1;
        let chunk = found?;
        by_use.remove(&chunk.used);
        by_use.insert(*now, key);
        chunk.used = *now;
        Some(chunk.bytes.clone())
    }

    /// Retains a chunk, if it [takes](Self::takes) such.
    pub(crate) fn put(&self, array: &str, start: &[usize], bytes: Vec<u8>) -> Arc<[u8]> {
        let bytes: Arc<[u8]> = bytes.into();
        let n_bytes = bytes.len() as u64;
        if !self.takes(n_bytes) {
            return bytes;
        }
        let mut chunks = self.lock();
        chunks.make_room(n_bytes);
        chunks.now += 1;
        let (key, used) = ((Arc::from(array), start.to_vec()), chunks.now);
        chunks.n_bytes += n_bytes;
        chunks.by_use.insert(used, key.clone());
        if let Some(before) = chunks.by_key.insert(key, Chunk { bytes: bytes.clone(), used }) {
            chunks.n_bytes -= before.bytes.len() as u64;
            chunks.by_use.remove(&before.used);
        }
        bytes
    }

    /// How many chunks were asked for in vain, and how many were there.
    pub(crate) fn counts(&self) -> [u64; 2] {
        self.lock().counts
    }
}

impl Chunks {
    /// Drops what was not used for longest, until so many bytes more have room.
    fn make_room(&mut self, n_bytes: u64) {
        while self.most_bytes < self.n_bytes + n_bytes {
            let Some((_, key)) = self.by_use.pop_first() else { return };
            if let Some(chunk) = self.by_key.remove(&key) {
                self.n_bytes -= chunk.bytes.len() as u64;
            }
        }
    }
}

impl fmt::Debug for ChunkCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Chunks { n_bytes, most_bytes, .. } = &*self.lock();
        write!(f, "ChunkCache({n_bytes} of {most_bytes} bytes)")
    }
}

impl PartialEq for ChunkCache {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for ChunkCache {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunk_cache_retains_what_was_used_last() {
        let cache = ChunkCache::default();
        cache.put("0", &[0], vec![7; 10]);
        assert_eq!(cache.get("0", &[0]), None, "there is no room");
        cache.set_room(45);
        let put = |at: usize| cache.put("0", &[at, 0], vec![at as u8; 10]);
        let has = |at: usize| cache.lock().by_key.contains_key(&("0".into(), vec![at, 0]));
        (0..4).for_each(|at| drop(put(at)));
        assert_eq!(cache.get("0", &[0, 0]).as_deref(), Some(&[0; 10][..]));
        put(4);
        assert_eq!([0, 1, 2, 3, 4].map(has), [true, false, true, true, true]);
        // The same again takes no more room.
        put(4);
        assert_eq!([0, 1, 2, 3, 4].map(has), [true, false, false, true, true]);
        cache.put("1", &[0, 0], vec![1; 12]);
        assert_eq!(cache.get("1", &[0, 0]), None, "it is too large for the others");
        cache.set_room(15);
        assert_eq!([0, 1, 2, 3, 4].map(has), [false, false, false, false, true]);
        cache.set_room(0);
        assert!(!has(4) && cache.lock().n_bytes == 0);
        assert_eq!(cache.counts(), [2, 1]);
    }
}
