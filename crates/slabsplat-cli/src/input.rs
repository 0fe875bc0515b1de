//! What a command is to work on: a scene file, a volume file, standard input, a raw file, or a built-in
//! volume.

use crate::flags::RawFlags;
use crate::{progress, stdin};
use anyhow::{Result, anyhow, bail};
use slabsplat::io::{
    self, IoError, LayerFile, LoadedVolume, MemoryNeed, RawDesc, SceneFile, VolumeSource,
};
use std::path::Path;

/// The scene of `input`. That of a volume or a mesh is empty: all of it is found from what that holds.
pub(crate) fn scene_file(input: &Path) -> Result<SceneFile> {
    if let Some(builtin) = input.to_str().and_then(|input| input.strip_prefix("builtin:")) {
        return Ok(SceneFile::of_volume(builtin_source(builtin)?));
    }
    if is_scene(input) {
        return Ok(io::read_scene(input)?);
    }
    if io::is_mesh_name(input) {
        return Ok(SceneFile::of_mesh(input));
    }
    Ok(SceneFile::of_volume(VolumeSource::File(input.to_owned())))
}

/// Whether `input` names a scene file.
pub(crate) fn is_scene(input: &Path) -> bool {
    input.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// The volumes of `file`, the first of them as the flags describe it.
pub(crate) fn load(file: &mut SceneFile, flags: &RawFlags) -> Result<Vec<LoadedVolume>> {
    let mut desc = flags.desc()?;
    let Some(first) = file.layers.first_mut() else {
        if flags.spacing.is_some() || desc.is_some() || !flags.parts.are_silent() {
            bail!(
                "there is no volume that --spacing, --dims, --channel and the like could describe"
            );
        }
        return Ok(Vec::new());
    };
    if let Some(spacing) = flags.spacing {
        first.spacing = Some(spacing.to_array());
    }
    flags.parts.lay_over(&mut first.options);
    // The same one for all, since layers of one volume and the same options share it.
    let reading = progress::reading();
    file.layers.iter_mut().for_each(|layer| layer.options.progress = Some(reading.clone()));
    stdin::check(file)?;
    io::check_memory(MemoryNeed::of_layers(&file.layers))?;
    LayerFile::load_volumes(&file.layers, |layer| match desc.take() {
        desc if stdin::is_stdin(layer) => stdin::load(layer, desc.as_ref()).map_err(of_raw),
        Some(desc) => load_raw(layer, &desc),
        None => layer.load_volume().map_err(|error| of_raw(error.into())),
    })
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

fn load_raw(layer: &LayerFile, desc: &RawDesc) -> Result<LoadedVolume> {
    let spacing = layer.spacing.unwrap_or(desc.spacing);
    match &layer.volume {
        VolumeSource::File(path) => Ok(io::read_raw(path, &RawDesc { spacing, ..*desc })?),
        VolumeSource::Builtin { name, .. } => {
            bail!("{name} is built in, not a raw file: leave out --dims, --type and the like")
        }
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
