//! `slabsplat view`: a window on a volume or a scene.

use crate::flags::{HowFlags, SceneFlags};
use crate::{input, terminal};
use anyhow::Result;
use clap::Args;
use slabsplat_viewer::{Opening, Start};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Look at a volume or a scene in a window
///
/// Drag to turn it, turn the wheel to zoom; ? shows all keys. Pictures at rest are what `render` makes of the
/// scene that the window saves.
#[derive(Args)]
pub(crate) struct ViewArgs {
    /// What is opened, as `render` takes it; more can be opened in the window
    #[arg(value_name = "INPUT", help_heading = "Input")]
    input: Option<PathBuf>,

    #[command(flatten)]
    how: HowFlags,
}

pub(crate) fn run(args: ViewArgs) -> Result<()> {
    let opener = |path: &Path| input::scene_file(path).map_err(|error| terminal::one_line(&error));
    let mut start = Start::new(Arc::new(opener));
    if let Some(backend) = args.how.backend() {
        backend.clone_into(&mut start.backend);
    }
    if let Some(input) = args.input {
        let name = input.file_name().unwrap_or(input.as_os_str()).to_string_lossy().into_owned();
        let scene = SceneFlags::of(input, args.how);
        // What cannot be is said where the command was given, before there is a window.
        let file = scene.file()?;
        if start.backend == "auto" {
            start.backend.clone_from(&file.backend);
        }
        let opening: Opening = Box::new(move |size, hear| {
            scene.open_for(size, hear).map_err(|error| terminal::one_line(&error))
        });
        start.scene = Some((name, opening));
    }
    Ok(slabsplat_viewer::show(start)?)
}
