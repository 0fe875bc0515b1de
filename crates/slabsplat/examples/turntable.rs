//! A film of a thing that turns: `cargo run --release -p slabsplat --features film --example turntable
//! [FILE]`.
//!
//! The file is `.gif`, `.webp`, `.apng` or `.png-sequence`, or with ffmpeg `.mp4` or `.webm`. Run again after
//! it was interrupted, it continues.

use slabsplat::TurnAxis;
use slabsplat::film::{FilmDesc, FilmFormat, FilmReport, FilmWriter, FrameRate, Step, Turn};
use slabsplat::{Automatic, ImageDesc, RenderSettings, Renderer, io};
use std::error::Error;
use std::path::{Path, PathBuf};

const N_FRAMES: u32 = 48;

fn main() -> Result<(), Box<dyn Error>> {
    let path = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "turntable.gif".to_owned()));
    let report = turn(&path)?;
    println!("{}: {} frames, {} bytes", path.display(), report.n_frames, report.n_bytes);
    Ok(())
}

/// Makes the film.
pub(crate) fn turn(path: &Path) -> Result<FilmReport, Box<dyn Error>> {
    let format = FilmFormat::of_name(path).ok_or("name the film .gif")?;
    let image = ImageDesc::new(256, 256).background([0.05, 0.05, 0.07, 1.0]);
    let volume = io::builtin_volume("neuron", None)?;
    let scene = Automatic::new(volume).scene(image, RenderSettings::default());
    let turn = Turn::new(TurnAxis::Up, 360.0, N_FRAMES);
    let mut renderer = Renderer::open("auto", |note| eprintln!("{note}"))?;

    let desc = FilmDesc::new(image.width, image.height, N_FRAMES, FrameRate::new(20.0)?)?;
    let film = FilmWriter::begin(path, format, desc, "a neuron that turns once")?;
    let frame = |frame_idx| -> Result<_, Box<dyn Error>> {
        Ok(renderer.render(&turn.scene_at(&scene, frame_idx)?)?.image)
    };
    let tell = |step| {
        if let Step::Rendered(n_done) = step {
            eprintln!("{n_done} of {N_FRAMES}");
        }
    };
    film.make(frame, tell)
}
