//! Which files belong to the repository: what git tracks, or would track if it were added.
//!
//! Without git (a source archive) it is every file below the root but for build products.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use super::File;
use crate::process::output;

/// The repository's files, by path.
pub(super) fn files(root: &Path) -> Result<Vec<File>> {
    let mut paths = paths(root)?;
    paths.sort();
    // During a merge, git lists a file once for each side.
    paths.dedup();
    paths.retain(|path| is_plain_file(&root.join(path)));
    paths.iter().map(|path| read(root, path)).collect()
}

fn paths(root: &Path) -> Result<Vec<String>> {
    // Only a repository of our own counts: an archive unpacked inside somebody else's is not theirs to list.
    if root.join(".git").exists()
        && let Ok(paths) = git_paths(root)
    {
        return Ok(paths);
    }
    walk(root)
}

fn git_paths(root: &Path) -> Result<Vec<String>> {
    let mut git = Command::new("git");
    git.arg("-C").arg(root);
    let listing =
        output(git.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]))?;
    Ok(listing.split_terminator('\0').map(str::to_owned).collect())
}

fn walk(root: &Path) -> Result<Vec<String>> {
    let mut paths = Vec::new();
    let mut pending = vec![String::new()];
    while let Some(directory) = pending.pop() {
        let at = root.join(&directory);
        for entry in fs::read_dir(&at).with_context(|| format!("cannot list {}", at.display()))? {
            let entry = entry?;
            let path = format!("{directory}{}", entry.file_name().to_string_lossy());
            match entry.file_type()? {
                kind if kind.is_file() => paths.push(path),
                kind if kind.is_dir() && !is_skipped(&path) => pending.push(path + "/"),
                _ => {}
            }
        }
    }
    Ok(paths)
}

fn is_skipped(directory: &str) -> bool {
    matches!(directory, ".git" | "target")
}

/// A tracked file may be deleted, a link point elsewhere, and a submodule is a directory.
fn is_plain_file(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_file())
}

fn read(root: &Path, path: &str) -> Result<File> {
    let bytes = fs::read(root.join(path)).with_context(|| format!("cannot read {path}"))?;
    Ok(File::new(path, bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace;

    #[test]
    fn walk_lists_nested_files() {
        let paths = walk(&workspace::root().join("xtask")).unwrap();
        assert!(paths.contains(&"Cargo.toml".to_owned()), "a file at the top: {paths:?}");
        assert!(paths.contains(&"src/tidy/collect.rs".to_owned()), "a nested file: {paths:?}");
    }

    #[test]
    fn files_are_ours_and_sorted() {
        let files = files(workspace::root()).unwrap();
        let paths: Vec<&str> = files.iter().map(|file| file.path.as_str()).collect();
        assert!(paths.contains(&"xtask/src/main.rs"), "our own source is listed");
        assert!(paths.is_sorted(), "by path");
        assert!(!paths.iter().any(|path| path.starts_with("target/")), "no build products");
    }
}
