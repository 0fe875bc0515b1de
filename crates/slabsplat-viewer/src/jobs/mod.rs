//! Work that takes its time: files that are opened, pictures and films that are written. It says how far it
//! is, and can be given up. On a desktop each has a thread of its own; in a page it takes turns with all
//! else.

#[cfg(not(target_arch = "wasm32"))]
mod desktop;
#[cfg(target_arch = "wasm32")]
mod page;

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use desktop::*;
#[cfg(target_arch = "wasm32")]
pub(crate) use page::*;

use slabsplat::io::{PictureFormat, ProgressCallback, SceneFile};
use slabsplat::{FrameHandle, OpenScene};
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};
#[cfg(target_arch = "wasm32")]
use std::task::Waker;

/// What a scene file makes of a name: a volume, a scene, a picture that says what it shows.
pub type Opener = Arc<dyn Fn(&Path) -> Result<SceneFile, String> + Send + Sync>;

/// What opens something for views of a size, in pixels, on a thread of its own. The callback hears how far
/// reading is, and stops it when it is given up.
pub type Opening = Box<dyn FnOnce([u32; 2], ProgressCallback) -> Result<OpenScene, String> + Send>;

/// Where the volumes of a scene are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Volumes {
    Here,
    /// Here are others in their place, as overviews of a server's.
    Elsewhere,
}

/// A scene as a file, without hashes of what is here if that is not what it shows.
fn file_of(opened: &OpenScene, volumes: Volumes) -> Result<SceneFile, String> {
    let mut file = opened.to_file().map_err(|error| error.to_string())?;
    if volumes == Volumes::Elsewhere {
        for layer in &mut file.layers {
            layer.hash = None;
            layer.labels.iter_mut().for_each(|labels| labels.hash = None);
        }
        file.meshes.iter_mut().for_each(|mesh| mesh.hash = None);
    }
    Ok(file)
}

/// The format that the name of a picture says.
fn picture_format(path: &Path) -> Result<PictureFormat, String> {
    let endings = PictureFormat::endings;
    let format = PictureFormat::of_name(path);
    format.ok_or_else(|| format!("the name of a picture ends in {}", endings()))
}

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
    /// Who waits for others to do it.
    #[cfg(target_arch = "wasm32")]
    waker: Arc<Mutex<Option<Waker>>>,
}

impl Progress {
    pub(crate) fn reach(&self, share: f64) {
        self.thousandths.store((1000.0 * share) as u32, Ordering::Relaxed);
    }

    /// A frame that is part of it: it is cancelled with the rest.
    #[cfg(not(target_arch = "wasm32"))]
    fn frame(&self) -> FrameHandle {
        let frame = FrameHandle::new();
        *self.frame.lock().unwrap_or_else(PoisonError::into_inner) = Some(frame.clone());
        if self.is_cancelled() {
            frame.cancel();
        }
        frame
    }

    pub(crate) fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed) != 0
    }

    fn cancel(&self) {
        self.is_cancelled.store(1, Ordering::Relaxed);
        if let Some(frame) = &*self.frame.lock().unwrap_or_else(PoisonError::into_inner) {
            frame.cancel();
        }
        #[cfg(target_arch = "wasm32")]
        self.wake();
    }

    #[cfg(target_arch = "wasm32")]
    pub(crate) fn set_waker(&self, waker: &Waker) {
        *self.waker.lock().unwrap_or_else(PoisonError::into_inner) = Some(waker.clone());
    }

    /// Has whoever waits look again.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn wake(&self) {
        let waker = self.waker.lock().unwrap_or_else(PoisonError::into_inner).take();
        waker.into_iter().for_each(Waker::wake);
    }
}

impl<T> Job<T> {
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
