//! A file that is there as a whole or not at all: written beside its place under another name, then
//! renamed.

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use crate::IoError;

/// Writes a file as a whole or not at all: if it fails, whatever stood there before still does.
///
/// # Errors
/// If the file cannot be written.
pub fn write_whole(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), IoError> {
    write(path.as_ref(), |writer| writer.write_all(bytes))
}

/// Lets `write` fill the file at `path`. If it fails, whatever stood there before still does, and
/// nothing else is left.
pub(crate) fn write(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<(), IoError> {
    try_write(path, write).map_err(IoError::write(path))
}

fn try_write(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> io::Result<()> {
    let path = &linked(path);
    if is_special(path) {
        return write_through(path, write);
    }
    let mut file = beside(path)?;
    let mut writer = BufWriter::new(file.as_file_mut());
    write(&mut writer)?;
    writer.flush()?;
    drop(writer);
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// Where a path leads, if it is a link; the link itself stays.
fn linked(path: &Path) -> PathBuf {
    match (path.canonicalize(), path.read_link()) {
        (Ok(end), Ok(_)) => end,
        (Err(_), Ok(target)) => path.parent().unwrap_or(Path::new("")).join(target),
        (_, Err(_)) => path.to_owned(),
    }
}

/// Whether something is there that a file must not take the place of: a device, such as `/dev/null`, or a
/// pipe.
fn is_special(path: &Path) -> bool {
    path.metadata().is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// Fills a file that has no name, as devices and pipes go in one direction only, and sends what it holds.
fn write_through(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = tempfile::tempfile()?;
    let mut writer = BufWriter::new(&mut file);
    write(&mut writer)?;
    writer.flush()?;
    drop(writer);
    file.rewind()?;
    let mut target = File::options().write(true).open(path)?;
    io::copy(&mut file, &mut target).map(|_| ())
}

/// A file in the same folder, since only within one file system is a rename atomic.
fn beside(path: &Path) -> io::Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut builder = Builder::new();
    builder.prefix(".slabsplat-").suffix(".part");
    // Without this the picture would be its owner's alone, as temporary files are.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder.unwrap_or(Path::new("."))).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => io::Error::new(error.kind(), "its folder is not there"),
        _ => without_name(error),
    })
}

/// The error without the name of a file that nobody asked for, which is in it then.
pub(crate) fn without_name(error: io::Error) -> io::Error {
    match error.get_ref() {
        Some(_) => error.kind().into(),
        None => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn names(dir: &Path) -> Vec<String> {
        let entries = fs::read_dir(dir).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn atomic_failure_leaves_what_was_there() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let fail = |writer: &mut BufWriter<&mut File>| {
            writer.write_all(&[1; 100_000])?;
            Err(io::Error::other("disk full"))
        };
        let err = write(&path, fail).unwrap_err().to_string();
        assert!(err.ends_with("a.png: disk full"), "{err}");
        assert_eq!(names(dir.path()), [""; 0]);

        fs::write(&path, "old").unwrap();
        write(&path, fail).unwrap_err();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write(&path, |writer| writer.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(dir.path()), ["a.png"]);
    }

    #[test]
    fn atomic_needs_a_folder_and_a_file() {
        let dir = tempfile::tempdir().unwrap();
        let nothing = |_: &mut BufWriter<&mut File>| Ok(());
        let err = write(&dir.path().join("b/a.png"), nothing).unwrap_err().to_string();
        assert!(err.starts_with("cannot write ") && !err.contains(".slabsplat-"), "{err}");
        assert!(err.ends_with("b/a.png: its folder is not there"), "{err}");
        fs::create_dir(dir.path().join("a.png")).unwrap();
        write(&dir.path().join("a.png"), nothing).unwrap_err();
        assert_eq!(names(dir.path()), ["a.png"]);
    }

    /// Nothing takes the place of a device, a pipe or a link.
    #[cfg(unix)]
    #[test]
    fn atomic_writes_through_links_and_pipes() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let dir = tempfile::tempdir().unwrap();
        let [link, target, pipe] = ["link", "target", "pipe"].map(|name| dir.path().join(name));
        symlink("target", &link).unwrap();
        for text in ["one", "another"] {
            // It leads nowhere at first.
            write_whole(&link, text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&target).unwrap(), text);
            assert!(link.symlink_metadata().unwrap().is_symlink());
        }
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        write_whole(&pipe, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(pipe.metadata().unwrap().file_type().is_fifo());
        assert_eq!(names(dir.path()).len(), 3, "and nothing is left");
    }

    #[cfg(unix)]
    #[test]
    fn atomic_file_has_usual_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let mode =
            |name: &str| fs::metadata(dir.path().join(name)).unwrap().permissions().mode() & 0o777;
        write(&dir.path().join("ours"), |_| Ok(())).unwrap();
        fs::write(dir.path().join("usual"), "").unwrap();
        assert_eq!(mode("ours"), mode("usual"));
    }
}
