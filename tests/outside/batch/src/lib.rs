//! Renders scene files to PNGs beside them, one after the other with one renderer, which keeps what a scene
//! has in common with the one before it.

use slabsplat::io::{read_scene, write_picture};
use slabsplat::{OpenScene, Renderer};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Whatever went wrong with a scene.
pub type Failure = Box<dyn Error>;

/// Renders the scene file, and returns the path of the picture.
///
/// # Errors
/// If the scene cannot be read or drawn, or the picture not written.
pub fn render(renderer: &mut Renderer, scene: &Path) -> Result<PathBuf, Failure> {
    let named = |error: &dyn Error| format!("{}: {error}", scene.display());
    // What cannot be read says itself in which line.
    let file = read_scene(scene)?;
    let opened = OpenScene::open(&file).map_err(|error| named(&error))?;
    for warning in &opened.warnings {
        eprintln!("{}: {warning}", scene.display());
    }
    let frame = renderer.render(&opened.scene).map_err(|error| named(&error))?;
    let picture = scene.with_extension("png");
    write_picture(&picture, &frame.image)?;
    Ok(picture)
}
