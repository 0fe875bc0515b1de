//! A volume that comes by standard input, which is named `-`.

use anyhow::{Context, Result, bail};
use slabsplat::io::{
    self, FilesInMemory, IoError, LayerFile, LoadedVolume, RawDesc, SceneFile, VolumeSource,
};
use std::io::{ErrorKind, IsTerminal};
use std::path::Path;

/// What stands for it where a volume is named; an array's name may follow, as in `-:name`.
const DASH: &str = "-";

/// What it is called in messages.
const NAME: &str = "standard input";

/// Whether the layer's volume comes by standard input.
pub(crate) fn is_stdin(layer: &LayerFile) -> bool {
    array_of(layer).is_some()
}

/// What follows the dash: nothing, or `:name`.
fn array_of(layer: &LayerFile) -> Option<&str> {
    let VolumeSource::File(path) = &layer.volume else { return None };
    let after = path.to_str()?.strip_prefix(DASH)?;
    (after.is_empty() || after.starts_with(':')).then_some(after)
}

/// That it is asked for once, and for nothing but a volume.
pub(crate) fn check(file: &SceneFile) -> Result<()> {
    if 1 < file.layers.iter().filter(|layer| is_stdin(layer)).count() {
        bail!("{NAME} can be read once, and two layers are to come by it: save it as a file");
    }
    let dash = Path::new(DASH);
    let is_label =
        |layer: &LayerFile| layer.labels.as_ref().is_some_and(|labels| labels.path == dash);
    if file.meshes.iter().any(|mesh| mesh.path == dash) || file.layers.iter().any(is_label) {
        bail!("only volumes come by {NAME}: save labels and meshes as files");
    }
    Ok(())
}

/// Reads all of it, and the volume that it is, raw if there is a description.
pub(crate) fn load(layer: &LayerFile, desc: Option<&RawDesc>) -> Result<LoadedVolume> {
    let stdin = std::io::stdin();
    if stdin.is_terminal() {
        bail!("{NAME} is a terminal: pipe a volume into it, as by `slabsplat info - < head.nrrd`");
    }
    let bytes = io::read_stream(NAME, &mut stdin.lock())?;
    let files = FilesInMemory::from_iter([(NAME, bytes.as_slice())]);
    let loaded = match desc {
        Some(desc) => files.read_raw(NAME, desc)?,
        None => {
            let path = format!("{NAME}{}", array_of(layer).unwrap_or_default());
            files.read_volume_with(path, &layer.options).map_err(needs_files)?
        }
    };
    match layer.spacing {
        None => Ok(loaded),
        Some(spacing) => loaded.with_spacing(spacing).context(NAME),
    }
}

fn needs_files(error: IoError) -> anyhow::Error {
    match error {
        IoError::Read { path, source } if source.kind() == ErrorKind::NotFound => {
            anyhow::anyhow!(
                "{NAME} needs the file {}, which is beside no stream: name its file",
                path.display()
            )
        }
        other => other.into(),
    }
}
