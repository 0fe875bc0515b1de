//! Flags of what `render` writes, and where.

use crate::{output, terminal};
use anyhow::{Context, Result, bail};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use slabsplat::Image;
use slabsplat::io::{self, PictureFormat, Provenance, SceneFile};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputFlags {
    /// The picture: .png or .webp (8 bits), .jpg (8 bits, opaque), .tif (16 bits; with --format tiff-float
    /// 32-bit float, premultiplied) or .exr (32-bit float, premultiplied); - is standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Format of the picture [default: by the name's extension; png on standard output]
    #[arg(long, value_parser = format_parser())]
    format: Option<PictureFormat>,

    /// Write what was drawn as a scene file, too, with all that was found or is by default
    #[arg(long, value_name = "FILE.toml")]
    save_scene: Option<PathBuf>,

    /// Leave the scene out of the picture's metadata, by which it can be rendered again
    #[arg(long)]
    no_metadata: bool,

    /// Make folders that are to be written to and are not there
    #[arg(long)]
    mkdir: bool,
}

fn format_parser() -> impl TypedValueParser<Value = PictureFormat> {
    let names = PictureFormat::ALL.iter().map(|format| format.name());
    PossibleValuesParser::new(names.collect::<Vec<_>>()).map(|name| {
        let is_its = |format: &&PictureFormat| format.name() == name;
        *PictureFormat::ALL.iter().find(is_its).expect("clap knows the choices")
    })
}

/// Where a picture goes.
pub(crate) struct Target {
    /// `None` is standard output.
    pub(crate) path: Option<PathBuf>,
    pub(crate) format: PictureFormat,
}

impl OutputFlags {
    /// Where the picture goes, in a run that may answer on standard output, too. What would fail after the
    /// work fails here.
    pub(crate) fn target(&self, answers: bool) -> Result<Target> {
        if let Some(scene) = &self.save_scene {
            check_scene_name(scene)?;
            check_folder(scene, self.mkdir)?;
        }
        let path = &self.output;
        if path == Path::new("-") {
            if answers {
                bail!("the picture and the answer in JSON cannot both go to standard output");
            }
            if std::io::stdout().is_terminal() {
                bail!("standard output is a terminal: send the picture to a file or a program");
            }
            return Ok(Target { path: None, format: self.format.unwrap_or(PictureFormat::Png) });
        }
        let Some(format) = self.format.or_else(|| PictureFormat::of_name(path)) else {
            return Err(io::IoError::UnknownPicture { path: path.clone() }.into());
        };
        check_folder(path, self.mkdir)?;
        Ok(Target { path: Some(path.clone()), format })
    }

    /// Whether the scene is written anywhere.
    pub(crate) fn has_scene(&self) -> bool {
        self.save_scene.is_some() || !self.no_metadata
    }

    /// Writes the scene file, if there is to be one, and returns its name.
    pub(crate) fn save_scene(&self, scene: Option<&SceneFile>) -> Result<Option<&Path>> {
        let (Some(path), Some(scene)) = (&self.save_scene, scene) else { return Ok(None) };
        output::write_scene(path, scene)?;
        Ok(Some(path))
    }

    /// What the picture is to say of itself.
    pub(crate) fn provenance(&self, scene: Option<&SceneFile>) -> Option<Provenance> {
        let scene = scene.filter(|_| !self.no_metadata)?;
        match Provenance::of_scene(scene, &self.output) {
            Ok(provenance) => Some(provenance),
            Err(error) => {
                terminal::warn(&format!(
                    "the picture does not say what it shows: {error}; --save-scene FILE.toml does"
                ));
                None
            }
        }
    }
}

impl Target {
    /// Writes the picture.
    pub(crate) fn write(&self, image: &Image, provenance: Option<&Provenance>) -> Result<()> {
        if let Some(path) = &self.path {
            return Ok(output::write_picture(path, self.format, image, provenance)?);
        }
        let bytes = self.format.bytes(image, provenance)?;
        let mut stdout = std::io::stdout().lock();
        let written = stdout.write_all(&bytes).and_then(|()| stdout.flush());
        written.context("cannot write to standard output")
    }

    /// What it is called.
    pub(crate) fn name(&self) -> String {
        self.path.as_ref().map_or("standard output".to_owned(), |path| path.display().to_string())
    }
}

/// A scene file is known by its name.
pub(crate) fn check_scene_name(path: &Path) -> Result<()> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("toml")) {
        bail!("a scene file is named .toml, and not {}", path.display());
    }
    Ok(())
}

/// That a file can be written there, as far as can be told.
pub(crate) fn check_folder(path: &Path, makes_folders: bool) -> Result<()> {
    if path.is_dir() {
        bail!("cannot write {}: it is a directory", path.display());
    }
    let Some(folder) = path.parent().filter(|folder| *folder != Path::new("")) else {
        return Ok(());
    };
    match std::fs::metadata(folder) {
        Ok(metadata) if metadata.is_dir() => Ok(()),
        Ok(_) => {
            bail!("cannot write {}: {} is not a directory", path.display(), folder.display())
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            if !makes_folders {
                bail!(
                    "cannot write {}: there is no folder {}; --mkdir makes it",
                    path.display(),
                    folder.display()
                );
            }
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make the folder {}", folder.display()))
        }
        Err(error) => Err(error)
            .with_context(|| format!("cannot write to the directory {}", folder.display())),
    }
}
