//! A stage's source: its file, with what it includes in front.

use anyhow::{Context, Result, ensure};
use std::collections::HashSet;
use std::path::Path;

/// A stage as it goes to a compiler.
pub(crate) struct Stage {
    /// The file's name and the entry point's.
    pub(crate) name: String,
    pub(crate) wgsl: String,
}

/// All stages of a folder, by name.
pub(crate) fn stages(folder: &Path) -> Result<Vec<Stage>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "wgsl") {
            let stem = path.file_stem().and_then(|stem| stem.to_str());
            names.push(stem.context("shaders have plain names")?.to_owned());
        }
    }
    names.sort();
    ensure!(!names.is_empty(), "there are no shaders in {}", folder.display());
    names.into_iter().map(|name| stage(folder, name)).collect()
}

fn stage(folder: &Path, name: String) -> Result<Stage> {
    let mut wgsl = String::new();
    append(folder, &format!("{name}.wgsl"), &mut HashSet::new(), &mut wgsl)?;
    Ok(Stage { name, wgsl })
}

/// Appends a file, and before it, once, what its lines `//#include "…"` name.
fn append(
    folder: &Path,
    file: &str,
    included: &mut HashSet<String>,
    wgsl: &mut String,
) -> Result<()> {
    if !included.insert(file.to_owned()) {
        return Ok(());
    }
    let text = std::fs::read_to_string(folder.join(file)).with_context(|| file.to_owned())?;
    for line in text.lines() {
        if let Some(path) = line.strip_prefix("//#include \"") {
            let path = path.strip_suffix('"').with_context(|| format!("{file}: {line}"))?;
            append(folder, path, included, wgsl)?;
        }
    }
    let own_lines = text.lines().filter(|line| !line.starts_with("//#include"));
    own_lines.for_each(|line| {
        wgsl.push_str(line);
        wgsl.push('\n');
    });
    Ok(())
}
