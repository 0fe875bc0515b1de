//! The page that a browser shows, and its files: read once, so that what is asked for later is a name in a
//! list and never a path.

use crate::ServeError;
use axum::body::Bytes;
use std::collections::HashMap;
use std::env;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// All files of the site by their names in links, which begin with `/`.
pub(crate) struct Site(HashMap<String, File>);

/// A file as a browser gets it.
pub(crate) struct File {
    pub(crate) mime: &'static str,
    pub(crate) bytes: Bytes,
}

/// The page in case that there is no site.
const NO_SITE: &str = include_str!("no_site.html");

/// More than the viewer has, so that a wrong folder is noticed.
const MAX_FILES: usize = 1000;
const MAX_BYTES: u64 = 256 << 20;
const MAX_DEPTH: usize = 8;

impl Site {
    /// The site in `folder`, or, if none is given, where an installed one is; else a page that says how to
    /// get it.
    pub(crate) fn read(folder: Option<&Path>) -> Result<Self, ServeError> {
        let is_site = |folder: &PathBuf| folder.join("index.html").is_file();
        let found = || usual_folders().into_iter().find(is_site);
        let Some(folder) = folder.map(Path::to_owned).or_else(found) else {
            return Ok(Self([("/".to_owned(), File::new("index.html", NO_SITE))].into()));
        };
        let failed = |source| ServeError::Site { folder: folder.clone(), source };
        let mut reading = Reading::default();
        reading.read(&folder, "/", 0).map_err(failed)?;
        let mut files = reading.files;
        let Some(File { mime, bytes }) = files.get("/index.html") else {
            return Err(failed(io::Error::other("it has no index.html")));
        };
        let index = File { mime, bytes: bytes.clone() };
        files.insert("/".to_owned(), index);
        Ok(Self(files))
    }

    /// The file of a link.
    pub(crate) fn file(&self, path: &str) -> Option<&File> {
        self.0.get(path)
    }
}

/// Beside the program, where packages put it, and where `cargo xtask web` does.
fn usual_folders() -> Vec<PathBuf> {
    let Ok(program) = env::current_exe() else { return Vec::new() };
    let Some(folder) = program.parent() else { return Vec::new() };
    ["viewer", "../share/slabsplat/viewer", "../web/viewer"].map(|it| folder.join(it)).into()
}

#[derive(Default)]
struct Reading {
    files: HashMap<String, File>,
    n_bytes: u64,
}

impl Reading {
    /// Reads the files of a folder whose links begin with `prefix`. Hidden ones are left out.
    fn read(&mut self, folder: &Path, prefix: &str, depth: usize) -> io::Result<()> {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let name = entry.file_name();
            let Some(name) = name.to_str().filter(|name| !name.starts_with('.')) else { continue };
            let (path, link) = (entry.path(), format!("{prefix}{name}"));
            // Of links those to files are followed, so that there is no circle.
            if entry.file_type()?.is_dir() && depth < MAX_DEPTH {
                self.read(&path, &format!("{link}/"), depth + 1)?;
            } else if path.is_file() {
                self.n_bytes += path.metadata()?.len();
                if MAX_FILES <= self.files.len() || MAX_BYTES < self.n_bytes {
                    return Err(io::Error::other("it is too large for a viewer"));
                }
                self.files.insert(link, File::new(name, fs::read(&path)?));
            }
        }
        Ok(())
    }
}

impl File {
    fn new(name: &str, bytes: impl Into<Bytes>) -> Self {
        let extension = Path::new(name).extension().and_then(|it| it.to_str()).unwrap_or("");
        Self { mime: mime_of(extension), bytes: bytes.into() }
    }
}

fn mime_of(extension: &str) -> &'static str {
    match extension {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "txt" | "md" => "text/plain; charset=utf-8",
        "json" | "map" => "application/json",
        "webmanifest" => "application/manifest+json",
        "wasm" => "application/wasm",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "ico" => "image/x-icon",
        "ttf" => "font/ttf",
        "woff2" => "font/woff2",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn site_is_what_is_in_its_folder() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir_all(dir.path().join("site/pkg")).unwrap();
        fs::write(dir.path().join("secret.txt"), "outside").unwrap();
        for (name, text) in [("index.html", "<p>"), ("pkg/a.wasm", "w"), (".hidden", "h")] {
            fs::write(dir.path().join("site").join(name), text).unwrap();
        }
        let site = Site::read(Some(&dir.path().join("site"))).unwrap();
        let text = |path: &str| site.file(path).map(|file| (file.mime, file.bytes.to_vec()));
        assert_eq!(text("/"), text("/index.html"));
        assert_eq!(text("/pkg/a.wasm"), Some(("application/wasm", b"w".to_vec())));
        for path in
            ["/.hidden", "/../secret.txt", "/pkg/../../secret.txt", "/pkg", "", "index.html"]
        {
            assert_eq!(text(path), None, "{path}");
        }
        let error = Site::read(Some(&dir.path().join("site/pkg"))).err().unwrap().to_string();
        assert!(error.contains("no index.html"), "{error}");
    }
}
