//! The folder of frames beside a film that is being made: a PNG for each, and a text that says of which film
//! they are. What it holds is whole at any moment, so that a run that was interrupted, however hard, can be
//! continued.

use crate::encode::Frames;
use crate::metadata::Metadata;
use crate::pixels::Pixels;
use crate::{FilmDesc, FilmError};
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

/// The text that says of which film the frames are.
const IDENTITY: &str = "film.txt";

/// What a frame's file is called while it is written.
const PART: &str = "frame.part";

/// Frames on disk.
pub(crate) struct FrameFolder {
    path: PathBuf,
    desc: FilmDesc,
    lock: Lock,
}

/// The text, locked, and released however the program ends.
struct Lock(File);

impl Lock {
    /// None where somebody else has it.
    fn take(text: File) -> Option<Self> {
        match text.try_lock() {
            // Where a file system has no locks, one run is believed to be the only one.
            Ok(()) | Err(TryLockError::Error(_)) => Some(Self(text)),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    fn write(&mut self, identity: &str) -> io::Result<()> {
        self.0.set_len(0)?;
        self.0.write_all(identity.as_bytes())
    }
}

impl Drop for Lock {
    /// Closed, a file is unlocked only when nobody else has it open, and a process that another thread starts
    /// has it until it runs its own program.
    fn drop(&mut self) {
        let _ = self.0.unlock();
    }
}

impl FrameFolder {
    /// The folder of the film at `target`, and how many of its frames are there already.
    ///
    /// `anew` has those of any film removed.
    pub(crate) fn open(
        target: &Path,
        desc: &FilmDesc,
        identity: &str,
        anew: bool,
    ) -> Result<(Self, u32), FilmError> {
        let mut name = target.as_os_str().to_owned();
        name.push(".frames");
        let path = PathBuf::from(name);
        let text = path.join(IDENTITY);
        let is_there = path.symlink_metadata().is_ok();
        if is_there && !text.is_file() {
            check_empty(&path)?;
        }
        fs::create_dir_all(&path).map_err(FilmError::write(&path))?;
        let mut options = File::options();
        let lock = options.read(true).append(true).create(true).open(&text);
        let Some(lock) = Lock::take(lock.map_err(FilmError::write(&text))?) else {
            return Err(FilmError::InUse { folder: path });
        };
        let mut folder = Self { path, desc: *desc, lock };
        let n_done = folder.begin(identity, anew)?;
        Ok((folder, n_done))
    }

    /// Says of which film its frames are, unless it does already, and counts them.
    fn begin(&mut self, identity: &str, anew: bool) -> Result<u32, FilmError> {
        let text = self.path.join(IDENTITY);
        let said = fs::read_to_string(&text).map_err(FilmError::write(&text))?;
        // A film that failed before its first frame leaves nothing to continue.
        if !anew && said != identity && has_frames(&self.path)? {
            let what = difference(&said, identity);
            return Err(FilmError::OtherFilm { folder: self.path.clone(), what });
        }
        if said != identity {
            remove_files(&self.path, is_frame)?;
            self.lock.write(identity).map_err(FilmError::write(&text))?;
            return Ok(0);
        }
        if anew {
            remove_files(&self.path, is_frame)?;
        }
        let is_there = |frame_idx: &u32| self.frame_path(*frame_idx).is_file();
        Ok((0..self.desc.n_frames).filter(is_there).count() as u32)
    }

    fn frame_path(&self, frame_idx: u32) -> PathBuf {
        self.path.join(format!("frame_{frame_idx:05}.png"))
    }

    /// A file in the folder that is no frame.
    pub(crate) fn beside(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Stores a frame, with what its file says of itself.
    pub(crate) fn write(
        &self,
        frame_idx: u32,
        frame: &Pixels,
        metadata: &Metadata,
    ) -> Result<(), FilmError> {
        let part = self.path.join(PART);
        let written = || -> io::Result<()> {
            let mut writer = BufWriter::new(File::create(&part)?);
            frame.write_png(&mut writer, self.desc.has_opacity, metadata)?;
            writer.flush()?;
            drop(writer);
            fs::rename(&part, self.frame_path(frame_idx))
        };
        written().map_err(FilmError::write(&self.frame_path(frame_idx)))
    }

    /// A frame that was stored before, if it was, or what is wrong with its file: after a loss of power it
    /// may be a name without content.
    pub(crate) fn stored(&self, frame_idx: u32) -> Option<Result<Pixels, FilmError>> {
        self.frame_path(frame_idx).is_file().then(|| self.read(frame_idx))
    }

    /// The file `made` within it becomes the film, and the folder is gone.
    pub(crate) fn end_with_file(self, made: &Path, target: &Path) -> Result<(), FilmError> {
        fs::rename(made, target).map_err(FilmError::write(target))?;
        drop(self.lock);
        fs::remove_dir_all(&self.path).map_err(FilmError::write(&self.path))
    }

    /// The folder itself becomes the film.
    pub(crate) fn end_as_folder(self, target: &Path) -> Result<(), FilmError> {
        remove_sequence(target)?;
        // A folder with an open file cannot be renamed everywhere.
        drop(self.lock);
        remove_files(&self.path, |path| !is_frame(path))?;
        fs::rename(&self.path, target).map_err(FilmError::write(target))
    }
}

impl Frames for FrameFolder {
    fn read(&self, frame_idx: u32) -> Result<Pixels, FilmError> {
        let bad = |what: String| FilmError::BadFrame { frame_idx, folder: self.path.clone(), what };
        let file =
            File::open(self.frame_path(frame_idx)).map_err(|error| bad(error.to_string()))?;
        Pixels::read_png(BufReader::new(file), [self.desc.width, self.desc.height]).map_err(bad)
    }
}

/// That a film of `target` as a folder takes the place of nothing but another one.
pub(crate) fn check_sequence(target: &Path) -> Result<(), FilmError> {
    if target.symlink_metadata().is_err() {
        return Ok(());
    }
    check_empty(target)
}

fn remove_sequence(target: &Path) -> Result<(), FilmError> {
    check_sequence(target)?;
    match fs::remove_dir_all(target) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(FilmError::write(target)(error))
        }
        _ => Ok(()),
    }
}

fn remove_files(folder: &Path, is_to_go: impl Fn(&Path) -> bool) -> Result<(), FilmError> {
    for entry in fs::read_dir(folder).map_err(FilmError::write(folder))? {
        let path = entry.map_err(FilmError::write(folder))?.path();
        if is_to_go(&path) {
            fs::remove_file(&path).map_err(FilmError::write(&path))?;
        }
    }
    Ok(())
}

fn has_frames(folder: &Path) -> Result<bool, FilmError> {
    let mut entries = fs::read_dir(folder).map_err(FilmError::write(folder))?;
    Ok(entries.any(|entry| entry.is_ok_and(|entry| is_frame(&entry.path()))))
}

/// That a folder has nothing but frames.
fn check_empty(path: &Path) -> Result<(), FilmError> {
    let in_the_way = || FilmError::InTheWay { path: path.to_owned() };
    let mut entries = fs::read_dir(path).map_err(|_| in_the_way())?;
    let is_all_frames = entries.all(|entry| entry.is_ok_and(|entry| is_frame(&entry.path())));
    if is_all_frames { Ok(()) } else { Err(in_the_way()) }
}

fn is_frame(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let number = name.strip_prefix("frame_").and_then(|rest| rest.strip_suffix(".png"));
    number.is_some_and(|number| number.len() == 5 && number.bytes().all(|b| b.is_ascii_digit()))
}

/// The first line in which two texts differ, as people call it.
fn difference(said: &str, identity: &str) -> String {
    let mut lines = said.lines().zip(identity.lines());
    let line = lines.find(|(said, now)| said != now).map(|(said, now)| {
        let key = |line: &str| line.split_once('=').map(|(key, _)| key.trim().to_owned());
        match (key(said), key(now)) {
            (Some(a), Some(b)) if a == b => a,
            _ => "its scene".to_owned(),
        }
    });
    line.unwrap_or_else(|| "its scene".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FrameRate;

    fn desc(n_frames: u32) -> FilmDesc {
        FilmDesc::new(2, 2, n_frames, FrameRate::new(10.0).unwrap()).unwrap()
    }

    fn frame(value: u8) -> Pixels {
        Pixels { width: 2, height: 2, rgba: [value, value, value, 255].repeat(4) }
    }

    #[test]
    fn folder_continues_the_same_film_alone() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("a.gif");
        let open = |identity: &str, anew| FrameFolder::open(&target, &desc(9), identity, anew);
        let (folder, n_done) = open("size = 2\n", false).unwrap();
        assert_eq!(n_done, 0);
        for idx in [0, 1, 3] {
            folder.write(idx, &frame(idx as u8), &Metadata::default()).unwrap();
        }
        assert!(matches!(open("size = 2\n", false), Err(FilmError::InUse { .. })));
        drop(folder);
        let (folder, n_done) = open("size = 2\n", false).unwrap();
        assert_eq!((n_done, folder.read(1).unwrap()), (3, frame(1)));
        assert!(folder.stored(2).is_none());
        drop(folder);
        let error = open("size = 3\n", false).err().unwrap().to_string();
        assert!(error.contains("differs in size"), "{error}");
        assert_eq!(open("size = 3\n", true).unwrap().1, 0);
    }

    /// As a process that another thread starts has it for a moment.
    #[test]
    fn folder_is_free_though_its_text_is_open_elsewhere() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("a.gif");
        let open = || FrameFolder::open(&target, &desc(9), "x", false);
        let (folder, _) = open().unwrap();
        let elsewhere = folder.lock.0.try_clone().unwrap();
        drop(folder);
        assert!(open().is_ok());
        drop(elsewhere);
    }

    /// Of a film that failed before its first frame nothing is in the way of the mended one.
    #[test]
    fn folder_without_frames_is_any_films() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("a.gif");
        for identity in ["slab_width = 1e-9\n", "slab_width = 1\n"] {
            let (_, n_done) = FrameFolder::open(&target, &desc(9), identity, false).unwrap();
            assert_eq!(n_done, 0);
        }
    }

    #[test]
    fn folder_does_not_believe_a_damaged_frame() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("a.gif");
        let (folder, _) = FrameFolder::open(&target, &desc(9), "x", false).unwrap();
        (0..3).for_each(|idx| folder.write(idx, &frame(7), &Metadata::default()).unwrap());
        fs::write(folder.frame_path(1), "").unwrap();
        assert!(matches!(folder.stored(1), Some(Err(FilmError::BadFrame { frame_idx: 1, .. }))));
        assert_eq!(folder.stored(2).unwrap().unwrap(), frame(7));
        assert!(folder.stored(3).is_none());
    }

    /// Frames of another film are not lost because the first of them is.
    #[test]
    fn folder_of_another_film_without_its_first_frame() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("a.gif");
        let (folder, _) = FrameFolder::open(&target, &desc(9), "x", false).unwrap();
        folder.write(5, &frame(7), &Metadata::default()).unwrap();
        drop(folder);
        let other = FrameFolder::open(&target, &desc(9), "y", false);
        assert!(matches!(other, Err(FilmError::OtherFilm { .. })));
    }

    #[test]
    fn folder_leaves_what_is_not_its_own() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("a.gif");
        let frames = dir.path().join("a.gif.frames");
        fs::create_dir(&frames).unwrap();
        fs::write(frames.join("precious.txt"), "x").unwrap();
        let open = FrameFolder::open(&target, &desc(9), "x", true);
        assert!(matches!(open, Err(FilmError::InTheWay { .. })));
        assert!(frames.join("precious.txt").is_file());
        assert!(check_sequence(&frames).is_err());
        assert!(check_sequence(&dir.path().join("none")).is_ok());
    }
}
