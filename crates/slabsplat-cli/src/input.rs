//! What a command is to work on: a scene file, a picture that says what it shows, a volume file, standard
//! input, a raw file, or a built-in volume.

use crate::flags::RawFlags;
use crate::{progress, stdin, terminal};
use anyhow::{Result, anyhow, bail};
use slabsplat::OpenError;
use slabsplat::film::FilmFormat;
use slabsplat::io::{
    self, IoError, LayerFile, LoadedVolume, MemoryNeed, PictureFormat, PictureScene, Provenance,
    SceneFile, VolumeSource,
};
use std::io::ErrorKind;
use std::path::Path;

/// The scene of `input`. That of a volume or a mesh is empty: all of it is found from what that holds.
pub(crate) fn scene_file(input: &Path) -> Result<SceneFile> {
    if let Some(builtin) = input.to_str().and_then(|input| input.strip_prefix("builtin:")) {
        return Ok(SceneFile::of_volume(builtin_source(builtin)?));
    }
    if is_scene(input) {
        return Ok(io::read_scene(input)?);
    }
    if is_picture(input) {
        return of_picture(input);
    }
    check_no_film(input)?;
    if io::is_mesh_name(input) {
        return Ok(SceneFile::of_mesh(input));
    }
    Ok(SceneFile::of_volume(VolumeSource::File(input.to_owned())))
}

/// That `input` is no film, which would be taken for a volume.
fn check_no_film(input: &Path) -> Result<()> {
    let Some(format) = FilmFormat::of_name(input) else { return Ok(()) };
    let path = input.display();
    if format == FilmFormat::PngSequence {
        bail!(
            "{path} is a film: name one of its frames, as {path}/frame_00000.png, which says what it shows"
        );
    }
    bail!(
        "{path} is a film, and {} has no room for what it shows: take the scene file that --save-scene wrote of \
         it; webp and apng have room",
        format.name()
    )
}

/// Whether `input` names a scene file.
pub(crate) fn is_scene(input: &Path) -> bool {
    input.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Whether `input` names a picture. A TIFF is one if it says what it shows, and else a volume.
pub(crate) fn is_picture(input: &Path) -> bool {
    PictureFormat::of_picture(input).is_some_and(|format| {
        !format.holds_volumes() || matches!(io::read_picture_scene(input), Ok(Some(_)))
    })
}

/// The scene that a picture shows.
fn of_picture(input: &Path) -> Result<SceneFile> {
    let Some(PictureScene { scene, program, .. }) = io::read_picture_scene(input)? else {
        bail!(
            "{} is a picture that does not say what it shows: slabsplat did not make it, or with \
             --no-metadata; of slices of a volume, name the folder",
            input.display()
        )
    };
    if let Some(program) = program.filter(|program| program != Provenance::PROGRAM) {
        let path = input.display();
        terminal::warn(&format!(
            "{path} was made by {program}, and this is {}: pixels may differ",
            Provenance::PROGRAM
        ));
    }
    Ok(scene)
}

/// The volumes of `file`, the first of them as the flags describe it.
pub(crate) fn load(file: &mut SceneFile, flags: &RawFlags) -> Result<Vec<LoadedVolume>> {
    describe(file, flags)?;
    stdin::check(file)?;
    io::check_memory(MemoryNeed::of_layers(&file.layers))?;
    LayerFile::load_volumes(&file.layers, |layer| {
        if stdin::is_stdin(layer) {
            return stdin::load(layer, layer.raw.as_ref()).map_err(of_raw);
        }
        layer.load_volume().map_err(|error| of_raw(error.into()))
    })
}

/// Lays over `file` what flags say of its first volume.
pub(crate) fn describe(file: &mut SceneFile, flags: &RawFlags) -> Result<()> {
    let desc = flags.desc()?;
    let Some(first) = file.layers.first_mut() else {
        if !flags.are_silent() {
            bail!(
                "there is no volume that --spacing, --dims, --channel and the like could describe"
            );
        }
        return Ok(());
    };
    if let Some(spacing) = flags.spacing {
        first.spacing = Some(spacing.to_array());
    }
    flags.parts.lay_over(&mut first.options);
    if let (Some(_), VolumeSource::Builtin { name, .. }) = (&desc, &first.volume) {
        bail!("{name} is built in, not a raw file: leave out --dims, --type and the like");
    }
    first.raw = desc.or(first.raw.take());
    // The same one for all, since layers of one volume and the same options share it.
    let reading = first.options.progress.clone().unwrap_or_else(progress::reading);
    file.layers.iter_mut().for_each(|layer| layer.options.progress = Some(reading.clone()));
    Ok(())
}

/// What to do if a file is missing that a picture names.
pub(crate) fn where_files_are(picture: &Path, error: anyhow::Error) -> anyhow::Error {
    let is_missing = |error: &IoError| match error {
        IoError::Read { path, source } => path != picture && source.kind() == ErrorKind::NotFound,
        _ => false,
    };
    let of_opening = match error.downcast_ref::<OpenError>() {
        Some(OpenError::Io(error)) => Some(error),
        _ => error.downcast_ref(),
    };
    if of_opening.is_some_and(is_missing) {
        let what = terminal::one_line(&error);
        return anyhow!("{what}; pictures tell no folders: start slabsplat where the file is");
    }
    error
}

/// What to do if nothing knows the format.
fn of_raw(error: anyhow::Error) -> anyhow::Error {
    match error.downcast_ref() {
        Some(IoError::UnknownFormat { .. }) => {
            anyhow!("{error}; --dims and --type tell what a raw file holds")
        }
        _ => error,
    }
}

fn builtin_source(builtin: &str) -> Result<VolumeSource> {
    let (name, size) = match builtin.split_once(':') {
        Some((name, size)) => {
            let size = size.parse().map_err(|_| {
                anyhow!("builtin:{builtin}: the size must be a number of voxels, not {size:?}")
            })?;
            (name, Some(size))
        }
        None => (builtin, None),
    };
    Ok(VolumeSource::Builtin { name: name.to_owned(), size })
}
