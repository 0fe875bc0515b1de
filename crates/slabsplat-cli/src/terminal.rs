//! What goes to stdout and stderr. Nothing here fails because a reader has gone: `| head` is no error.

use crate::progress;
use anyhow::{Context, Result};
use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::mem;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Mutex, PoisonError};

/// Writes the program's answer to stdout.
///
/// # Errors
/// If stdout cannot be written, other than because nobody reads it.
pub(crate) fn answer(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    let written = stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush());
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to stdout")
        }
        _ => Ok(()),
    }
}

/// How much is said on stderr, by [`RunningFlags`](crate::flags::RunningFlags).
static LOUDNESS: AtomicU8 = AtomicU8::new(Loudness::Usual as u8);

/// What warnings there were, for an answer in JSON.
static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// How much is said on stderr.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Loudness {
    /// Errors.
    Quiet,
    /// What was done, and warnings.
    Usual,
    /// Whatever is known.
    Verbose,
}

/// From now on, so much is said.
pub(crate) fn set_loudness(loudness: Loudness) {
    LOUDNESS.store(loudness as u8, Ordering::Relaxed);
}

/// Whether so much is to be said.
pub(crate) fn is_at_least(loudness: Loudness) -> bool {
    loudness as u8 <= LOUDNESS.load(Ordering::Relaxed)
}

/// Prints a line on stderr, unless nothing but errors is to be said.
pub(crate) fn say(line: Arguments<'_>) {
    if is_at_least(Loudness::Usual) {
        report(line);
    }
}

/// Says what was found for what nobody said, if anything was.
pub(crate) fn say_found(found: &[String]) {
    if !found.is_empty() {
        say(format_args!("shown as {}", found.join("; and ")));
    }
}

/// Prints a line on stderr that few want to know.
pub(crate) fn detail(line: Arguments<'_>) {
    if is_at_least(Loudness::Verbose) {
        report(line);
    }
}

/// Prints a line on stderr, in one piece, as `mpirun` may put its own words between two. If that fails, there
/// is nobody to report it to.
pub(crate) fn report(line: Arguments<'_>) {
    let line = format!("{line}\n");
    let _ = progress::suspended(|| io::stderr().lock().write_all(line.as_bytes()));
}

/// Reports what was assumed about a file.
pub(crate) fn warn_all(warnings: &[String]) {
    warnings.iter().for_each(|warning| warn(warning));
}

/// Reports something that is not as it should be, and does not stop the work.
pub(crate) fn warn(warning: &str) {
    let warning = flattened(warning);
    say(format_args!("warning: {warning}"));
    WARNINGS.lock().unwrap_or_else(PoisonError::into_inner).push(warning);
}

/// All warnings that there have been since they were asked for.
pub(crate) fn take_warnings() -> Vec<String> {
    mem::take(&mut WARNINGS.lock().unwrap_or_else(PoisonError::into_inner))
}

/// A failure that another process has reported.
#[derive(Debug)]
pub(crate) struct Unsaid;

impl std::fmt::Display for Unsaid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("another rank says why")
    }
}

impl std::error::Error for Unsaid {}

/// Whether somebody else reports an error.
pub(crate) fn is_unsaid(error: &anyhow::Error) -> bool {
    error.is::<Unsaid>()
}

/// An error and its causes on one line. Many a message already ends with its cause; it is said once.
pub(crate) fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain() {
        let cause = flattened(&cause.to_string());
        if line.is_empty() {
            line = cause;
        } else if !line.contains(&cause) {
            line = format!("{line}: {cause}");
        }
    }
    line
}

/// On one line, without what would command the terminal: names of files may hold that.
pub(crate) fn flattened(text: &str) -> String {
    let line =
        text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    line.chars().map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::anyhow;

    #[test]
    fn error_chain_is_one_line_without_repeats() {
        let error = anyhow!("no such file").context("cannot read a: no such file").context("b\n c");
        assert_eq!(one_line(&error), "b c: cannot read a: no such file");
        assert_eq!(one_line(&anyhow!("a\u{1b}[2J\u{7f}b")), "a\u{fffd}[2J\u{fffd}b");
        assert_eq!(one_line(&anyhow!("inner").context("outer")), "outer: inner");
    }
}
