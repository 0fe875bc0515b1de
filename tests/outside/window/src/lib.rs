//! What the window is made of, so that tests can have it without a screen.

mod orbit;
mod picture;
mod window;

pub use orbit::Orbit;
pub use picture::{By, Picture};
pub use window::Window;

use slabsplat::{Volume, io};
use std::path::Path;
use std::sync::Arc;

/// A volume of that name: a file, or a built-in one.
///
/// # Errors
/// If there is none.
pub fn open(name: &str) -> Result<Arc<Volume>, io::IoError> {
    if Path::new(name).exists() {
        return Ok(io::read_volume(name)?.volume);
    }
    Ok(Arc::new(io::builtin_volume(name, None)?))
}
