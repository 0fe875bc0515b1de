//! Work on threads: files of the disk.

use super::{Job, Opener, Opening, Progress, Volumes, file_of, picture_format};
use crate::frames::Wake;
use crate::state::{self, Document};
use eframe::egui::DroppedFileHandle;
use slabsplat::film::{FilmDesc, FilmFormat, FilmWriter, FrameRate, Turn};
use slabsplat::io::{PictureFormat, ProgressCallback, Provenance, SceneFile, write_scene};
use slabsplat::{Image, OpenScene, Renderer, TurnAxis};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::mpsc;

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

/// Opens a channel of a file, which is called `name`.
pub(crate) fn open_channel(
    file: SceneFile,
    name: String,
    size: [u32; 2],
    wake: &Wake,
) -> Job<Document> {
    let wake_of_work = wake.clone();
    Job::begin(format!("opening {name}"), wake, move |progress| {
        open_file(file, name, size, progress, wake_of_work)
    })
}

/// Opens what was dropped onto the window.
pub(crate) fn open_dropped(
    opener: Opener,
    file: &DroppedFileHandle,
    size: [u32; 2],
    wake: &Wake,
) -> Job<Document> {
    open(opener, file.path().to_owned(), size, wake)
}

/// Opens what `opening` opens.
pub(crate) fn begin(name: String, opening: Opening, size: [u32; 2], wake: &Wake) -> Job<Document> {
    let title = format!("opening {name}");
    let wake_of_work = wake.clone();
    Job::begin(title, wake, move |progress| {
        Ok(Document::of(opening(size, heard(progress, wake_of_work))?, name))
    })
}

fn open_file(
    mut file: SceneFile,
    name: String,
    size: [u32; 2],
    progress: &Progress,
    wake: Wake,
) -> Result<Document, String> {
    let heard = heard(progress, wake);
    file.layers.iter_mut().for_each(|layer| layer.options.progress = Some(heard.clone()));
    Document::open(&file, name, size).map_err(|error| error.to_string())
}

/// Share of opening that is reading; the rest looks at what was read.
const READING: f64 = 0.9;

/// What hears of the reading of volumes, and ends it once the work is given up.
fn heard(progress: &Progress, wake: Wake) -> ProgressCallback {
    let progress = progress.clone();
    ProgressCallback::stopping(move |read| {
        progress.reach(READING * read.share());
        wake();
        if progress.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |it| it.to_string_lossy().into())
}

/// Writes the picture of a scene, of any size, with what it was made of. Returns a sentence.
pub(crate) fn save_picture(opened: OpenScene, path: PathBuf, wake: &Wake) -> Job<String> {
    Job::begin(format!("drawing {}", path.display()), wake, move |progress| {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let format = picture_format(&path)?;
        let mut opened = opened;
        let mut renderer = Renderer::open(&opened.backend, |_| {}).map_err(|e| text(&e))?;
        let (scene, acquisition) = (&opened.scene, opened.acquisition);
        let picture =
            renderer.picture_as(scene, acquisition, &progress.frame()).map_err(|e| text(&e))?;
        renderer.caps().name.clone_into(&mut opened.backend);
        write_picture(format, &path, &picture.frame.image, &file_of(&opened, Volumes::Here)?)
    })
}

fn write_picture(
    format: PictureFormat,
    path: &Path,
    image: &Image,
    file: &SceneFile,
) -> Result<String, String> {
    let provenance = Provenance::of_scene(file, path).map_err(|error| error.to_string())?;
    format.write(path, image, Some(&provenance)).map_err(|error| error.to_string())?;
    Ok(format!("{}: {} x {} pixels", path.display(), image.width(), image.height()))
}

/// Writes a scene file. Returns a sentence.
pub(crate) fn save_scene(
    opened: OpenScene,
    volumes: Volumes,
    path: PathBuf,
    wake: &Wake,
) -> Job<String> {
    Job::begin(format!("writing {}", path.display()), wake, move |_| {
        write_scene(&path, &file_of(&opened, volumes)?).map_err(|error| error.to_string())?;
        Ok(format!("{}: the scene", path.display()))
    })
}

/// Fits a preset to a layer, for a small picture of it.
pub(crate) fn thumbnail(opened: OpenScene, preset_idx: usize, wake: &Wake) -> Job<OpenScene> {
    Job::begin(String::new(), wake, move |_| state::thumbnail(opened, preset_idx))
}

/// Frames a second of a turntable.
const FRAMES_PER_SECOND: f64 = 30.0;

/// Films a whole turn. Returns a sentence.
pub(crate) fn film(opened: OpenScene, path: PathBuf, seconds: f64, wake: &Wake) -> Job<String> {
    let shown = path.display().to_string();
    Job::begin(format!("filming {shown}"), wake, move |progress| {
        make_film(&opened, &path, seconds, progress).map_err(|error| match error {
            FilmingError::Cancelled => {
                format!("the film was given up; its frames are in {shown}.frames")
            }
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
        FilmingError::Other(
            "the name of a film ends in .mp4, .webm, .gif, .webp or .apng".to_owned(),
        )
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

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::io::VolumeSource;
    use std::fs;
    use std::sync::Arc;
    use std::time::{Duration, Instant};

    /// A header of a gigabyte of nothing, which takes no room on a disk.
    fn large(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("slabsplat-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::File::create(folder.join("a.raw")).unwrap().set_len(1 << 30).unwrap();
        let header = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1024 1024 1024\nencoding: raw\ndata file: a.raw\n";
        fs::write(folder.join("a.nhdr"), header).unwrap();
        folder.join("a.nhdr")
    }

    #[test]
    fn a_thread_ends_when_what_it_reads_is_given_up() {
        let path = large("given-up");
        let opener: Opener =
            Arc::new(|path| Ok(SceneFile::of_volume(VolumeSource::File(path.to_owned()))));
        let wake: Wake = Arc::new(|| {});
        let job = open(opener, path.clone(), [64, 64], &wake);
        let progress = job.progress.clone();
        let began = Instant::now();
        while job.share() == 0.0 && began.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        drop(job);
        // Whoever works has a copy of it.
        while 1 < Arc::strong_count(&progress.thousandths) {
            assert!(began.elapsed() < Duration::from_secs(60), "it goes on");
            std::thread::sleep(Duration::from_millis(1));
        }
        let share = progress.thousandths.load(std::sync::atomic::Ordering::Relaxed);
        assert!(share < 880, "it was read to the end");
        fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }
}
