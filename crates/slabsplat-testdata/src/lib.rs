//! Real volumes and the scenes that show them, for tests and benchmarks: this is the one place that knows
//! where they are.
//!
//! The repository has the scenes, in `tests/scenes`, but not the volumes, which are larger than all the rest
//! of it.
//! A volume is taken from the first of these folders that has it:
//!
//! | folder | how it comes there |
//! | --- | --- |
//! | `$SLABSPLAT_DATA`, seen from the root | whoever sets the variable has volumes |
//! | `tests/data` | `cargo xtask bench data` fetches what a package registry has, which git ignores |
//! | `../shared/data` | the project's own machines have it beside the checkout |
//!
//! A volume that is in none of them is no failure: a sentence on stderr says what is skipped.
//! Only a dev-dependency, and of the tool that measures: nothing that draws a picture knows of this crate.

use std::env;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Names a folder of volumes in the environment.
pub const VARIABLE: &str = "SLABSPLAT_DATA";

/// The scenes, by the names that [`scene`] takes.
pub const SCENES: &[&str] = &[
    "brain",
    "brain-haze",
    "embryo-perspective",
    "engine",
    "engine-shells",
    "ct-head",
    "ct-head-shells",
    "ct-thorax",
    "mr-head",
    "mr-head-shells",
];

/// Those of 10⁹ voxels, which tests leave out.
pub const LARGE_SCENES: &[&str] = &["brain-large", "brain-large-haze"];

/// How scenes name the folder of volumes, as seen from `tests/scenes`.
const DATA_FROM_SCENES: &str = "../data/";

/// Where volumes go that are fetched, `tests/data`.
#[must_use]
pub fn fetched_folder() -> PathBuf {
    root().join("tests").join("data")
}

/// The volume file `path`, as `nifti/mni152_t1_1mm_uint8.nii.gz`, or `None` after a sentence on stderr.
#[must_use]
pub fn volume(path: &str) -> Option<PathBuf> {
    let found = folders().map(|folder| folder.join(path)).find(|path| path.exists());
    if found.is_none() {
        let line =
            format!("skipped: {path} is not here; tests/data/README.md says how to get it\n");
        // Not by eprintln!, which the test runner keeps to itself where a test passes, and at once, as
        // tests run side by side; if nobody listens, nothing is lost.
        let _ = io::stderr().write_all(line.as_bytes());
    }
    found
}

/// A file with the scene of that name, whose volume is there; otherwise `None` after a sentence on stderr.
///
/// # Panics
/// If there is no such scene, or the folder `target` cannot be written to.
#[must_use]
pub fn scene(name: &str) -> Option<PathBuf> {
    let file_name = format!("{name}.toml");
    let path = root().join("tests").join("scenes").join(&file_name);
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let named = volume_path(&text);
    let volume = volume(named)?;
    if volume.starts_with(fetched_folder()) {
        return Some(path);
    }
    let text = text.replacen(
        &quoted(&format!("{DATA_FROM_SCENES}{named}")),
        &quoted(&volume.to_string_lossy()),
        1,
    );
    Some(written(&file_name, &text))
}

fn folders() -> impl Iterator<Item = PathBuf> {
    // Tests start in the folder of their crate, which nobody who sets a variable thinks of.
    let named = env::var_os(VARIABLE).filter(|folder| !folder.is_empty()).map(|f| root().join(f));
    let beside = root().join("../shared/data");
    named.into_iter().chain([fetched_folder(), beside])
}

fn root() -> &'static Path {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    folders.nth(2).expect("this crate lies two folders below the root")
}

/// What the scene names below [`DATA_FROM_SCENES`].
fn volume_path(scene: &str) -> &str {
    let path = scene.split('"').find_map(|text| text.strip_prefix(DATA_FROM_SCENES));
    path.expect("every scene names a volume in ../data/")
}

/// As TOML writes a string.
fn quoted(text: &str) -> String {
    format!("{text:?}")
}

/// A scene in the target directory. It is put there whole, as other tests may be reading it.
fn written(file_name: &str, text: &str) -> PathBuf {
    let folder = root().join("target").join("scenes");
    let path = folder.join(file_name);
    let write = || {
        fs::create_dir_all(&folder)?;
        let mut file = tempfile::NamedTempFile::new_in(&folder)?;
        file.write_all(text.as_bytes())?;
        file.persist(&path)?;
        io::Result::Ok(())
    };
    write().unwrap_or_else(|error| panic!("cannot write {}: {error}", path.display()));
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_those_of_the_folder() {
        let entries = fs::read_dir(root().join("tests/scenes")).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        let all = SCENES.iter().chain(LARGE_SCENES);
        let mut expected: Vec<String> = all.map(|name| format!("{name}.toml")).collect();
        expected.sort();
        assert_eq!(names, expected);
    }

    #[test]
    fn scene_names_the_volume_that_is_there() {
        for path in SCENES.iter().filter_map(|name| scene(name)) {
            let text = fs::read_to_string(&path).unwrap();
            let volume = text.split('"').nth(1).unwrap();
            let volume = path.parent().unwrap().join(volume);
            assert!(volume.is_file(), "{}", volume.display());
        }
    }

    #[test]
    fn volume_path_is_below_the_data() {
        assert_eq!(volume_path("# A.\n[volume]\npath = \"../data/a/b.nrrd\"\n"), "a/b.nrrd");
    }

    #[test]
    fn volume_absent() {
        assert_eq!(volume("no/such/volume.nrrd"), None);
    }
}
