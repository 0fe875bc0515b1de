//! How far the reading of a volume is, for who waits for it.
//!
//! A callback among the [`VolumeOptions`](crate::VolumeOptions) hears of it; nothing is printed here. Readers
//! count the bytes that they have unpacked, of all that the volume takes.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// How much of a volume has been read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadProgress {
    /// Bytes that were read and unpacked.
    pub n_done: u64,
    /// Bytes that are to be, at least 1.
    pub n_bytes: u64,
}

impl ReadProgress {
    /// The share that is done, 0 … 1.
    pub fn share(&self) -> f64 {
        self.n_done as f64 / self.n_bytes as f64
    }
}

/// What hears how far reading is. Two are equal if one is a clone of the other.
#[derive(Clone)]
pub struct ProgressCallback(Arc<dyn Fn(ReadProgress) + Send + Sync>);

impl ProgressCallback {
    /// `hear` is called now and then, at most a few hundred times a volume, on whatever thread reads: also on
    /// several at once, so that what it hears may be less than before.
    pub fn new(hear: impl Fn(ReadProgress) + Send + Sync + 'static) -> Self {
        Self(Arc::new(hear))
    }
}

impl fmt::Debug for ProgressCallback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("ProgressCallback")
    }
}

impl PartialEq for ProgressCallback {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for ProgressCallback {}

/// Calls of one volume.
const N_CALLS: u64 = 256;

/// Counts what was read, and tells of it.
#[derive(Debug)]
pub(crate) struct ReadMeter {
    callback: Option<ProgressCallback>,
    n_bytes: u64,
    n_done: AtomicU64,
}

impl ReadMeter {
    /// Of so many bytes, on the word of a header.
    pub(crate) fn new(callback: Option<&ProgressCallback>, n_bytes: u64) -> Self {
        let meter = Self {
            callback: callback.cloned(),
            n_bytes: n_bytes.max(1),
            n_done: AtomicU64::new(0),
        };
        meter.tell(0);
        meter
    }

    /// So many more bytes are done.
    pub(crate) fn advance(&self, n_bytes: u64) {
        let before = self.n_done.fetch_add(n_bytes, Ordering::Relaxed);
        let after = before.saturating_add(n_bytes);
        let step = (self.n_bytes / N_CALLS).max(1);
        if before / step < after / step {
            self.tell(after);
        }
    }

    fn tell(&self, n_done: u64) {
        if let Some(ProgressCallback(hear)) = &self.callback {
            hear(ReadProgress { n_done: n_done.min(self.n_bytes), n_bytes: self.n_bytes });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn progress_is_told_now_and_then() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let inside = heard.clone();
        let callback = ProgressCallback::new(move |progress| inside.lock().unwrap().push(progress));
        let meter = ReadMeter::new(Some(&callback), 1 << 20);
        for _ in 0..1 << 20 {
            meter.advance(1);
        }
        // More than was said to come.
        meter.advance(1 << 30);
        let heard = heard.lock().unwrap();
        assert!((200..300).contains(&heard.len()), "{} calls", heard.len());
        assert!(heard.is_sorted_by_key(|progress| progress.n_done));
        assert_eq!([heard[0].share(), heard[heard.len() - 1].share()], [0.0, 1.0]);
        assert!(callback == callback.clone() && callback != ProgressCallback::new(|_| {}));
        ReadMeter::new(None, 0).advance(1);
    }
}
