//! Work that takes its time: files that are opened, pictures and films that are written. Each is on a thread
//! of its own, says how far it is, and can be given up.

use crate::frames::Wake;
use crate::state::Document;
use slabsplat::film::{FilmDesc, FilmFormat, FilmWriter, FrameRate, Turn};
use slabsplat::io::{PictureFormat, ProgressCallback, Provenance, SceneFile, write_scene};
use slabsplat::{FrameHandle, OpenScene, Renderer, TurnAxis};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};

/// What a scene file makes of a name: a volume, a scene, a picture that says what it shows.
pub type Opener = Arc<dyn Fn(&Path) -> Result<SceneFile, String> + Send + Sync>;

/// Work that goes on.
#[derive(Debug)]
pub(crate) struct Job<T> {
    /// What it is, for people.
    pub(crate) title: String,
    progress: Progress,
    result: Receiver<Result<T, String>>,
}

/// How far work is, for those who do it and those who watch. It is given up when nobody watches.
#[derive(Clone, Debug, Default)]
pub(crate) struct Progress {
    thousandths: Arc<AtomicU32>,
    is_cancelled: Arc<AtomicU32>,
    frame: Arc<Mutex<Option<FrameHandle>>>,
}

impl Progress {
    fn reach(&self, share: f64) {
        self.thousandths.store((1000.0 * share) as u32, Ordering::Relaxed);
    }

    /// A frame that is part of it: it is cancelled with the rest.
    fn frame(&self) -> FrameHandle {
        let frame = FrameHandle::new();
        *self.frame.lock().unwrap_or_else(PoisonError::into_inner) = Some(frame.clone());
        if self.is_cancelled() {
            frame.cancel();
        }
        frame
    }

    fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed) != 0
    }

    fn cancel(&self) {
        self.is_cancelled.store(1, Ordering::Relaxed);
        if let Some(frame) = &*self.frame.lock().unwrap_or_else(PoisonError::into_inner) {
            frame.cancel();
        }
    }
}

impl<T: Send + 'static> Job<T> {
    /// Begins work. `wake` is called when it is done, and may be whenever it has got further.
    pub(crate) fn begin(
        title: String,
        wake: &Wake,
        work: impl FnOnce(&Progress) -> Result<T, String> + Send + 'static,
    ) -> Self {
        let progress = Progress::default();
        let (sender, result) = mpsc::channel();
        let (of_work, wake) = (progress.clone(), wake.clone());
        let thread = std::thread::Builder::new().name("slabsplat-job".to_owned());
        let failed = sender.clone();
        let spawned = thread.spawn(move || {
            drop(sender.send(work(&of_work)));
            wake();
        });
        if let Err(error) = spawned {
            drop(failed.send(Err(error.to_string())));
        }
        Self { title, progress, result }
    }

    /// What came of it, once it is done.
    pub(crate) fn done(&self) -> Option<Result<T, String>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err("it stopped in the middle".to_owned())),
        }
    }

    /// How far it is, 0 … 1.
    pub(crate) fn share(&self) -> f32 {
        let frame = self.progress.frame.lock().unwrap_or_else(PoisonError::into_inner);
        let of_frame = frame.as_ref().map_or(0.0, FrameHandle::progress);
        let share = self.progress.thousandths.load(Ordering::Relaxed) as f32 / 1000.0;
        if share == 0.0 { of_frame } else { share }
    }
}

impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

/// Opens what `opener` makes of a name, for views of that size.
pub(crate) fn open(opener: Opener, path: PathBuf, size: [u32; 2], wake: &Wake) -> Job<Document> {
    let title = format!("opening {}", path.display());
    let wake_of_work = wake.clone();
    Job::begin(title, wake, move |progress| {
        let file = opener(&path)?;
        open_file(file, name_of(&path), size, progress, wake_of_work)
    })
}

/// What opens something for views of a size, in pixels, on a thread of its own.
pub type Opening = Box<dyn FnOnce([u32; 2]) -> Result<OpenScene, String> + Send>;

/// Opens what `opening` opens.
pub(crate) fn begin(name: String, opening: Opening, size: [u32; 2], wake: &Wake) -> Job<Document> {
    let title = format!("opening {name}");
    Job::begin(title, wake, move |_| Ok(Document::of(opening(size)?, name)))
}

fn open_file(
    mut file: SceneFile,
    name: String,
    size: [u32; 2],
    progress: &Progress,
    wake: Wake,
) -> Result<Document, String> {
    let reading = progress.clone();
    let heard = ProgressCallback::new(move |read| {
        reading.reach(0.9 * read.share());
        wake();
    });
    file.layers.iter_mut().for_each(|layer| layer.options.progress = Some(heard.clone()));
    Document::open(&file, name, size).map_err(|error| error.to_string())
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |it| it.to_string_lossy().into())
}

/// Writes the picture of a scene, of any size, with what it was made of. Returns a sentence.
pub(crate) fn save_picture(opened: OpenScene, path: PathBuf, wake: &Wake) -> Job<String> {
    Job::begin(format!("drawing {}", path.display()), wake, move |progress| {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let endings = PictureFormat::endings;
        let format = PictureFormat::of_name(&path)
            .ok_or_else(|| format!("the name of a picture ends in {}", endings()))?;
        let mut opened = opened;
        let mut renderer = Renderer::open(&opened.backend, |_| {}).map_err(|e| text(&e))?;
        let (scene, acquisition) = (&opened.scene, opened.acquisition);
        let picture = renderer
            .picture_as(scene, acquisition, &progress.frame())
            .map_err(|e| text(&e))?;
        renderer.caps().name.clone_into(&mut opened.backend);
        let file = opened.to_file().map_err(|e| text(&e))?;
        let provenance = Provenance::of_scene(&file, &path).map_err(|e| text(&e))?;
        let image = &picture.frame.image;
        format.write(&path, image, Some(&provenance)).map_err(|e| text(&e))?;
        Ok(format!("{}: {} x {} pixels", path.display(), image.width(), image.height()))
    })
}

/// Writes a scene file. Returns a sentence.
pub(crate) fn save_scene(opened: OpenScene, path: PathBuf, wake: &Wake) -> Job<String> {
    Job::begin(format!("writing {}", path.display()), wake, move |_| {
        let file = opened.to_file().map_err(|error| error.to_string())?;
        write_scene(&path, &file).map_err(|error| error.to_string())?;
        Ok(format!("{}: the scene", path.display()))
    })
}

/// Frames a second of a turntable.
const FRAMES_PER_SECOND: f64 = 30.0;

/// Films a whole turn. Returns a sentence.
pub(crate) fn film(opened: OpenScene, path: PathBuf, seconds: f64, wake: &Wake) -> Job<String> {
    let shown = path.display().to_string();
    Job::begin(format!("filming {shown}"), wake, move |progress| {
        make_film(&opened, &path, seconds, progress).map_err(|error| match error {
            FilmingError::Cancelled => format!("the film was given up; its frames are in {shown}.frames"),
            FilmingError::Other(why) => why,
        })
    })
}

enum FilmingError {
    Cancelled,
    Other(String),
}

impl<E: std::error::Error> From<E> for FilmingError {
    fn from(error: E) -> Self {
        Self::Other(error.to_string())
    }
}

fn make_film(
    opened: &OpenScene,
    path: &Path,
    seconds: f64,
    progress: &Progress,
) -> Result<String, FilmingError> {
    let format = FilmFormat::of_name(path).ok_or_else(|| {
        FilmingError::Other("the name of a film ends in .mp4, .webm, .gif, .webp or .apng".to_owned())
    })?;
    format.check_program()?;
    let rate = FrameRate::new(FRAMES_PER_SECOND)?;
    let n_frames = FilmDesc::n_frames_of(seconds, rate)?;
    let image = opened.scene.image;
    let has_opacity = format.has_opacity() && image.background[3] < 1.0;
    let desc = FilmDesc::new(image.width, image.height, n_frames, rate)?.has_opacity(has_opacity);
    format.check(&desc)?;
    let turn = Turn::new(TurnAxis::Up, 360.0, n_frames);
    let mut renderer = Renderer::open(&opened.backend, |_| {})?;
    let film = FilmWriter::begin_anew(path, format, desc, "a turn")?;
    let render = |frame_idx: u32| {
        if progress.is_cancelled() {
            return Err(FilmingError::Cancelled);
        }
        progress.reach(f64::from(frame_idx) / f64::from(n_frames));
        let scene = turn.scene_at(&opened.scene, frame_idx)?;
        Ok(renderer.picture(&scene, opened.acquisition)?.frame.image)
    };
    let report = film.make::<FilmingError, _>(render, |_| {})?;
    Ok(format!("{}: {} frames", path.display(), report.n_frames))
}
