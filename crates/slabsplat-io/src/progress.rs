//! How far the reading of a volume is, for who waits for it, and who may have it stopped.
//!
//! A callback among the [`VolumeOptions`](crate::VolumeOptions) hears of it; nothing is printed here. Readers
//! count the bytes that they have unpacked, of all that the volume takes. Whoever counts is told to stop by
//! an error, so that no reader needs to look for itself.

use crate::IoError;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::{fmt, io};

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
pub struct ProgressCallback(Arc<Callback>);

struct Callback {
    hear: Box<dyn Fn(ReadProgress) -> ControlFlow<()> + Send + Sync>,
    is_stopped: AtomicBool,
}

impl ProgressCallback {
    /// `hear` is called now and then, at most a few hundred times a volume, on whatever thread reads: also on
    /// several at once, so that what it hears may be less than before.
    pub fn new(hear: impl Fn(ReadProgress) + Send + Sync + 'static) -> Self {
        Self::stopping(move |progress| {
            hear(progress);
            ControlFlow::Continue(())
        })
    }

    /// The same with a `hear` that may have reading end: once it breaks, that and whatever else is read with
    /// the callback or a clone of it is [`IoError::Cancelled`], within some megabytes. What was read is gone.
    ///
    /// ```
    /// use slabsplat_io::{FilesInMemory, IoError, ProgressCallback, VolumeOptions};
    /// use std::ops::ControlFlow;
    ///
    /// let nrrd = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 2\nencoding: raw\n\nab";
    /// let files = FilesInMemory::from_iter([("a.nrrd", &nrrd[..])]);
    /// let mut options = VolumeOptions::default();
    /// options.progress = Some(ProgressCallback::stopping(|_| ControlFlow::Break(())));
    /// let error = files.read_volume_with("a.nrrd", &options).unwrap_err();
    /// assert!(matches!(error, IoError::Cancelled));
    /// ```
    pub fn stopping(
        hear: impl Fn(ReadProgress) -> ControlFlow<()> + Send + Sync + 'static,
    ) -> Self {
        let is_stopped = AtomicBool::new(false);
        Self(Arc::new(Callback { hear: Box::new(hear), is_stopped }))
    }

    fn tell(&self, progress: ReadProgress) {
        if (self.0.hear)(progress).is_break() {
            self.0.is_stopped.store(true, Ordering::Relaxed);
        }
    }

    fn is_stopped(&self) -> bool {
        self.0.is_stopped.load(Ordering::Relaxed)
    }
}

/// What came of reading: if it was stopped, that, whatever words a reader has for data that end early.
pub(crate) fn unless_stopped<T>(
    callback: Option<&ProgressCallback>,
    result: Result<T, IoError>,
) -> Result<T, IoError> {
    let is_stopped = || callback.is_some_and(ProgressCallback::is_stopped);
    result.map_err(|error| if is_stopped() { IoError::Cancelled } else { error })
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

/// Reading was stopped by who hears of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stopped;

impl From<Stopped> for IoError {
    fn from(_: Stopped) -> Self {
        Self::Cancelled
    }
}

impl From<Stopped> for io::Error {
    /// Not [`io::ErrorKind::Interrupted`], after which readers try again.
    fn from(_: Stopped) -> Self {
        Self::other("reading was stopped")
    }
}

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

    /// So many more bytes are done. Fails if no more are to be read.
    pub(crate) fn advance(&self, n_bytes: u64) -> Result<(), Stopped> {
        let before = self.n_done.fetch_add(n_bytes, Ordering::Relaxed);
        let after = before.saturating_add(n_bytes);
        let step = (self.n_bytes / N_CALLS).max(1);
        if before / step < after / step {
            self.tell(after);
        }
        let is_stopped = self.callback.as_ref().is_some_and(ProgressCallback::is_stopped);
        if is_stopped { Err(Stopped) } else { Ok(()) }
    }

    fn tell(&self, n_done: u64) {
        if let Some(callback) = &self.callback {
            let n_done = n_done.min(self.n_bytes);
            callback.tell(ReadProgress { n_done, n_bytes: self.n_bytes });
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
            meter.advance(1).unwrap();
        }
        // More than was said to come.
        meter.advance(1 << 30).unwrap();
        let heard = heard.lock().unwrap();
        assert!((200..300).contains(&heard.len()), "{} calls", heard.len());
        assert!(heard.is_sorted_by_key(|progress| progress.n_done));
        assert_eq!([heard[0].share(), heard[heard.len() - 1].share()], [0.0, 1.0]);
        assert!(callback == callback.clone() && callback != ProgressCallback::new(|_| {}));
        ReadMeter::new(None, 0).advance(1).unwrap();
    }

    #[test]
    fn who_is_stopped_stays_stopped() {
        let callback = ProgressCallback::stopping(|progress| match 50 <= progress.n_done {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        });
        let meter = ReadMeter::new(Some(&callback), 100);
        let n_advanced = (0..100).take_while(|_| meter.advance(1).is_ok()).count();
        assert_eq!((n_advanced, meter.advance(1).is_err()), (49, true));
        let other = ReadMeter::new(Some(&callback), 100);
        assert!(other.advance(1).is_err(), "the labels of a volume, say");
    }
}
