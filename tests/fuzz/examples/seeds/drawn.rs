//! First inputs of what draws: annotations and films.

use std::fs;

use slabsplat_core::Image;
use slabsplat_film::{FilmDesc, FilmError, FilmFormat, FilmWriter, FrameRate};
use slabsplat_fuzz::{FILM, FILM_FILES};

use super::{Seeds, joined};

/// Texts of usual sizes on pictures of usual and of odd ones.
pub(super) fn annotations() -> Seeds {
    let input = |[width, height]: [u16; 2], size_pixels: f32, extent: f32, text: &str| {
        let at = [f32::from(width) / 2.0, f32::from(height) / 2.0];
        let numbers = [at[0], at[1], 0.5, 0.5, size_pixels, 9.0, 7.0, 5.0, extent];
        let numbers: Vec<u8> = numbers.into_iter().flat_map(f32::to_le_bytes).collect();
        [&width.to_le_bytes()[..], &height.to_le_bytes(), &numbers, text.as_bytes()].concat()
    };
    vec![
        input([199, 149], 20.0, 12.0, "A title – µ"),
        input([399, 299], 60.0, -0.6, "10⁻³ \u{6f22} Ж"),
        input([0, 63], 9.0, 1e-3, "one column"),
        input([99, 99], 300.0, -1.0, ""),
    ]
}

/// Folders of films that were interrupted after two frames.
pub(super) fn films() -> anyhow::Result<Seeds> {
    let rate = FrameRate::new(10.0)?;
    let desc = FilmDesc::new(FILM.width, FILM.height, FILM.n_frames, rate)?;
    let dir = tempfile::tempdir()?;
    let film = FilmWriter::begin(dir.path().join("a"), FilmFormat::Apng, desc, FILM.identity)?;
    let render = |frame_idx: u32| match frame_idx {
        2 => Err(FilmError::BadSeconds(0.0)),
        _ => Ok(Image::filled(FILM.width, FILM.height, [0.5, 0.25, 0.125, 1.0])),
    };
    anyhow::ensure!(film.make(render, |_| ()).is_err(), "it is interrupted");
    let read = |name: &&str| fs::read(dir.path().join("a.frames").join(name)).unwrap_or_default();
    let files: Vec<Vec<u8>> = FILM_FILES.iter().map(read).collect();
    let files = joined(&files.iter().map(Vec::as_slice).collect::<Vec<_>>());
    Ok((0..16).map(|first| [&[first], files.as_slice()].concat()).collect())
}
