//! Work in a page: files that were dropped or fetched, pictures that are downloaded.

use super::{Job, Opener, Progress};
use crate::frames::Wake;
use crate::page::{bytes_of, download};
use crate::received::Session;
use crate::state::Document;
use eframe::egui::DroppedFileHandle;
use slabsplat::io::{
    FilesInMemory, LayerFile, LoadedVolume, PictureFormat, Provenance, SceneFile, VolumeOptions,
    VolumeSource, parse_scene, scene_text,
};
use slabsplat::{Mesh, MeshLayer, OpenScene, Renderer, finished, frame_scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc;
use wasm_bindgen_futures::spawn_local;

impl<T: 'static> Job<T> {
    /// Begins work that takes turns with the page.
    fn of_future(
        title: String,
        wake: &Wake,
        work: impl Future<Output = Result<T, String>> + 'static,
    ) -> Self {
        let (sender, result) = mpsc::channel();
        let wake = wake.clone();
        spawn_local(async move {
            drop(sender.send(work.await));
            wake();
        });
        Self { title, progress: Progress::default(), result }
    }
}

/// What is opened by name in a page is under an address, so that this is asked for nothing.
pub(crate) fn opener() -> Opener {
    Arc::new(|path| Ok(SceneFile::of_volume(VolumeSource::File(path.to_owned()))))
}

/// Opens what is under an address: a scene file, or a volume.
pub(crate) fn open(_: Opener, url: PathBuf, size: [u32; 2], wake: &Wake) -> Job<Document> {
    let url = url.to_string_lossy().into_owned();
    Job::of_future(format!("opening {url}"), wake, async move {
        let bytes = bytes_of(&url).await?;
        document(&url, bytes, size).await
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
    Job::of_future(format!("opening {name}"), wake, async move {
        let bytes = file.bytes_async().await?;
        document(&name, bytes, size).await
    })
}

/// Opens bytes that are there.
pub(crate) fn open_bytes(
    name: String,
    bytes: Vec<u8>,
    size: [u32; 2],
    wake: &Wake,
) -> Job<Document> {
    Job::of_future(
        format!("opening {name}"),
        wake,
        async move { document(&name, bytes, size).await },
    )
}

/// Opens a built-in volume.
pub(crate) fn open_builtin(name: String, size: [u32; 2], wake: &Wake) -> Job<Document> {
    Job::of_future(format!("opening {name}"), wake, async move {
        let source = VolumeSource::Builtin { name: name.clone(), size: None };
        Document::open(&SceneFile::of_volume(source), name, size).map_err(|error| error.to_string())
    })
}

/// Opens what a server shows: its scene, with overviews of its volumes.
pub(crate) fn open_session(token: String, size: [u32; 2], wake: &Wake) -> Job<Document> {
    Job::of_future("asking the server".to_owned(), wake, async move {
        let session = bytes_of(&format!("session?token={token}")).await?;
        let session = Session::of_json(&session)?;
        let mut file =
            parse_scene(&session.scene, "scene.toml").map_err(|error| error.to_string())?;
        let n_meshes = file.meshes.len();
        let meshes = std::mem::take(&mut file.meshes);
        let mut volumes = Vec::new();
        for (layer_idx, layer) in file.layers.iter_mut().enumerate() {
            (layer.hash, layer.labels) = (None, None);
            let bytes = bytes_of(&format!("overview/{layer_idx}?token={token}")).await?;
            volumes.push(read("overview.nrrd", &bytes, &VolumeOptions::default())?);
        }
        let mut opened = with_volumes(volumes, &file, size)?;
        // Surfaces are the server's: here they only count.
        opened.scene.meshes = vec![MeshLayer::new(Mesh::default()); n_meshes];
        opened.sources.meshes = meshes;
        session.tell(&mut opened);
        let mut document = Document::of(opened, session.name.clone());
        document.set_facts(session.facts());
        Ok(document)
    })
}

async fn document(name: &str, bytes: Vec<u8>, size: [u32; 2]) -> Result<Document, String> {
    if !Path::new(name).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
    {
        let file = SceneFile::of_volume(VolumeSource::File(name.into()));
        let volume = read(name, &bytes, &VolumeOptions::default())?;
        return Ok(Document::of(with_volumes(vec![volume], &file, size)?, name.to_owned()));
    }
    let text = String::from_utf8(bytes).map_err(|_| format!("{name} is no text"))?;
    let file = parse_scene(&text, name).map_err(|error| error.to_string())?;
    let mut volumes = Vec::new();
    for layer in &file.layers {
        volumes.push(fetched(layer).await?);
    }
    Ok(Document::of(with_volumes(volumes, &file, size)?, name.to_owned()))
}

/// A layer's volume, from where the scene says that it is.
async fn fetched(layer: &LayerFile) -> Result<LoadedVolume, String> {
    let VolumeSource::File(path) = &layer.volume else {
        return layer.load_volume().map_err(|error| error.to_string());
    };
    let url = path.to_string_lossy();
    let bytes = bytes_of(&url).await?;
    read(&url, &bytes, &layer.options)
}

fn read(name: &str, bytes: &[u8], options: &VolumeOptions) -> Result<LoadedVolume, String> {
    let files = FilesInMemory::from_iter([(name, bytes)]);
    files.read_volume_with(name, options).map_err(|error| error.to_string())
}

fn with_volumes(
    volumes: Vec<LoadedVolume>,
    file: &SceneFile,
    [width, height]: [u32; 2],
) -> Result<OpenScene, String> {
    let mut file = file.clone();
    (file.image.width, file.image.height) = (width, height);
    OpenScene::with_volumes(volumes, &file).map_err(|error| error.to_string())
}

/// Downloads the picture of a scene, of any size, with what it was made of. Returns a sentence.
pub(crate) fn save_picture(mut opened: OpenScene, path: PathBuf, wake: &Wake) -> Job<String> {
    let name = path.display().to_string();
    Job::of_future(format!("drawing {name}"), wake, async move {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let endings = PictureFormat::endings;
        let format = PictureFormat::of_name(&path)
            .ok_or_else(|| format!("the name of a picture ends in {}", endings()))?;
        let mut renderer =
            Renderer::open_async(&opened.backend, |_| {}).await.map_err(|e| text(&e))?;
        let scene = frame_scene(&opened.scene).map_err(|e| text(&e))?.into_owned();
        let frame = renderer.render_async(&scene).await.map_err(|e| text(&e))?;
        let picture = finished(frame, &opened.scene, opened.acquisition);
        renderer.caps().name.clone_into(&mut opened.backend);
        let file = opened.to_file().map_err(|e| text(&e))?;
        let provenance = Provenance::of_scene(&file, &path).map_err(|e| text(&e))?;
        let bytes = format.bytes(&picture.frame.image, Some(&provenance)).map_err(|e| text(&e))?;
        download(&name, &bytes)?;
        Ok(format!("{name} is among your downloads"))
    })
}

/// Downloads a scene file. Returns a sentence.
pub(crate) fn save_scene(opened: OpenScene, path: PathBuf, wake: &Wake) -> Job<String> {
    let name = path.display().to_string();
    Job::of_future(format!("writing {name}"), wake, async move {
        let file = opened.to_file().map_err(|error| error.to_string())?;
        let text = scene_text(&file, &path).map_err(|error| error.to_string())?;
        download(&name, text.as_bytes())?;
        Ok(format!("{name} is among your downloads"))
    })
}

/// Films are made by programs on a desktop.
pub(crate) fn film(_: OpenScene, _: PathBuf, _: f64, wake: &Wake) -> Job<String> {
    Job::of_future("filming".to_owned(), wake, async {
        Err("a browser makes no films: save the scene, and slabsplat turntable films it".to_owned())
    })
}
