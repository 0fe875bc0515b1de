//! What the fuzz targets of slabsplat share: an input becomes files in memory, and these are read in every
//! way that the file offers. Beside the readers, texts that are drawn and folders of films are fuzzed.
//!
//! `cargo xtask fuzz` runs all targets, `cargo xtask fuzz dicom 3600` one of them for an hour. It needs
//! `cargo install cargo-fuzz --locked` and a nightly toolchain. Inputs begin with small valid files, which
//! `examples/seeds` makes; what libFuzzer finds beside them stays in `target/fuzz/corpus`.
//!
//! An input that crashes a reader, holds it for ten seconds or makes it take a gigabyte is left in the folder
//! `artifacts` beside this crate's manifest. `cargo fuzz tmin` makes it small; what is mended gets a test in
//! `crates/slabsplat-io/tests/hostile_files.rs`, or in the crate that it breaks, that has the input's bytes.

use slabsplat_io::{FilesInMemory, IoError, Part, VolumeListing, VolumeOptions};

/// A film that is continued from whatever its folder has.
#[derive(Clone, Copy, Debug)]
pub struct SmallFilm {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How many.
    pub n_frames: u32,
    /// What tells it from others.
    pub identity: &'static str,
}

/// The film that folders are fuzzed of.
pub const FILM: SmallFilm = SmallFilm { width: 3, height: 2, n_frames: 3, identity: "scene = a" };

/// The files of its folder that an input has, in this order.
pub const FILM_FILES: &[&str] =
    &["film.txt", "frame_00000.png", "frame_00001.png", "film.part", "frame.part"];

/// What parts the files of an input.
pub const BETWEEN: &[u8] = b"\n-8<-\n";

/// The parts of an input as files of these names, as far as there are any.
pub fn files<'b>(names: &[&str], input: &'b [u8]) -> FilesInMemory<'b> {
    FilesInMemory::from_iter(names.iter().copied().zip(parts(input)))
}

/// What is between the marks.
pub fn parts(input: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = Some(input);
    std::iter::from_fn(move || {
        let bytes = rest?;
        let end = bytes.windows(BETWEEN.len()).position(|window| window == BETWEEN);
        rest = end.map(|end| &bytes[end + BETWEEN.len()..]);
        Some(&bytes[..end.unwrap_or(bytes.len())])
    })
}

/// Reads what there is by default, and then the last part of each kind. What is read must be what was listed.
pub fn read_volume(files: &FilesInMemory<'_>, path: &str) {
    let default = VolumeOptions::default();
    let listing = files.list_volume(path, &default).inspect_err(check_message).ok();
    read_with(files, path, &default, listing.as_ref());
    let Some(listing) = listing else { return };
    for &part in Part::ALL {
        let last = listing.choices.get(part).n - 1;
        let options = VolumeOptions::default();
        let options = match part {
            Part::Series => options.series(last),
            Part::Channel => options.channel(last),
            Part::Time => options.time(last),
            Part::Level => options.level(last),
            _ => continue,
        };
        if 0 < last {
            let listing = files.list_volume(path, &options).inspect_err(check_message).ok();
            read_with(files, path, &options, listing.as_ref());
        }
    }
}

fn read_with(
    files: &FilesInMemory<'_>,
    path: &str,
    options: &VolumeOptions,
    listing: Option<&VolumeListing>,
) {
    let Ok(loaded) = files.read_volume_with(path, options).inspect_err(check_message) else {
        return;
    };
    loaded.warnings.iter().for_each(|warning| check_line(warning));
    if let Some(listing) = listing {
        assert_eq!(loaded.volume.grid().dims(), listing.dims, "listed otherwise");
        assert_eq!(loaded.format, listing.format, "listed otherwise");
    }
}

/// What an error says is fit for people.
pub fn check_message(error: &IoError) {
    check_line(&error.to_string());
}

/// One line, with nothing in it that commands a terminal.
pub fn check_line(message: &str) {
    assert!(!message.contains(|c: char| c.is_control()), "{message:?}");
}
