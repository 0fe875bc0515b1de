//! Flags of what `render` writes, and where.

use crate::{output, terminal};
use anyhow::{Context, Result, bail};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use slabsplat::Image;
use slabsplat::film::FilmFormat;
use slabsplat::io::{self, PictureFormat, Provenance, SceneFile};
use std::io::{IsTerminal, Write as _};
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputFlags {
    /// The picture: .png or .webp (8 bits), .jpg (8 bits, opaque), .tif (16 bits; with --format tiff-float
    /// 32-bit float, premultiplied) or .exr (32-bit float, premultiplied); - is standard output
    /// [default: INPUT's name with .png, in the working directory]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Write what was drawn as a scene file, too, with all that was found or is by default
    #[arg(long, value_name = "FILE.toml")]
    save_scene: Option<PathBuf>,

    #[command(flatten)]
    picture: PictureFlags,
}

/// Flags of pictures, wherever they go.
#[derive(Args)]
pub(crate) struct PictureFlags {
    /// Format of the picture [default: by the name's extension; else png]
    #[arg(long, value_parser = format_parser())]
    pub(crate) format: Option<PictureFormat>,

    /// Leave the scene out of the picture's metadata, by which it can be rendered again
    #[arg(long)]
    no_metadata: bool,

    /// Make folders that are to be written to and are not there
    #[arg(long)]
    pub(crate) mkdir: bool,
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
    /// What is to be written of `input`, in a run that may answer on standard output, too. What would fail
    /// after the work fails here.
    pub(crate) fn written(&self, input: &Path, answers: bool) -> Result<Written<'_>> {
        let named = [&self.output, &self.save_scene];
        if let Some(path) = named.into_iter().flatten().find(|path| is_same_file(path, input)) {
            bail!("{} is to be drawn, and would be replaced: choose another name", path.display());
        }
        if let Some(scene) = &self.save_scene {
            check_scene_name(scene)?;
            check_folder(scene, self.picture.mkdir)?;
        }
        let target = match &self.output {
            Some(path) if path == Path::new("-") => self.picture.on_stdout(answers)?,
            Some(path) => self.picture.target(path.clone())?,
            None => self.picture.target(self.unsaid_name(input)?)?,
        };
        Ok(Written { target, scene: self.save_scene.as_deref(), picture: &self.picture })
    }

    /// The picture's name if nobody says it: then it replaces nothing but a picture that slabsplat made.
    fn unsaid_name(&self, input: &Path) -> Result<PathBuf> {
        let Some(path) = self.picture.name_for(input) else {
            bail!("{} gives the picture no name: name it by -o", input.display());
        };
        let is_ours = || io::read_picture_scene(&path).is_ok_and(|scene| scene.is_some());
        if path == input || path.exists() && !is_ours() {
            bail!("{} is there already: name the picture by -o", path.display());
        }
        Ok(path)
    }
}

impl PictureFlags {
    /// The picture of that name.
    pub(crate) fn target(&self, path: PathBuf) -> Result<Target> {
        let Some(format) = self.format.or_else(|| PictureFormat::of_name(&path)) else {
            check_no_film(&path)?;
            return Err(io::IoError::UnknownPicture { path }.into());
        };
        check_folder(&path, self.mkdir)?;
        Ok(Target { path: Some(path), format })
    }

    fn on_stdout(&self, answers: bool) -> Result<Target> {
        if answers {
            bail!("the picture and the answer in JSON cannot both go to standard output");
        }
        if std::io::stdout().is_terminal() {
            bail!("standard output is a terminal: send the picture to a file or a program");
        }
        Ok(Target { path: None, format: self.format_or_usual() })
    }

    fn format_or_usual(&self) -> PictureFormat {
        self.format.unwrap_or(PictureFormat::Png)
    }

    /// What a picture of `input` is called, without a folder, if that says it.
    pub(crate) fn name_for(&self, input: &Path) -> Option<PathBuf> {
        let name = match input.to_str().and_then(|input| input.strip_prefix("builtin:")) {
            Some(builtin) => builtin.split(':').next().unwrap_or_default().into(),
            None => input.file_name().unwrap_or_default().to_string_lossy(),
        };
        let plain = name.strip_suffix(".gz").unwrap_or(&name);
        let stem = Path::new(plain).file_stem().unwrap_or_default();
        if stem.is_empty() || stem == "-" {
            return None;
        }
        let mut name = stem.to_owned();
        name.push(".");
        name.push(self.format_or_usual().extensions()[0]);
        Some(name.into())
    }

    /// What the picture is to say of itself.
    fn provenance(&self, scene: Option<&SceneFile>, path: &Path) -> Option<Provenance> {
        let scene = scene.filter(|_| !self.no_metadata)?;
        match Provenance::of_scene(scene, path) {
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

/// What is written of a frame, and where.
pub(crate) struct Written<'a> {
    pub(crate) target: Target,
    /// The scene file, if there is to be one.
    pub(crate) scene: Option<&'a Path>,
    pub(crate) picture: &'a PictureFlags,
}

impl Written<'_> {
    /// Whether the scene is written anywhere.
    pub(crate) fn has_scene(&self) -> bool {
        self.scene.is_some() || !self.picture.no_metadata
    }

    /// Writes all of it.
    pub(crate) fn write(&self, image: &Image, scene: Option<&SceneFile>) -> Result<()> {
        let path = self.target.path.as_deref().unwrap_or(Path::new("-"));
        let provenance = self.picture.provenance(scene, path);
        self.target.write(image, provenance.as_ref())?;
        match (self.scene, scene) {
            (Some(path), Some(scene)) => Ok(output::write_scene(path, scene)?),
            _ => Ok(()),
        }
    }
}

impl Target {
    /// Writes the picture.
    fn write(&self, image: &Image, provenance: Option<&Provenance>) -> Result<()> {
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

/// That a name is not a film's.
fn check_no_film(path: &Path) -> Result<()> {
    if FilmFormat::of_name(path).is_none() {
        return Ok(());
    }
    let path = path.display();
    bail!(
        "{path} is the name of a film, which `turntable` and `film` make: for a picture, name it {}",
        PictureFormat::endings()
    )
}

/// Whether two names are of one file, which is there.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
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
        bail!("cannot write {}: it is a folder", path.display());
    }
    let Some(folder) = path.parent().filter(|folder| *folder != Path::new("")) else {
        return Ok(());
    };
    match std::fs::metadata(folder) {
        Ok(metadata) if metadata.is_dir() => Ok(()),
        Ok(_) => {
            bail!("cannot write {}: {} is no folder", path.display(), folder.display())
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
        Err(error) => {
            Err(error).with_context(|| format!("cannot write to the folder {}", folder.display()))
        }
    }
}
