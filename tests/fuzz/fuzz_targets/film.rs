//! Folders of films that were interrupted. The first byte says what film is continued, and where it is
//! interrupted once more; the others are the files that its folder has.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use slabsplat_core::Image;
use slabsplat_film::{FilmDesc, FilmError, FilmFormat, FilmReport, FilmWriter, FrameRate, Step};
use slabsplat_fuzz::{FILM, FILM_FILES, check_line, parts};

/// What is made without another program.
const FORMATS: [FilmFormat; 4] =
    [FilmFormat::Gif, FilmFormat::WebP, FilmFormat::Apng, FilmFormat::PngSequence];

fuzz_target!(|input: &[u8]| {
    let Some((&first, files)) = input.split_first() else { return };
    let format = FORMATS[usize::from(first) % FORMATS.len()];
    let broken_at = u32::from(first) / 4 % (FILM.n_frames + 1);
    let at_once = made(files, format, FILM.n_frames);
    let in_two = made(files, format, broken_at);
    assert_eq!(at_once, in_two, "an interrupted film is another one");
});

/// The bytes of the film, file by file, that is continued from `files`, and interrupted before a frame; or
/// why there is none.
fn made(files: &[u8], format: FilmFormat, broken_at: u32) -> Result<Vec<Vec<u8>>, String> {
    let dir = tempfile::tempdir().expect("the system has a folder for such");
    let target = dir.path().join("a");
    let folder = dir.path().join("a.frames");
    std::fs::create_dir(&folder).expect("it is new");
    for (name, bytes) in FILM_FILES.iter().zip(parts(files)) {
        std::fs::write(folder.join(name), bytes).expect("there is room");
    }
    // A frame that is there is not rendered, so that the first run may make the film.
    let is_made = broken_at < FILM.n_frames && continued(&target, format, broken_at).is_ok();
    let rest = if is_made { Ok(()) } else { continued(&target, format, FILM.n_frames).map(drop) };
    rest.map_err(|error| {
        let folder = dir.path().to_string_lossy().into_owned();
        let message = error.to_string().replace(&folder, "");
        check_line(&message);
        message
    })?;
    assert!(!folder.exists(), "frames are left");
    Ok(bytes_of(&target))
}

fn continued(target: &Path, format: FilmFormat, broken_at: u32) -> Result<FilmReport, FilmError> {
    let rate = FrameRate::new(10.0).expect("in range");
    let desc = FilmDesc::new(FILM.width, FILM.height, FILM.n_frames, rate).expect("in range");
    let film = FilmWriter::begin(target, format, desc, FILM.identity)?;
    let render = |frame_idx: u32| {
        if frame_idx == broken_at {
            return Err(FilmError::BadSeconds(0.0));
        }
        let value = frame_idx as f32 / 4.0;
        Ok(Image::filled(FILM.width, FILM.height, [value, value, value, 1.0]))
    };
    film.make(render, |step| {
        if let Step::Damaged { what, .. } = step {
            check_line(&what.replace(&*target.to_string_lossy(), ""));
        }
    })
}

fn bytes_of(target: &Path) -> Vec<Vec<u8>> {
    let read = |path: &Path| std::fs::read(path).expect("it was just written");
    if target.is_file() {
        return vec![read(target)];
    }
    let entries = std::fs::read_dir(target).expect("it is a film");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("it is there").path()).collect();
    paths.sort_unstable();
    paths.iter().map(|path| read(path)).collect()
}
