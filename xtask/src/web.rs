//! `cargo xtask web`: builds the pages of `tests/outside` for WebAssembly, with vectors, and has a browser
//! draw in one of them what the CPU draws here.
//!
//! The pages lie in `target/web` afterwards, and any web server shows them:
//! `python3 -m http.server -d target/web`. They are built of the crates in this checkout. What is judged, and
//! how, is in `tests/tests/browser.rs`.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use xtask::process::{cargo, run as run_command};
use xtask::workspace::{self, Package, Workspace};

use crate::lint::{WASM, WASM_FLAGS, WASM_VECTORS, has_target};
use crate::outside::{patch, programs};
use crate::system;

/// Those that are pages; another is what writes their JavaScript.
pub(crate) const PAGES: &[&str] = &["browser", "page"];

/// What is served as it is.
const FILES: &[&str] = &["browser/site/test.html", "browser/site/test.js", "page/index.html"];

/// Tells the test where the pages are.
const SITE: &str = "SLABSPLAT_SITE";

/// Set to anything, it makes the want of a browser a failure.
const REQUIRE_GPU: &str = "SLABSPLAT_REQUIRE_GPU";

/// Whether the arguments ask to install.
pub(crate) fn parse(args: &[OsString]) -> Result<bool, String> {
    match args {
        [] => Ok(false),
        [flag] if flag == "--install" => Ok(true),
        [arg, ..] => Err(format!("`web` takes `--install` alone, found `{}`", arg.display())),
    }
}

pub(crate) fn run(installs: bool) -> Result<()> {
    system::set_up("web", system::BROWSER, installs);
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
    let site = build()?;
    let mut test = cargo(workspace::root());
    test.args(["test", "--package", "slabsplat-tests", "--test", "browser", "--", "--nocapture"]);
    run_command(test.env(SITE, site))
}

/// Builds the pages, and returns the folder that has them and all that they load.
fn build() -> Result<PathBuf> {
    let workspace = Workspace::read()?;
    let target = workspace.target_directory.join("outside");
    let crates = crates(&workspace);
    let outside = |subcommand: &str| {
        let mut command = cargo(&programs());
        command.args([subcommand, "--release", "--target-dir"]).arg(&target);
        patch(&mut command, &crates);
        command
    };
    let mut pages = outside("build");
    pages.args(["--target", WASM]).args(PAGES.iter().flat_map(|page| ["--package", *page]));
    run_command(pages.env(WASM_FLAGS, WASM_VECTORS))?;
    let site = workspace.target_directory.join("web");
    let modules = target.join(WASM).join("release");
    let mut bindgen = outside("run");
    bindgen.args(["--package", "bindgen", "--"]).arg(&site);
    bindgen.args(PAGES.iter().map(|page| modules.join(page).with_extension("wasm")));
    run_command(&mut bindgen)?;
    for file in FILES.iter().map(|file| programs().join(file)) {
        let name = file.file_name().context("each has a name")?;
        fs::copy(&file, site.join(name)).with_context(|| file.display().to_string())?;
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
        for file in FILES {
            assert!(programs().join(file).is_file(), "{file}");
        }
        for page in PAGES {
            assert!(programs().join(page).join("Cargo.toml").is_file(), "{page}");
        }
    }

    #[test]
    fn parse_takes_install_alone() {
        let parse =
            |args: &[&str]| parse(&args.iter().map(|arg| OsString::from(*arg)).collect::<Vec<_>>());
        assert_eq!((parse(&[]), parse(&["--install"])), (Ok(false), Ok(true)));
        assert!(parse(&["--serve"]).unwrap_err().contains("found `--serve`"));
    }
}
