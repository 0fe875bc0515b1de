//! Where the files of a scene are: by which names a scene file may have them, and a picture.

use std::env;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::{LabelColors, LayerFile, SceneFile, VolumeSource};

/// What a scene in `folder` means by a path: one from there on, but for standard input, which is nowhere.
pub(super) fn in_folder(folder: &Path, path: &Path) -> PathBuf {
    if is_stdin(path) { path.to_owned() } else { folder.join(path) }
}

/// Whether a path is what programs call standard input: `-`, or an array of it, as `-:name`.
fn is_stdin(path: &Path) -> bool {
    let after = path.to_str().and_then(|path| path.strip_prefix('-'));
    after.is_some_and(|after| after.is_empty() || after.starts_with(':'))
}

/// The folder that relative paths start from in a scene of that name.
pub(super) fn folder_of(scene: &Path) -> &Path {
    scene.parent().unwrap_or(Path::new(""))
}

impl SceneFile {
    /// The same with other names of all files, but for what comes by standard input.
    pub(crate) fn with_paths(mut self, mut path: impl FnMut(&Path) -> PathBuf) -> Self {
        let mut rename = |old: &mut PathBuf| {
            if !is_stdin(old) {
                *old = path(old);
            }
        };
        self.layers.iter_mut().flat_map(LayerFile::paths).for_each(&mut rename);
        self.meshes.iter_mut().for_each(|mesh| rename(&mut mesh.path));
        self
    }

    /// The same with names as they are from the folder of a scene of that name, where they can be told.
    pub(super) fn seen_from(self, scene: &Path) -> Self {
        let folder = folder_of(scene);
        self.with_paths(|path| from_folder(folder, path).unwrap_or_else(|| path.to_owned()))
    }

    /// The same with names that tell a stranger no more than they must: as they were given, or from the
    /// picture's folder on, if they are relative; of others, what is below that folder, or the file's name.
    pub(crate) fn seen_from_picture(self, picture: &Path) -> Self {
        let folder = folder_of(picture);
        self.with_paths(|path| {
            let below = below(folder, path).filter(|rest| path.is_relative() || !climbs(rest));
            let is_from_one_place = path.is_relative() && !climbs(folder);
            let seen = below.or_else(|| is_from_one_place.then(|| up_from(folder).join(path)));
            let name = if path.is_relative() { Some(path.as_os_str()) } else { path.file_name() };
            seen.or_else(|| name.map(PathBuf::from)).unwrap_or_default()
        })
    }
}

impl LayerFile {
    fn paths(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let volume = match &mut self.volume {
            VolumeSource::File(path) => Some(path),
            VolumeSource::Builtin { .. } => None,
        };
        let image = self.transfer_image.as_mut().map(|image| &mut image.path);
        let (mut map, mut table) = (None, None);
        if let Some(labels) = &mut self.labels {
            map = Some(&mut labels.path);
            if let Some(LabelColors::Table(path)) = &mut labels.colors {
                table = Some(path);
            }
        }
        [volume, image, map, table].into_iter().flatten()
    }
}

/// A path that is given from the working directory on, as it is from a folder that is given likewise. `None`
/// where nobody knows the working directory.
fn from_folder(folder: &Path, path: &Path) -> Option<PathBuf> {
    if let Some(path) = below(folder, path) {
        return Some(path);
    }
    if path.is_absolute() {
        return Some(path.to_owned());
    }
    if folder.is_relative() && !climbs(folder) {
        return Some(up_from(folder).join(path));
    }
    // `..` means the parent of what a link leads to.
    let folder = fs::canonicalize(folder).ok()?;
    let working = fs::canonicalize(env::current_dir().ok()?).ok()?;
    Some(between(&folder, &working).join(path))
}

/// The path from a folder on, if it is named from there.
fn below(folder: &Path, path: &Path) -> Option<PathBuf> {
    if folder == Path::new("") {
        return path.is_relative().then(|| path.to_owned());
    }
    let rest = path.strip_prefix(folder).ok()?;
    (!rest.as_os_str().is_empty()).then(|| rest.to_owned())
}

/// Whether a path leaves the folder that it starts from, or that is not known.
fn climbs(path: &Path) -> bool {
    path.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir))
}

/// From a folder back to where its name starts.
fn up_from(folder: &Path) -> PathBuf {
    let n_up = folder.components().filter(|part| matches!(part, Component::Normal(_))).count();
    (0..n_up).map(|_| Component::ParentDir).collect()
}

/// From one absolute folder to another; that itself, if they are on two drives.
fn between(from: &Path, to: &Path) -> PathBuf {
    let common = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return to.to_owned();
    }
    let n_up = from.components().count() - common;
    let up = (0..n_up).map(|_| Component::ParentDir);
    up.chain(to.components().skip(common)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(path: &str) -> SceneFile {
        SceneFile::of_volume(VolumeSource::File(path.into()))
    }

    fn path_of(scene: &SceneFile) -> String {
        let VolumeSource::File(path) = &scene.layers[0].volume else { panic!("{scene:?}") };
        path.to_str().unwrap().to_owned()
    }

    #[test]
    fn paths_are_seen_from_the_scene() {
        for (scene, path, expected) in [
            ("x.toml", "a.nii", "a.nii"),
            ("x.toml", "../a.nii", "../a.nii"),
            ("out/x.toml", "a.nii", "../a.nii"),
            ("./out/2/x.toml", "data/a.nii", "../../data/a.nii"),
            ("out/x.toml", "out/a.nii", "a.nii"),
            ("out/x.toml", "out/../a.nii", "../a.nii"),
            ("out/x.toml", "/data/a.nii", "/data/a.nii"),
            ("/data/x.toml", "/data/b/a.nii", "b/a.nii"),
            ("out/x.toml", "-", "-"),
            ("out/x.toml", "-:name", "-:name"),
        ] {
            let seen = path_of(&of(path).seen_from(Path::new(scene)));
            assert_eq!(seen, expected, "{path} from {scene}");
            assert!(
                !path.starts_with('-')
                    || in_folder(Path::new("out"), Path::new(path)) == Path::new(path)
            );
        }
        // From a folder elsewhere, there is the same file behind it.
        let dir = tempfile::tempdir().unwrap();
        let scene = dir.path().join("x.toml");
        let seen = path_of(&of("Cargo.toml").seen_from(&scene));
        let there = fs::canonicalize(dir.path().join(&seen)).unwrap();
        assert_eq!(there, fs::canonicalize("Cargo.toml").unwrap(), "{seen}");
    }

    #[test]
    fn paths_in_pictures_are_short() {
        for (picture, path, expected) in [
            ("x.png", "a.nii", "a.nii"),
            ("x.png", "data/a.nii", "data/a.nii"),
            ("out/x.png", "data/a.nii", "../data/a.nii"),
            ("/tmp/x.png", "data/a.nii", "data/a.nii"),
            ("../x.png", "data/a.nii", "data/a.nii"),
            ("x.png", "/home/julia/a.nii", "a.nii"),
            ("/home/julia/x.png", "/home/julia/scans/a.nii", "scans/a.nii"),
            ("/home/julia/x.png", "/home/max/a.nii", "a.nii"),
            ("/home/julia/x.png", "/home/julia/../max/a.nii", "a.nii"),
        ] {
            let seen = path_of(&of(path).seen_from_picture(Path::new(picture)));
            assert_eq!(seen, expected, "{path} from {picture}");
        }
    }
}
