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
use std::path::Path;

fn main() -> Result<()> {
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
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
