//! What was opened before, in a file of the user's: a path a line, the newest first.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// Names that are remembered.
const MAX: usize = 10;

/// What was opened before. Nothing, if that is not known.
pub(crate) fn read() -> Vec<PathBuf> {
    let text = place().and_then(|place| fs::read_to_string(place).ok()).unwrap_or_default();
    parsed(&text)
}

/// Remembers that a file was opened, and says what is remembered now. Where that cannot be written, it is
/// forgotten with the program.
pub(crate) fn add(recent: &[PathBuf], path: &Path) -> Vec<PathBuf> {
    let newest = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let others = recent.iter().filter(|other| **other != newest).cloned();
    let recent: Vec<PathBuf> = std::iter::once(newest.clone()).chain(others).take(MAX).collect();
    if let Some(place) = place() {
        let lines = recent.iter().filter_map(|path| path.to_str()).map(|line| format!("{line}\n"));
        let made = place.parent().is_some_and(|folder| fs::create_dir_all(folder).is_ok());
        if made {
            drop(fs::write(place, lines.collect::<String>()));
        }
    }
    recent
}

fn parsed(text: &str) -> Vec<PathBuf> {
    text.lines().filter(|line| !line.is_empty()).take(MAX).map(PathBuf::from).collect()
}

/// Where systems have what programs remember.
fn place() -> Option<PathBuf> {
    let folder = |name: &str| env::var_os(name).filter(|it| !it.is_empty()).map(PathBuf::from);
    let of_home = || Some(folder("HOME")?.join(".local/state"));
    let state = folder("XDG_STATE_HOME").or_else(|| folder("LOCALAPPDATA")).or_else(of_home)?;
    Some(state.join("slabsplat").join("recent"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_paths() {
        let text: String = (0..20).map(|idx| format!("/data/{idx}.nii\n\n")).collect();
        assert_eq!(parsed(&text).len(), MAX);
        assert_eq!(parsed(&text)[0], PathBuf::from("/data/0.nii"));
        assert!(parsed("").is_empty());
    }
}
