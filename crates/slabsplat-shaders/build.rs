//! Puts the shaders of `shaders/` together, validates and reflects them, translates them to SPIR-V, and
//! writes what came out as Rust tables.
//!
//! naga does all of it, the same compiler that wgpu has inside; no program needs to be installed.

#[path = "build/assemble.rs"]
mod assemble;
#[path = "build/reflect.rs"]
mod reflect;
#[path = "build/translate.rs"]
mod translate;
#[path = "build/write.rs"]
mod write;

use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

fn main() -> Result<()> {
    let shaders = shaders_folder()?;
    println!("cargo::rerun-if-changed={}", shaders.display());
    let mut reflected = Vec::new();
    for stage in assemble::stages(&shaders)? {
        let shader =
            translate::translate(&stage).with_context(|| format!("shaders/{}.wgsl", stage.name))?;
        reflected.push(shader);
    }
    let out = std::env::var_os("OUT_DIR").context("cargo says where to write")?;
    std::fs::write(Path::new(&out).join("shaders.rs"), write::tables(&reflected))?;
    Ok(())
}

/// Where the shaders are. In a package from a registry `shaders` is a folder. In a checkout it is a link to
/// the top level's, which cargo follows when it packages; where git makes no links, as on Windows unless told
/// to, it is a text file that names the link's end, and no package can be made there.
fn shaders_folder() -> Result<PathBuf> {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").context("cargo says where this is")?;
    let packaged = Path::new(&package).join("shaders");
    Ok(if packaged.is_dir() { packaged } else { Path::new(&package).join("../../shaders") })
}
