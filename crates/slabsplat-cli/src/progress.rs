//! Progress bars: on stderr, only on a terminal, and only once the work has lasted a second.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slabsplat::FrameHandle;
use slabsplat::io::ProgressCallback;
use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// How long work may last before anyone wants to know how it goes.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time between two pictures of the spinner.
const TICK: Duration = Duration::from_millis(100);

/// What a frame's bar counts.
const THOUSANDTHS: u64 = 1000;

/// The bar that is there, if any: a warning may come from anywhere while it is.
static CURRENT: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Prints without a bar in the way.
pub(crate) fn suspended<T>(print: impl FnOnce() -> T) -> T {
    let bar = locked(&CURRENT).clone();
    match bar {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A bar is whole at any time, whoever panicked.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The frame that is being drawn, if any.
type WatchedFrame = Arc<Mutex<Option<FrameHandle>>>;

/// A bar that is wiped away when dropped. There is one at a time.
pub(crate) struct Progress {
    bar: ProgressBar,
    frame: WatchedFrame,
    /// Dropped first, which ends the watcher.
    done: Option<Sender<()>>,
    watcher: Option<JoinHandle<()>>,
}

impl Progress {
    /// A bar of `n_steps` steps; with 0, a spinner.
    pub(crate) fn start(what: &'static str, n_steps: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(n_steps as u64), ProgressDrawTarget::hidden());
        bar.set_style(style(if n_steps == 0 { Kind::Spinner } else { Kind::Steps }));
        bar.set_message(what);
        *locked(&CURRENT) = Some(bar.clone());
        let frame = WatchedFrame::default();
        let (done, watcher) = watch(&bar, &frame);
        Self { bar, frame, done, watcher }
    }

    /// What is being done now, of which is not known how far it is.
    pub(crate) fn stage(&self, what: &'static str) {
        *locked(&self.frame) = None;
        self.bar.unset_length();
        self.bar.set_style(style(Kind::Spinner));
        self.bar.set_message(what);
    }

    /// Whether anybody sees a bar.
    pub(crate) fn is_seen() -> bool {
        std::io::stderr().is_terminal()
    }

    /// So many steps were done before.
    pub(crate) fn begin_at(&self, n_done: u64) {
        self.bar.set_position(n_done);
        self.bar.reset_eta();
    }

    /// A frame is drawn now, under the name that is returned. How much of it is done is shown if whoever
    /// draws it tells: the CPU does.
    pub(crate) fn frame(&self, what: &'static str) -> FrameHandle {
        self.stage(what);
        let frame = FrameHandle::new();
        *locked(&self.frame) = Some(frame.clone());
        frame
    }

    /// A step that was done before is not.
    pub(crate) fn step_back(&self) {
        self.bar.dec(1);
    }

    /// One step is done.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.done = None;
        if let Some(watcher) = self.watcher.take() {
            // It only waits; if it could not, there is no bar to wipe.
            let _ = watcher.join();
        }
        self.bar.finish_and_clear();
        *locked(&CURRENT) = None;
    }
}

/// Shows how far the reading of a volume is, and how long it will still take.
pub(crate) fn reading() -> ProgressCallback {
    ProgressCallback::new(|read| {
        let Some(bar) = locked(&CURRENT).clone() else { return };
        if read.n_done == 0 {
            bar.set_style(style(Kind::Bytes));
            bar.set_length(read.n_bytes);
            bar.reset_eta();
        }
        bar.set_position(read.n_done);
    })
}

/// What a bar counts.
#[derive(Clone, Copy)]
enum Kind {
    Spinner,
    Steps,
    Bytes,
    Share,
}

fn style(kind: Kind) -> ProgressStyle {
    let template = match kind {
        Kind::Spinner => "{spinner} {msg} {elapsed}",
        Kind::Steps => "{msg} [{bar:40}] {pos}/{len}, {percent} %, {eta} left",
        Kind::Bytes => "{msg} [{bar:40}] {bytes} of {total_bytes}, {eta} left",
        Kind::Share => "{msg} [{bar:40}] {percent} %, {eta} left",
    };
    // The templates are fixed; the usual bar does if one were ever wrong.
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ")
}

/// Shows the bar after a second, from a thread of its own: a single frame may take longer, and it
/// calls nobody in between.
fn watch(bar: &ProgressBar, frame: &WatchedFrame) -> (Option<Sender<()>>, Option<JoinHandle<()>>) {
    if !Progress::is_seen() {
        return (None, None);
    }
    let (done, is_done) = mpsc::channel();
    let (bar, frame) = (bar.clone(), frame.clone());
    let lasts = move |time| is_done.recv_timeout(time) == Err(RecvTimeoutError::Timeout);
    let wait = move || {
        if lasts(PATIENCE) {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            bar.enable_steady_tick(TICK);
            while lasts(TICK) {
                show_share(&bar, &frame);
            }
        }
    };
    // Without a thread there is no bar, and the work is done all the same.
    (Some(done), std::thread::Builder::new().spawn(wait).ok())
}

/// Shows how much of a frame is drawn.
fn show_share(bar: &ProgressBar, frame: &WatchedFrame) {
    let frame = locked(frame);
    let Some(share) = frame.as_ref().map(FrameHandle::progress).filter(|share| *share > 0.0) else {
        return;
    };
    if bar.length() != Some(THOUSANDTHS) {
        bar.set_style(style(Kind::Share));
        bar.set_length(THOUSANDTHS);
        bar.reset_eta();
    }
    bar.set_position((share * THOUSANDTHS as f32) as u64);
}
