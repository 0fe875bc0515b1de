//! `slabsplat scene`: what would be drawn, as a scene file.

use crate::flags::{SceneFlags, check_folder, check_scene_name};
use crate::{input, output, terminal};
use anyhow::Result;
use clap::Args;
use slabsplat::io::{self, SceneFile};
use std::path::PathBuf;

/// Print the scene of a volume, a scene file or a picture, with all that is found for it
///
/// What is printed draws the same picture again, and can be changed: paths in it start from the working
/// directory. Of a picture it is what the picture says, whose volumes need not be there.
#[derive(Args)]
pub(crate) struct SceneArgs {
    /// Write a scene file instead of printing it; paths in it start from its folder
    #[arg(short, long, value_name = "FILE.toml")]
    output: Option<PathBuf>,

    #[command(flatten)]
    scene: SceneFlags,
}

pub(crate) fn run(args: &SceneArgs) -> Result<()> {
    if let Some(path) = &args.output {
        check_scene_name(path)?;
        check_folder(path, false)?;
    }
    let scene = scene(&args.scene)?;
    match &args.output {
        Some(path) => Ok(output::write_scene(path, &scene)?),
        None => terminal::answer(&shown(&io::scene_text(&scene, "scene.toml")?)),
    }
}

fn scene(flags: &SceneFlags) -> Result<SceneFile> {
    // The volumes of a picture may be elsewhere.
    if input::is_picture(flags.input()) && flags.are_of_file() {
        let file = flags.in_scene(|| flags.file())?;
        if file.is_fitted() {
            return Ok(file);
        }
    }
    let opened = flags.open()?;
    terminal::warn_all(&opened.warnings);
    Ok(opened.to_file()?)
}

/// The text without what would command a terminal, which names of files may hold.
fn shown(text: &str) -> String {
    let is_harmless = |c: char| !c.is_control() || c == '\n';
    text.chars().map(|c| if is_harmless(c) { c } else { char::REPLACEMENT_CHARACTER }).collect()
}
