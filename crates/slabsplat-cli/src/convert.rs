//! `slabsplat convert`: the same volume in another format.

use crate::flags::RawFlags;
use crate::progress::Progress;
use crate::{input, output, terminal};
use anyhow::{Result, bail};
use clap::Args;
use slabsplat::io::VolumeOutput;
use std::path::PathBuf;

/// Write a volume in another format; a file of that name is replaced
#[derive(Args)]
pub(crate) struct ConvertArgs {
    /// A volume file, a built-in volume as builtin:NAME or builtin:NAME:SIZE, or - for standard input
    #[arg(value_name = "VOLUME")]
    volume: PathBuf,

    /// The file to write: .nrrd, .nii, .nii.gz, .mha, .npy, .raw (with a .json beside it) or .zarr
    #[arg(value_name = "OUTPUT")]
    output: PathBuf,

    #[command(flatten)]
    raw: RawFlags,
}

pub(crate) fn run(args: &ConvertArgs) -> Result<()> {
    // What would fail after the work must fail before it.
    VolumeOutput::of(&args.output)?;
    if input::is_scene(&args.volume) || input::is_picture(&args.volume) {
        bail!(
            "{} is a scene, or a picture of one: name the volume that it shows",
            args.volume.display()
        );
    }
    let progress = Progress::start("reading", 0);
    let mut file = input::scene_file(&args.volume)?;
    let mut volumes = input::load(&mut file, &args.raw)?;
    let Some(loaded) = volumes.pop() else {
        bail!("{} is a mesh, not a volume", args.volume.display());
    };
    progress.stage("writing");
    let lost = output::write_volume(&args.output, &loaded)?;
    drop(progress);
    terminal::warn_all(&loaded.warnings);
    terminal::warn_all(&lost);
    let [nx, ny, nz] = loaded.volume.grid().dims();
    terminal::say(format_args!("{}: {nx} x {ny} x {nz} voxels", args.output.display()));
    Ok(())
}
