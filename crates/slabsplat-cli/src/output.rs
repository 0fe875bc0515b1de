//! Pictures, pages and volumes, written to the end. Each grows under another name and is then given its own;
//! whoever interrupts the program meanwhile waits until that is done, a second at most for most pictures, so
//! that no half of one is left behind.

use crate::terminal;
use slabsplat::Image;
use slabsplat::io::{self, IoError, LoadedVolume, PictureFormat, Provenance, SceneFile};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Held while a picture is written.
static WRITING: Mutex<()> = Mutex::new(());

/// Writes a picture, and what it was made of.
///
/// # Errors
/// As [`PictureFormat::write`].
pub(crate) fn write_picture(
    path: &Path,
    format: PictureFormat,
    image: &Image,
    provenance: Option<&Provenance>,
) -> Result<(), IoError> {
    let _not_interrupted = writing();
    format.write(path, image, provenance)
}

/// Writes a scene file.
///
/// # Errors
/// As [`io::write_scene`].
pub(crate) fn write_scene(path: &Path, scene: &SceneFile) -> Result<(), IoError> {
    let _not_interrupted = writing();
    io::write_scene(path, scene)
}

/// Writes a file of text.
///
/// # Errors
/// As [`io::write_whole`].
pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), IoError> {
    let _not_interrupted = writing();
    io::write_whole(path, text.as_bytes())
}

/// Writes a volume in the format that the name's extension says, and returns what that has no room for.
///
/// # Errors
/// As [`io::write_volume`].
pub(crate) fn write_volume(path: &Path, loaded: &LoadedVolume) -> Result<Vec<String>, IoError> {
    let _not_interrupted = writing();
    match &loaded.colors {
        Some(colors) => io::write_colored_volume(path, &loaded.volume, colors),
        None => io::write_volume(path, &loaded.volume),
    }
}

/// What is told when a signal ends the program, if anything is.
static INTERRUPTED: Mutex<Option<String>> = Mutex::new(None);

/// From now on, this is told when a signal ends the program.
pub(crate) fn say_when_interrupted(line: Option<String>) {
    *INTERRUPTED.lock().unwrap_or_else(PoisonError::into_inner) = line;
}

/// What a signal does instead of ending the program, once.
#[cfg(any(unix, feature = "serve"))]
static INSTEAD: Mutex<Option<Box<dyn FnOnce() + Send>>> = Mutex::new(None);

/// The next signal that would end the program does this instead; the one after it ends it.
#[cfg(feature = "serve")]
pub(crate) fn when_interrupted(work: impl FnOnce() + Send + 'static) {
    *INSTEAD.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(work));
}

fn writing() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on, signals that end the program do so when no picture is being written.
#[cfg(unix)]
pub(crate) fn end_between_pictures() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;

    let ignored = ignored_signals();
    let ending =
        [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    // Without it the program works as well, until somebody interrupts it.
    // A file that would exceed `ulimit -f` is then an error where it is written, and what there is of it
    // goes.
    let Ok(mut signals) = Signals::new(ending.chain([SIGXFSZ])) else { return };
    std::thread::spawn(move || {
        for signal in signals.forever().filter(|signal| *signal != SIGXFSZ) {
            let instead = INSTEAD.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(work) = instead {
                work();
                continue;
            }
            let _not_interrupted = writing();
            let line = INTERRUPTED.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(line) = line {
                terminal::say(format_args!("{line}"));
            }
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    });
}

#[cfg(not(unix))]
pub(crate) fn end_between_pictures() {}

/// The signals that whoever started the program wants it to ignore, as `nohup` does; a bit each, the first
/// for signal 1. Where the system does not tell, none.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
