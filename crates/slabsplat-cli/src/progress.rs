//! Progress bars: on stderr, only on a terminal, and only once the work has lasted a second.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
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
        bar.set_style(style(n_steps));
        bar.set_message(what);
        *current() = Some(bar.clone());
        let (done, watcher) = watch(&bar);
        Self { bar, done, watcher }
    }

    /// What is being done now.
    pub(crate) fn stage(&self, what: &'static str) {
        self.bar.set_message(what);
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

fn style(n_steps: usize) -> ProgressStyle {
    let template = match n_steps {
        0 => "{spinner} {msg} {elapsed}",
        _ => "{msg} [{bar:40}] {pos}/{len} {eta}",
    };
    // The templates are fixed; the usual bar does if one were ever wrong.
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ")
}

/// Shows the bar after a second, from a thread of its own: a single frame may take longer, and it
/// calls nobody in between.
fn watch(bar: &ProgressBar) -> (Option<Sender<()>>, Option<JoinHandle<()>>) {
    if !std::io::stderr().is_terminal() {
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
