//! A series of frames around a volume, as for a film: `cargo run --release -p slabsplat --example turntable
//! [DIR]`.

use slabsplat::{Automatic, ImageDesc, RenderSettings, Renderer, io};
use std::error::Error;
use std::path::{Path, PathBuf};

const N_FRAMES: u32 = 24;

fn main() -> Result<(), Box<dyn Error>> {
    let dir = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "turntable".to_owned()));
    std::fs::create_dir_all(&dir)?;
    turn(&dir)?;
    println!("{N_FRAMES} frames in {}", dir.display());
    Ok(())
}

/// Writes a picture of each step into `dir`.
pub(crate) fn turn(dir: &Path) -> Result<(), Box<dyn Error>> {
    let volume = io::builtin_volume("neuron", None)?;
    let image = ImageDesc { width: 256, height: 256, background: [0.05, 0.05, 0.07, 1.0] };
    let mut scene = Automatic::new(volume).scene(image, RenderSettings::default());
    let mut renderer = Renderer::open("auto", |note| eprintln!("{note}"))?;

    let step_radians = std::f64::consts::TAU / f64::from(N_FRAMES);
    for frame_idx in 0..N_FRAMES {
        let frame = renderer.render(&scene)?;
        io::write_picture(dir.join(format!("frame-{frame_idx:03}.png")), &frame.image)?;
        scene.camera = scene.camera.orbited(step_radians);
    }
    Ok(())
}
