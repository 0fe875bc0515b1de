//! What a picture was made of, in its own file, so that it can be made again.
//!
//! A picture gets about: it is published, and it comes from strangers. So what is written has no absolute
//! path, and what is read goes through the reader of scene files with its limits; what it names is looked
//! for from the picture's folder on.

use std::path::Path;

#[cfg(feature = "webp")]
use super::webp;
use super::{PictureFormat, png};
use crate::printable::printable;
use crate::scene::text_of;
use crate::store::Store;
use crate::{FilesInMemory, IoError, SceneFile, parse_scene};

/// What a picture's file says of how it was made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Provenance {
    /// The program and its version, as `slabsplat 0.1.0`.
    pub program: Option<String>,
    /// The text of its scene.
    pub scene: Option<String>,
}

/// What a picture says of the scene that it shows.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PictureScene {
    /// The scene, with paths from the picture's folder on.
    pub scene: SceneFile,
    /// The program that made it, if the picture says that.
    pub program: Option<String>,
}

/// No picture carries a longer scene: it would be larger than most pictures.
const MAX_SCENE_BYTES: usize = 256 << 10;

/// No program has a longer name.
const MAX_PROGRAM_CHARS: usize = 80;

impl Provenance {
    /// The program that this is.
    pub const PROGRAM: &str = concat!("slabsplat ", env!("CARGO_PKG_VERSION"));

    pub(super) const NONE: Self = Self { program: None, scene: None };

    /// What a picture of that name says if it shows that scene, which is best [`SceneFile::completed`].
    /// Relative paths are as they are from the picture's folder on, or as they were given, if nobody can say
    /// without naming folders; of an absolute one, what is below that folder, or the file's name.
    ///
    /// # Errors
    /// As [`scene_text`](crate::scene_text), and if its text is longer than 256 KiB, which is too much for a
    /// picture: then it goes into a scene file.
    pub fn of_scene(scene: &SceneFile, picture: impl AsRef<Path>) -> Result<Self, IoError> {
        let picture = picture.as_ref();
        let text = text_of(&scene.clone().seen_from_picture(picture), picture)?;
        if MAX_SCENE_BYTES < text.len() {
            let what = format!(
                "its {} KiB of text are too much for a picture, which takes {}",
                text.len() >> 10,
                MAX_SCENE_BYTES >> 10
            );
            return Err(IoError::SceneText { path: picture.to_owned(), what });
        }
        Ok(Self { program: Some(Self::PROGRAM.to_owned()), scene: Some(text) })
    }

    /// The same as keywords and texts of a PNG, for who writes animated ones.
    pub fn png_texts(&self) -> Vec<(String, String)> {
        let texts = png::texts(self);
        texts.map(|(keyword, text)| (keyword.to_owned(), text.to_owned())).collect()
    }

    /// The same as a packet of XMP, for who writes animated WebPs.
    #[cfg(feature = "webp")]
    pub fn xmp(&self) -> String {
        webp::packet(self)
    }
}

/// The scene that a picture shows, by what its file says, or `None` if that says nothing of it. Nothing in it
/// is believed: it may say what a scene file may, and no file by an absolute path. A file that is not where
/// the picture names it is looked for in the working directory.
///
/// # Errors
/// If the file is no picture that can be read, or its scene is none.
pub fn read_picture_scene(path: impl AsRef<Path>) -> Result<Option<PictureScene>, IoError> {
    read_from(Store::Disk, path.as_ref())
}

impl FilesInMemory<'_> {
    /// As [`read_picture_scene`].
    ///
    /// # Errors
    /// As there.
    pub fn read_picture_scene(
        &self,
        path: impl AsRef<Path>,
    ) -> Result<Option<PictureScene>, IoError> {
        read_from(Store::Memory(self), path.as_ref())
    }
}

fn read_from(store: Store<'_>, path: &Path) -> Result<Option<PictureScene>, IoError> {
    let format = PictureFormat::of_picture(path)
        .ok_or_else(|| IoError::UnknownPicture { path: path.to_owned() })?;
    let Provenance { program, scene } = format.read_provenance(store, path)?;
    let Some(text) = scene else { return Ok(None) };
    if MAX_SCENE_BYTES < text.len() {
        return Err(IoError::malformed(path, "its scene is longer than 256 KiB"));
    }
    let scene = found(store, path, parse_scene(&text, path)?)?;
    let shown =
        |program: String| printable(&program.chars().take(MAX_PROGRAM_CHARS).collect::<String>());
    Ok(Some(PictureScene { scene, program: program.map(shown) }))
}

/// The scene with files where they are.
fn found(store: Store<'_>, picture: &Path, scene: SceneFile) -> Result<SceneFile, IoError> {
    let folder = picture.parent().unwrap_or(Path::new(""));
    let is_there = |path: &Path| store.has(path) || store.is_folder(path);
    let mut absolute = None;
    let scene = scene.with_paths(|path| {
        // An absolute path is not joined to a folder.
        let named = match path.strip_prefix(folder) {
            Ok(named) if named.is_relative() => named,
            _ => {
                absolute = Some(path.to_owned());
                path
            }
        };
        if !is_there(path) && is_there(named) { named.to_owned() } else { path.to_owned() }
    });
    match absolute {
        None => Ok(scene),
        Some(path) => {
            let path = path.display();
            let what =
                format!("its scene names {path} by an absolute path, which none of ours does");
            Err(IoError::malformed(picture, what))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LayerFile, Unsaid, VolumeSource};
    use slabsplat_core::{Image, TransferFunction};
    use std::fs;

    fn image() -> Image {
        Image::filled(5, 3, [0.1, 0.2, 0.3, 1.0])
    }

    fn scene(path: &str) -> SceneFile {
        let file = SceneFile::of_volume(VolumeSource::File(path.into()));
        SceneFile { unsaid: Unsaid::default(), ..file }
    }

    /// A picture with that text for its scene.
    fn picture(format: PictureFormat, path: &Path, text: &str) {
        let provenance = Provenance { program: Some("a\u{1b}b".into()), scene: Some(text.into()) };
        format.write(path, &image(), Some(&provenance)).unwrap();
    }

    #[test]
    fn provenance_comes_back() {
        let dir = tempfile::tempdir().unwrap();
        for &format in PictureFormat::ALL {
            let path = dir.path().join("grün").with_extension(format.extensions()[0]);
            let volume = dir.path().join("data/grün.nii");
            let scene = scene(volume.to_str().unwrap());
            let provenance = Provenance::of_scene(&scene, &path).unwrap();
            let text = provenance.scene.clone().unwrap();
            assert!(text.contains("path = \"data/grün.nii\""), "{text}");
            format.write(&path, &image(), Some(&provenance)).unwrap();
            assert_eq!(
                fs::read(&path).unwrap(),
                format.bytes(&image(), Some(&provenance)).unwrap()
            );
            let read = read_picture_scene(&path).unwrap().unwrap();
            let bytes = fs::read(&path).unwrap();
            let files = FilesInMemory::from_iter([(&path, bytes.as_slice())]);
            assert_eq!(files.read_picture_scene(&path).unwrap().as_ref(), Some(&read));
            assert_eq!((read.scene, read.program.as_deref()), (scene, Some(Provenance::PROGRAM)));
            format.write(&path, &image(), None).unwrap();
            assert_eq!(read_picture_scene(&path).unwrap(), None);
            let bytes = fs::read(&path).unwrap();
            let is_in = |word: &[u8]| bytes.windows(word.len()).any(|found| found == word);
            assert!(!is_in(b"slabsplat"), "nothing is told of a picture that is to tell nothing");
        }
    }

    #[test]
    fn provenance_is_not_believed() {
        let dir = tempfile::tempdir().unwrap();
        let check = |text: &str, expected: &str| {
            for &format in PictureFormat::ALL {
                let path = dir.path().join("x").with_extension(format.extensions()[0]);
                picture(format, &path, text);
                let error = read_picture_scene(&path).unwrap_err().to_string();
                assert!(error.contains(expected) && !error.contains('\u{1b}'), "{error}");
                assert!(!error.contains('\n'), "{error}");
            }
        };
        check("", "x.");
        check("[volume]\npath = \"a.nii\"\n[rendr]", ":3: unknown section [rendr]");
        check("[volume]\npath = \"/etc/passwd\"", "names /etc/passwd by an absolute path");
        check(
            "[mesh]\npath = \"/etc/a\\u001b.stl\"",
            "names /etc/a\u{fffd}.stl by an absolute path",
        );
        check(&format!("#{}", "x".repeat(300 << 10)), "its scene is longer than 256 KiB");
        let path = dir.path().join("x.png");
        picture(PictureFormat::Png, &path, "[volume]\npath = \"a.nii\"");
        let read = read_picture_scene(&path).unwrap().unwrap();
        assert_eq!(read.program.as_deref(), Some("a\u{fffd}b"));
        // A short file that unpacks to a long text.
        picture(PictureFormat::Png, &path, &format!("#{}", "x".repeat(20 << 20)));
        assert!(fs::metadata(&path).unwrap().len() < 100_000);
        assert_eq!(read_picture_scene(&path).unwrap(), None);
        for (name, bytes) in [
            ("a.png", &b""[..]),
            #[cfg(feature = "exr")]
            ("b.exr", b"v/1\x01"),
            ("c.png", b"\x89PNG\r\n"),
        ] {
            let path = dir.path().join(name);
            fs::write(&path, bytes).unwrap();
            let error = read_picture_scene(&path).unwrap_err().to_string();
            assert!(error.contains("not a picture in"), "{error}");
        }
        assert!(read_picture_scene(dir.path().join("none.png")).is_err());
        assert!(read_picture_scene(dir.path().join("x.gif")).is_err());
    }

    /// Whatever bytes a picture has, reading them ends with a scene or an error.
    #[test]
    fn provenance_of_spoilt_pictures() {
        let dir = tempfile::tempdir().unwrap();
        let mut rng = fastrand::Rng::with_seed(3);
        for &format in PictureFormat::ALL {
            let path = dir.path().join("x").with_extension(format.extensions()[0]);
            let provenance = Provenance::of_scene(&scene("a.nii"), &path).unwrap();
            let whole = format.bytes(&image(), Some(&provenance)).unwrap();
            for _ in 0..300 {
                let mut bytes = whole.clone();
                bytes.truncate(rng.usize(1..=bytes.len()));
                for _ in 0..rng.usize(1..4) {
                    let at = rng.usize(..bytes.len());
                    bytes[at] = rng.u8(..);
                }
                fs::write(&path, &bytes).unwrap();
                let _ = read_picture_scene(&path);
            }
        }
    }

    #[test]
    fn provenance_has_a_limit() {
        let points = (0..20_000).map(|n| (f64::from(n) + 0.123_456, 0.5));
        let transfer = TransferFunction::new(points, [(0.0, [1.0; 3])]).unwrap();
        let volume = VolumeSource::File("a.nii".into());
        let mut scene = scene("a.nii");
        scene.layers = vec![LayerFile { transfer: Some(transfer), ..LayerFile::of_volume(volume) }];
        let error = Provenance::of_scene(&scene, "x.png").unwrap_err().to_string();
        assert!(error.contains("KiB of text are too much for a picture"), "{error}");
    }

    #[test]
    fn provenance_finds_files_in_the_working_directory() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("x.png");
        picture(PictureFormat::Png, &path, "[volume]\npath = \"Cargo.toml\"");
        let read = read_picture_scene(&path).unwrap().unwrap().scene;
        assert_eq!(read.layers[0].volume, VolumeSource::File("Cargo.toml".into()));
    }
}
