//! Flags of what a film is written as, and how long it is.

use super::output::{check_folder, check_scene_name, is_same_file};
use super::{Check, SceneFlags, values};
use crate::painter::Painter;
use crate::progress::Progress;
use crate::ranks::RankFlags;
use crate::{divided, terminal};
use anyhow::{Result, anyhow, bail};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use slabsplat::film::{FilmDesc, FilmError, FilmFormat, FilmWriter, FrameRate, Metadata};
use slabsplat::io::{Provenance, SceneFile};
use slabsplat::{Camera, Scene};
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(next_help_heading = "Film")]
pub(crate) struct FilmFlags {
    /// The film: .mp4 and .webm (by the program ffmpeg), .gif, .webp, .apng, or .png-sequence, which is a
    /// folder with a PNG for each frame
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Format of the film [default: by the name's extension]
    #[arg(long, value_parser = format_parser())]
    format: Option<FilmFormat>,

    /// Frames a second, 0.1 to 240 [default: 25, or as the scene file says]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    fps: Option<f64>,

    /// How long the film is, in seconds [default: 6]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    seconds: Option<f64>,

    /// How many frames it has, instead of how long it is
    #[arg(long, value_name = "N", conflicts_with = "seconds")]
    frames: Option<u32>,

    /// Begin anew, whatever frames of an interrupted run are there
    #[arg(long)]
    restart: bool,

    /// Write what is filmed as a scene file, too, of which `film` makes the film again
    #[arg(long, value_name = "FILE.toml")]
    save_scene: Option<PathBuf>,

    /// Leave the scene out of the film's metadata. A .webp, an .apng and each frame of a .png-sequence say
    /// what they show; .mp4, .webm and .gif do not
    #[arg(long)]
    no_metadata: bool,

    /// Make folders that are to be written to and are not there
    #[arg(long)]
    mkdir: bool,

    /// Draw frames within so much memory, however large the volumes are, box by box on the CPU: as 800MiB or
    /// 2GiB. Frames that are being written are beside it
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    memory: Option<u64>,

    /// Where --memory unpacks volumes that cannot be read box by box; by default in the system's folder for
    /// temporary files
    #[arg(long, value_name = "FOLDER", requires = "memory")]
    scratch: Option<PathBuf>,

    /// Answer in JSON: what was written, frames, time, warnings
    #[arg(long)]
    pub(crate) json: bool,

    #[command(flatten)]
    pub(crate) ranks: RankFlags,
}

fn format_parser() -> impl TypedValueParser<Value = FilmFormat> {
    let names = FilmFormat::ALL.iter().map(|format| format.name());
    PossibleValuesParser::new(names.collect::<Vec<_>>()).map(|name| {
        let is_its = |format: &&FilmFormat| format.name() == name;
        *FilmFormat::ALL.iter().find(is_its).expect("clap knows the choices")
    })
}

/// Frames a second where nobody says it: every format shows them evenly, GIF for 4/100 s each.
const USUAL_FPS: f64 = 25.0;

impl FilmFlags {
    /// Where the film goes, and as what. What would fail after the work fails here.
    pub(crate) fn target(&self, input: &Path) -> Result<(&Path, FilmFormat)> {
        let path = &self.output;
        if let Some(path) = [Some(path), self.save_scene.as_ref()]
            .into_iter()
            .flatten()
            .find(|path| is_same_file(path, input))
        {
            bail!("{} is to be filmed, and would be replaced: choose another name", path.display());
        }
        if path == Path::new("-") {
            bail!("a film cannot go to standard output: name a file");
        }
        let Some(format) = self.format.or_else(|| FilmFormat::of_name(path)) else {
            let names = FilmFormat::ALL.iter().map(|format| format!(".{}", format.name()));
            let names = names.collect::<Vec<_>>().join(", ");
            bail!("cannot tell the format of {}: name the film one of {names}", path.display());
        };
        format.check_program()?;
        if format != FilmFormat::PngSequence || !path.is_dir() {
            check_folder(path, self.mkdir)?;
        }
        if let Some(scene) = &self.save_scene {
            check_scene_name(scene)?;
            check_folder(scene, self.mkdir)?;
        }
        Ok((path, format))
    }

    /// Opens what is named for its frames; a camera that is found holds what is seen by `views`, too.
    pub(crate) fn painter(
        &self,
        scene: &SceneFlags,
        (progress, check): (&Progress, Check<'_>),
        views: &dyn Fn(&SceneFile, &Camera) -> Vec<Camera>,
    ) -> Result<Painter> {
        let Some(memory_bytes) = self.memory else {
            let (renderer, opened) = scene.opened_around(progress, check, views)?;
            return Ok(Painter::InCore(Box::new((renderer, opened))));
        };
        let desc = divided::desc(memory_bytes, self.scratch.as_deref());
        Ok(Painter::InParts(Box::new(scene.divided_around(check, &desc, views)?)))
    }

    /// How fast frames follow each other, if need be as a scene file says.
    pub(crate) fn rate(&self, of_file: Option<f64>) -> Result<FrameRate> {
        Ok(FrameRate::new(self.fps.or(of_file).unwrap_or(USUAL_FPS))?)
    }

    /// How many frames there are, of `usual_seconds` if no flag says it.
    pub(crate) fn n_frames(&self, rate: FrameRate, usual_seconds: f64) -> Result<u32> {
        Ok(match self.frames {
            Some(n_frames) => FilmDesc::new(1, 1, n_frames, rate)?.n_frames,
            None => FilmDesc::n_frames_of(self.seconds.unwrap_or(usual_seconds), rate)?,
        })
    }

    /// How long the flags say that the film is, if they do.
    pub(crate) fn seconds(&self, rate: FrameRate) -> Option<f64> {
        self.seconds.or_else(|| Some(f64::from(self.frames?) / rate.per_second()))
    }

    /// That the format has room for frames of a scene, which are that fast.
    pub(crate) fn check(
        &self,
        format: FilmFormat,
        file: &SceneFile,
        rate: FrameRate,
    ) -> Result<()> {
        Ok(format.check(&FilmDesc::new(file.image.width, file.image.height, 1, rate)?)?)
    }

    /// What its frames are, of which the caller is told if they are not as they might be.
    pub(crate) fn desc(
        &self,
        format: FilmFormat,
        scene: &Scene,
        (n_frames, rate): (u32, FrameRate),
    ) -> Result<FilmDesc> {
        let Scene { image, finish, .. } = scene;
        let below = finish.background_below.unwrap_or(image.background);
        let lets_through = image.background[3].min(below[3]) < 1.0;
        let desc = FilmDesc::new(image.width, image.height, n_frames, rate)?
            .has_opacity(lets_through && format.has_opacity())
            .n_threads(rayon::current_num_threads());
        let name = format.name();
        if lets_through && !format.has_opacity() {
            terminal::warn(&format!(
                "{name} has no opacity, so that frames are shown before black; --background R,G,B says another \
                 colour, and webp and apng keep opacity"
            ));
        }
        let [width, height] = format.size(&desc);
        if [width, height] != [desc.width, desc.height] {
            terminal::warn(&format!("{name} has even sides, and so {width} x {height} pixels"));
        }
        Ok(desc)
    }

    /// The scene file that is to be written beside the film.
    pub(crate) fn scene_path(&self) -> Option<&Path> {
        self.save_scene.as_deref()
    }

    /// Whether films and frames say what they show, where they can.
    pub(crate) fn says_scene(&self) -> bool {
        !self.no_metadata
    }

    /// What a film, or one of its frames, is to say of itself under that name.
    pub(crate) fn metadata(&self, scene: &SceneFile, path: &Path) -> Metadata {
        if !self.says_scene() {
            return Metadata::default();
        }
        match Provenance::of_scene(scene, path) {
            Ok(provenance) => Metadata::new(provenance.png_texts(), Some(provenance.xmp())),
            Err(error) => {
                terminal::warn(&format!(
                    "the film does not say what it shows: {error}; --save-scene FILE.toml does"
                ));
                Metadata::default()
            }
        }
    }

    /// Begins the film or continues it.
    pub(crate) fn begin(
        &self,
        path: &Path,
        format: FilmFormat,
        desc: FilmDesc,
        identity: &str,
    ) -> Result<FilmWriter> {
        let begin = if self.restart { FilmWriter::begin_anew } else { FilmWriter::begin };
        begin(path.to_owned(), format, desc, identity).map_err(|error| match error {
            FilmError::OtherFilm { folder, what } => anyhow!(
                "{} has frames of another film, which differs in {what}: remove that folder, or --restart begins \
                 anew",
                folder.display()
            ),
            error => error.into(),
        })
    }
}
