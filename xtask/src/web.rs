//! `cargo xtask web`: builds the pages of `tests/outside` for WebAssembly, with vectors, has a browser draw
//! in one of them what the CPU draws here, and has the viewer used in it by mouse and keys.
//!
//! The pages lie in `target/web` afterwards, and any web server shows them:
//! `python3 -m http.server -d target/web`. They are built of the crates in this checkout, or with
//! `--packages` of what `cargo xtask package` made of these, as `cargo xtask outside` does, which then finds
//! them built.
//! What is judged, and how, is in `tests/tests/browser.rs`, and of the viewer in
//! `crates/slabsplat-cli/tests/program/browser/`.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use xtask::process::{cargo, run as run_command};
use xtask::test_build::all_packages;
use xtask::workspace::{self, Package, Workspace};

use crate::lint::{WASM, has_target};
use crate::outside::{Outside, packages, programs};
use crate::system;

/// Those that are pages; another is what writes their JavaScript.
pub(crate) const PAGES: &[&str] = &["browser", "page", VIEWER];

/// The one that has a folder of its own, which is served as it is.
const VIEWER: &str = "viewer";

/// What is served as it is.
const FILES: &[&str] = &["browser/site/test.html", "browser/site/test.js", "page/index.html"];
const VIEWER_FILES: &[&str] =
    &["viewer/index.html", "viewer/start.js", "viewer/worker.js", "viewer/viewer.css"];

/// Tells the test where the pages are.
const SITE: &str = "SLABSPLAT_SITE";

/// Set to anything, it makes the want of a browser a failure.
const REQUIRE_GPU: &str = "SLABSPLAT_REQUIRE_GPU";

/// What is to be done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Web {
    /// Whether a browser that is missing is to be installed.
    installs: bool,
    /// Whether pages are built of packages.
    of_packages: bool,
}

impl Web {
    /// Pages of packages that are there.
    pub(crate) const OF_PACKAGES: Self = Self { installs: false, of_packages: true };
}

pub(crate) fn parse(args: &[OsString]) -> Result<Web, String> {
    match args {
        [] => Ok(Web::default()),
        [flag, rest @ ..] if flag == "--install" => Ok(Web { installs: true, ..parse(rest)? }),
        [flag, rest @ ..] if flag == "--packages" => Ok(Web { of_packages: true, ..parse(rest)? }),
        [arg, ..] => {
            Err(format!("`web` takes `--install` and `--packages`, found `{}`", arg.display()))
        }
    }
}

pub(crate) fn run(web: Web) -> Result<()> {
    system::set_up("web", system::BROWSER, web.installs);
    let missing = if !has_target(WASM) {
        Some(format!("there is no {WASM}: `rustup target add {WASM}`"))
    } else if !system::has_chromium() {
        Some("there is no Chromium".to_owned())
    } else {
        None
    };
    if let Some(missing) = missing {
        if std::env::var_os(REQUIRE_GPU).is_some() {
            bail!("{REQUIRE_GPU} is set, but {missing}");
        }
        eprintln!("web: skipped, as {missing}");
        return Ok(());
    }
    let site = build(web)?;
    let mut test = cargo(workspace::root());
    // As all tests are built, which have been already.
    test.arg("test").args(all_packages()).args(["--test", "browser", "--test", "program", "--"]);
    // One browser after the other: each takes all of a small machine, as its graphics card is a program.
    test.args(["browser", "--nocapture", "--test-threads=1"]);
    run_command(test.env(SITE, site))
}

/// Builds the pages, and returns the folder that has them and all that they load.
fn build(web: Web) -> Result<PathBuf> {
    let workspace = Workspace::read()?;
    let crates = if web.of_packages { packages(&workspace)? } else { crates(&workspace) };
    let outside = Outside::new(&workspace, crates);
    run_command(&mut outside.pages())?;
    let site = workspace.target_directory.join("web");
    let modules = outside.target.join(WASM).join("release");
    let of_viewer = |page: &&&str| **page == VIEWER;
    let (viewer, others): (Vec<&&str>, Vec<&&str>) = PAGES.iter().partition(of_viewer);
    let folders = [(site.clone(), others, FILES), (site.join(VIEWER), viewer, VIEWER_FILES)];
    for (folder, pages, files) in folders {
        // Not optimised, as among the tests of `outside`: to run it takes less than to build it once more.
        let mut bindgen = outside.cargo("run");
        bindgen.args(["--package", "bindgen", "--"]).arg(&folder);
        bindgen.args(pages.iter().map(|page| modules.join(**page).with_extension("wasm")));
        run_command(&mut bindgen)?;
        for file in files.iter().map(|file| programs().join(file)) {
            let name = file.file_name().context("each has a name")?;
            fs::copy(&file, folder.join(name)).with_context(|| file.display().to_string())?;
        }
    }
    Ok(site)
}

/// Name and folder of each library that others may use.
fn crates(workspace: &Workspace) -> Vec<(&str, PathBuf)> {
    let folder = |package: &Package| package.manifest_path.parent().map(Path::to_owned);
    let libraries = workspace.published().filter(|package| package.has_library());
    libraries.filter_map(|package| Some((&*package.name, folder(package)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_and_their_files_are_there() {
        for file in FILES.iter().chain(VIEWER_FILES) {
            assert!(programs().join(file).is_file(), "{file}");
        }
        for page in PAGES {
            assert!(programs().join(page).join("Cargo.toml").is_file(), "{page}");
        }
    }

    #[test]
    fn parse_flags_in_any_order() {
        let parse =
            |args: &[&str]| parse(&args.iter().map(|arg| OsString::from(*arg)).collect::<Vec<_>>());
        assert_eq!(parse(&[]), Ok(Web::default()));
        assert_eq!(parse(&["--packages"]), Ok(Web::OF_PACKAGES));
        let both = Ok(Web { installs: true, of_packages: true });
        assert_eq!(parse(&["--install", "--packages"]), both);
        assert_eq!(parse(&["--packages", "--install"]), both);
        assert!(parse(&["--serve"]).unwrap_err().contains("found `--serve`"));
    }
}
