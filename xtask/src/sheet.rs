//! `cargo xtask sheet`: one picture of how all volumes of a folder look to somebody who says nothing.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use xtask::process::{cargo, run as run_command};
use xtask::workspace;

/// Names a folder of volumes in the environment, as for tests.
const VARIABLE: &str = "SLABSPLAT_DATA";

/// Where tests look for volumes otherwise.
const FOLDERS: [&str; 2] = ["../shared/data", "tests/data"];

/// Which folder, and into which picture.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Sheet {
    folder: Option<PathBuf>,
    picture: Option<PathBuf>,
}

/// At most a folder and a picture.
pub(crate) fn parse(args: &[OsString]) -> Result<Sheet, String> {
    let path = |idx: usize| args.get(idx).map(PathBuf::from);
    match args.get(2) {
        Some(arg) => {
            Err(format!("`sheet` takes a folder and a picture, found `{}` too", arg.display()))
        }
        None => Ok(Sheet { folder: path(0), picture: path(1) }),
    }
}

pub(crate) fn run(sheet: &Sheet) -> Result<()> {
    let root = workspace::root();
    let named = std::env::var_os(VARIABLE).filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let usual = || FOLDERS.iter().map(Path::new).find(|folder| root.join(folder).is_dir());
    let folder = sheet.folder.clone().or(named).or_else(|| usual().map(Path::to_owned));
    let folder = folder.context("there is no folder of volumes: name one")?;
    let picture = sheet.picture.clone().unwrap_or_else(|| "target/sheet.png".into());
    let example =
        ["run", "--release", "--package", "slabsplat", "--example", "contact_sheet", "--"];
    run_command(cargo(root).args(example).args([folder, picture]))
}
