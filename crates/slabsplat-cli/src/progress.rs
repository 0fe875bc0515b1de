//! Progress bars: on stderr, only on a terminal, and only once the work has lasted a second.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slabsplat::io::ProgressCallback;
use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// How long work may last before anyone wants to know how it goes.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time between two pictures of the spinner.
const TICK: Duration = Duration::from_millis(100);

/// The bar that is there, if any: a warning may come from anywhere while it is.
static CURRENT: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Prints without a bar in the way.
pub(crate) fn suspended<T>(print: impl FnOnce() -> T) -> T {
    let bar = current().clone();
    match bar {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

fn current() -> MutexGuard<'static, Option<ProgressBar>> {
    // A bar is whole at any time, whoever panicked.
    CURRENT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A bar that is wiped away when dropped. There is one at a time.
pub(crate) struct Progress {
    bar: ProgressBar,
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
        *current() = Some(bar.clone());
        let (done, watcher) = watch(&bar);
        Self { bar, done, watcher }
    }

    /// What is being done now, of which is not known how far it is.
    pub(crate) fn stage(&self, what: &'static str) {
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
        *current() = None;
    }
}

/// Shows how far the reading of a volume is, and how long it will still take.
pub(crate) fn reading() -> ProgressCallback {
    ProgressCallback::new(|read| {
        let Some(bar) = current().clone() else { return };
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
}

fn style(kind: Kind) -> ProgressStyle {
    let template = match kind {
        Kind::Spinner => "{spinner} {msg} {elapsed}",
        Kind::Steps => "{msg} [{bar:40}] {pos}/{len}, {percent} %, {eta} left",
        Kind::Bytes => "{msg} [{bar:40}] {bytes} of {total_bytes}, {eta} left",
    };
    // The templates are fixed; the usual bar does if one were ever wrong.
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ")
}

/// Shows the bar after a second, from a thread of its own: a single frame may take longer, and it
/// calls nobody in between.
fn watch(bar: &ProgressBar) -> (Option<Sender<()>>, Option<JoinHandle<()>>) {
    if !Progress::is_seen() {
        return (None, None);
    }
    let (done, is_done) = mpsc::channel();
    let bar = bar.clone();
    let wait = move || {
        if is_done.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            bar.enable_steady_tick(TICK);
        }
    };
    // Without a thread there is no bar, and the work is done all the same.
    (Some(done), std::thread::Builder::new().spawn(wait).ok())
}
