//! Work in a page: files that were dropped or fetched, pictures that are downloaded.

use super::{Job, Opener, Progress, Volumes, file_of, picture_format};
use crate::frames::Wake;
use crate::page::{Pictures, backend, bytes_of, download, read, token, turn_of_others};
use crate::received::Session;
use crate::state::{self, Bytes, Document};
use eframe::egui::DroppedFileHandle;
use slabsplat::film::{FilmDesc, FilmError, FilmFormat, FilmInMemory, FrameRate, Metadata, Turn};
use slabsplat::io::{
    FilesInMemory, LayerFile, LoadedVolume, PictureFormat, Provenance, SceneFile, VolumeOptions,
    VolumeSource, parse_scene, scene_text,
};
use slabsplat::{Image, OpenScene, TurnAxis};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc;
use wasm_bindgen_futures::spawn_local;

impl<T: 'static> Job<T> {
    /// Begins work that takes turns with the page.
    fn of_future<W: Future<Output = Result<T, String>> + 'static>(
        title: String,
        wake: &Wake,
        work: impl FnOnce(Progress) -> W,
    ) -> Self {
        let progress = Progress::default();
        let (sender, result) = mpsc::channel();
        let (wake, work) = (wake.clone(), work(progress.clone()));
        spawn_local(async move {
            drop(sender.send(work.await));
            wake();
        });
        Self { title, progress, result }
    }
}

/// What is opened by name in a page is under an address, so that this is asked for nothing.
pub(crate) fn opener() -> Opener {
    Arc::new(|path| Ok(SceneFile::of_volume(VolumeSource::File(path.to_owned()))))
}

/// Opens what is under an address: a scene file, or a volume.
#[expect(clippy::needless_pass_by_value, reason = "a desktop's thread takes it along")]
pub(crate) fn open(_: Opener, url: PathBuf, size: [u32; 2], wake: &Wake) -> Job<Document> {
    let url = url.to_string_lossy().into_owned();
    Job::of_future(format!("opening {url}"), wake, move |progress| async move {
        let bytes = bytes_of(&url).await?;
        document(&url, bytes, size, &progress).await
    })
}

/// Opens what was dropped onto the page, or chosen.
pub(crate) fn open_dropped(
    _: Opener,
    file: &DroppedFileHandle,
    size: [u32; 2],
    wake: &Wake,
) -> Job<Document> {
    let file = file.clone();
    let name = file.path().to_string_lossy().into_owned();
    Job::of_future(format!("opening {name}"), wake, move |progress| async move {
        let bytes = file.bytes_async().await?;
        document(&name, bytes, size, &progress).await
    })
}

/// Opens a channel of a file, which is called `name`: of bytes that are there, or from where the file is.
pub(crate) fn open_channel(
    file: SceneFile,
    bytes: Option<Bytes>,
    name: String,
    size: [u32; 2],
    wake: &Wake,
) -> Job<Document> {
    Job::of_future(format!("opening {name}"), wake, move |progress| async move {
        let layer = &file.layers[0];
        let volume = match (&bytes, &layer.volume) {
            (Some(bytes), VolumeSource::File(path)) => {
                read(&path.to_string_lossy(), bytes, &layer.options, &progress).await?
            }
            _ => fetched(layer, &progress).await?,
        };
        let mut document = Document::of(with_volumes(vec![volume], &file, size)?, name);
        document.set_bytes(bytes);
        Ok(document)
    })
}

/// Opens bytes that are there.
pub(crate) fn open_bytes(
    name: String,
    bytes: Vec<u8>,
    size: [u32; 2],
    wake: &Wake,
) -> Job<Document> {
    let title = format!("opening {name}");
    Job::of_future(title, wake, move |progress| async move {
        document(&name, bytes, size, &progress).await
    })
}

/// Opens a built-in volume.
pub(crate) fn open_builtin(name: String, size: [u32; 2], wake: &Wake) -> Job<Document> {
    Job::of_future(format!("opening {name}"), wake, move |_| async move {
        let source = VolumeSource::Builtin { name: name.clone(), size: None };
        let mut file = SceneFile::of_volume(source);
        backend().into_iter().for_each(|backend| file.backend = backend);
        Document::open(&file, name, size).map_err(|error| error.to_string())
    })
}

/// Opens what a server shows: its scene, with overviews of its volumes.
pub(crate) fn open_session(token: String, size: [u32; 2], wake: &Wake) -> Job<Document> {
    Job::of_future("asking the server".to_owned(), wake, move |_| async move {
        let session = bytes_of(&format!("session?token={token}")).await?;
        let session = Session::of_json(&session)?;
        let mut file =
            parse_scene(&session.scene, "scene.toml").map_err(|error| error.to_string())?;
        let said = file.clone();
        file.meshes.clear();
        let mut volumes = Vec::new();
        for (layer_idx, layer) in file.layers.iter_mut().enumerate() {
            (layer.hash, layer.labels) = (None, None);
            let bytes = bytes_of(&format!("overview/{layer_idx}?token={token}")).await?;
            volumes.push(read_overview(&bytes)?);
        }
        for (volume, acquisition) in volumes.iter_mut().zip(session.acquisitions()?) {
            volume.acquisition = acquisition;
        }
        let mut opened = with_volumes(volumes, &file, size)?;
        session.tell(&mut opened, said).map_err(|error| error.to_string())?;
        let mut document = Document::of(opened, session.name.clone());
        document.set_facts(session.facts());
        Ok(document)
    })
}

async fn document(
    name: &str,
    bytes: Vec<u8>,
    size: [u32; 2],
    progress: &Progress,
) -> Result<Document, String> {
    if !Path::new(name).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
    {
        let file = SceneFile::of_volume(VolumeSource::File(name.into()));
        let volume = read(name, &bytes, &VolumeOptions::default(), progress).await?;
        // Of other files there is nothing more to be read.
        let has_channels = 1 < volume.choices.channel.n;
        let mut document = Document::of(with_volumes(vec![volume], &file, size)?, name.to_owned());
        document.set_bytes(has_channels.then(|| Bytes::from(bytes)));
        return Ok(document);
    }
    let text = String::from_utf8(bytes).map_err(|_| format!("{name} is no text"))?;
    let file = parse_scene(&text, name).map_err(|error| error.to_string())?;
    let mut volumes = Vec::new();
    for layer in &file.layers {
        volumes.push(fetched(layer, progress).await?);
    }
    Ok(Document::of(with_volumes(volumes, &file, size)?, name.to_owned()))
}

/// A layer's volume, from where the scene says that it is.
async fn fetched(layer: &LayerFile, progress: &Progress) -> Result<LoadedVolume, String> {
    let VolumeSource::File(path) = &layer.volume else {
        return layer.load_volume().map_err(|error| error.to_string());
    };
    let url = path.to_string_lossy();
    let bytes = bytes_of(&url).await?;
    read(&url, &bytes, &layer.options, progress).await
}

/// A server's overview, which is small.
fn read_overview(bytes: &[u8]) -> Result<LoadedVolume, String> {
    let name = "overview.nrrd";
    let files = FilesInMemory::from_iter([(name, bytes)]);
    files.read_volume_with(name, &VolumeOptions::default()).map_err(|error| error.to_string())
}

fn with_volumes(
    volumes: Vec<LoadedVolume>,
    file: &SceneFile,
    [width, height]: [u32; 2],
) -> Result<OpenScene, String> {
    let mut file = file.clone();
    (file.image.width, file.image.height) = (width, height);
    // What is saved is drawn by what the page is drawn by.
    backend().into_iter().for_each(|backend| file.backend = backend);
    OpenScene::with_volumes(volumes, &file).map_err(|error| error.to_string())
}

/// Downloads the picture of a scene, of any size, with what it was made of. Returns a sentence.
pub(crate) fn save_picture(mut opened: OpenScene, path: PathBuf, wake: &Wake) -> Job<String> {
    let title = format!("drawing {}", path.display());
    Job::of_future(title, wake, move |_| async move {
        let format = picture_format(&path)?;
        let mut pictures = Pictures::open()?;
        let image = pictures.picture_of(opened.clone()).await?.image;
        let volumes = if token().is_some() { Volumes::Elsewhere } else { Volumes::Here };
        opened.backend = pictures.backend().unwrap_or(opened.backend);
        download_picture(format, &path, &image, &file_of(&opened, volumes)?)
    })
}

fn download_picture(
    format: PictureFormat,
    path: &Path,
    image: &Image,
    file: &SceneFile,
) -> Result<String, String> {
    let provenance = Provenance::of_scene(file, path).map_err(|error| error.to_string())?;
    let bytes = format.bytes(image, Some(&provenance)).map_err(|error| error.to_string())?;
    let name = path.display().to_string();
    download(&name, &bytes)?;
    Ok(format!("{name} is among your downloads"))
}

/// Downloads a scene file. Returns a sentence.
pub(crate) fn save_scene(
    opened: OpenScene,
    volumes: Volumes,
    path: PathBuf,
    wake: &Wake,
) -> Job<String> {
    let name = path.display().to_string();
    Job::of_future(format!("writing {name}"), wake, move |_| async move {
        let text = scene_text(&file_of(&opened, volumes)?, &path);
        download(&name, text.map_err(|error| error.to_string())?.as_bytes())?;
        Ok(format!("{name} is among your downloads"))
    })
}

/// Fits a preset to a layer, for a small picture of it.
pub(crate) fn thumbnail(opened: OpenScene, preset_idx: usize, wake: &Wake) -> Job<OpenScene> {
    Job::of_future(String::new(), wake, move |_| async move {
        turn_of_others().await;
        state::thumbnail(opened, preset_idx)
    })
}

/// Frames a second of a turntable.
const FRAMES_PER_SECOND: f64 = 30.0;

/// Downloads a film of a whole turn. Returns a sentence.
pub(crate) fn film(opened: OpenScene, path: PathBuf, seconds: f64, wake: &Wake) -> Job<String> {
    let name = path.display().to_string();
    Job::of_future(format!("filming {name}"), wake, move |progress| async move {
        let bytes = filmed(&opened, &path, seconds, &progress).await?;
        download(&name, &bytes)?;
        Ok(format!("{name} is among your downloads"))
    })
}

async fn filmed(
    opened: &OpenScene,
    path: &Path,
    seconds: f64,
    progress: &Progress,
) -> Result<Vec<u8>, String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let others = "a page makes films as .webp, .gif or .apng: for others save the scene, and slabsplat \
                  turntable films it";
    let format = FilmFormat::of_name(path).ok_or(others)?;
    let rate = FrameRate::new(FRAMES_PER_SECOND).map_err(|e| text(&e))?;
    let n_frames = FilmDesc::n_frames_of(seconds, rate).map_err(|e| text(&e))?;
    let image = opened.scene.image;
    let desc = FilmDesc::new(image.width, image.height, n_frames, rate).map_err(|e| text(&e))?;
    let desc = desc.has_opacity(format.has_opacity() && image.background[3] < 1.0);
    let film = FilmInMemory::begin(path, format, desc, &Metadata::default());
    let mut film = film.map_err(|error| match error {
        FilmError::NotInMemory { .. } => others.to_owned(),
        other => text(&other),
    })?;
    let turn = Turn::new(TurnAxis::Up, 360.0, n_frames);
    let mut pictures = Pictures::open()?;
    let mut opened = opened.clone();
    let first = opened.scene.clone();
    for frame_idx in 0..n_frames {
        if progress.is_cancelled() {
            return Err("the film was given up".to_owned());
        }
        progress.reach(f64::from(frame_idx) / f64::from(n_frames));
        opened.scene = turn.scene_at(&first, frame_idx).map_err(|e| text(&e))?;
        film.add(&pictures.picture_of(opened.clone()).await?.image).map_err(|e| text(&e))?;
    }
    film.finish().map_err(|e| text(&e))
}
