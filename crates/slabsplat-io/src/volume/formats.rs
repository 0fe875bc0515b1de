//! What a format must say of itself, the list of all, and which one a file is in.
//!
//! A new format is a module with a [`Reader`], a line in [`READERS`] and a line in [`VolumeFormat`].

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use slabsplat_core::SampleType;

use super::choices::{VolumeChoices, VolumeOptions};
use super::spill::Spill;
use super::{
    LoadedVolume, dicom, foreign, hdf5, images, metaimage, mrc, nifti, npy, nrrd, raw_name,
    sidecar, stream, tiff, vtk, zarr,
};
use crate::IoError;
use crate::printable::printable;
use crate::store::Store;

/// All formats. The first that knows a file's content reads it, or else the first that knows its name.
const READERS: &[&dyn Reader] = &[
    &dicom::Dicom,
    &nrrd::Nrrd,
    &tiff::Tiff,
    &metaimage::MetaImage,
    // Before NIfTI: a header of 348 columns begins as one of Analyze.
    &mrc::Mrc,
    &nifti::Nifti,
    &npy::Npy,
    &npy::Npz,
    &vtk::Vtk,
    &hdf5::Hdf5,
    &zarr::Zarr,
    // A folder that is nothing else.
    &images::Images,
    &sidecar::Sidecar,
    &raw_name::RawName,
];

macro_rules! formats {
    ($($(#[doc = $doc:literal])+ $variant:ident = $name:literal,)+) => {
        /// What a volume was read from.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum VolumeFormat {
            $($(#[doc = $doc])+ $variant,)+
        }

        impl VolumeFormat {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The format's name as it is written in prose.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}

formats! {
    /// NRRD, with its data attached or in files of their own.
    Nrrd = "NRRD",
    /// Analyze 7.5, a pair.
    Analyze = "Analyze 7.5",
    /// NIfTI-1, one file or a pair.
    Nifti1 = "NIfTI-1",
    /// NIfTI-2, one file or a pair.
    Nifti2 = "NIfTI-2",
    /// MetaImage, with its data attached or in files of their own.
    MetaImage = "MetaImage",
    /// DICOM, a folder of slices or a file of them.
    Dicom = "DICOM",
    /// A map of electron microscopy or crystallography.
    Mrc = "MRC",
    /// A folder of images, each of them a slice.
    Images = "image stack",
    /// Pages of a TIFF.
    Tiff = "TIFF",
    /// An array of NumPy, alone or in an archive.
    Npy = "NumPy",
    /// An image of VTK, in XML or in the legacy format.
    Vtk = "VTK",
    /// A data set of HDF5, or of what is made of it: NetCDF-4, MATLAB 7.3, Imaris.
    Hdf5 = "HDF5",
    /// An array in chunks, with what OME says of it or without.
    Zarr = "OME-Zarr",
    /// Samples without a header.
    Raw = "raw",
    /// No file: see [`builtin_volume`](crate::builtin_volume).
    Builtin = "built-in",
}

/// How the volumes of a format are found and read.
pub(super) trait Reader: Sync {
    /// The format's name and extensions, for lists: `NRRD (.nrrd, .nhdr)`.
    fn listed(&self) -> &'static str;

    /// The extensions of its files, in lower case and without `.gz`.
    fn extensions(&self) -> &'static [&'static str];

    /// Whether a file that begins like this is in the format; up to [`stream::N_FIRST_BYTES`], unpacked if
    /// gzip packed them.
    fn is_begun_by(&self, start: &[u8]) -> bool;

    /// Whether a file whose content says nothing is in the format, by its name or by what is beside it.
    fn is_named(&self, _store: Store<'_>, path: &Path) -> bool {
        self.extensions().contains(&stream::plain_extension(path).as_str())
    }

    /// The file that says what the volume is like, for a file that [`Self::is_named`] for the format.
    ///
    /// # Errors
    /// If there is none, or the file should have begun as others of its name do.
    fn header_of(&self, _store: Store<'_>, path: &Path) -> Result<PathBuf, IoError> {
        Err(not_begun(self.listed(), path))
    }

    /// Whether a folder is a volume of the format; `files` are those directly in it.
    fn is_folder(&self, _store: Store<'_>, _folder: &Path, _files: &[PathBuf]) -> bool {
        false
    }

    /// Whether a file that begins as those of the format do is of another one.
    fn is_other(&self, _store: Store<'_>, _path: &Path) -> bool {
        false
    }

    /// Whether the arrays of a file have names by which one is chosen.
    fn names_arrays(&self) -> bool {
        false
    }

    /// Whether it reads some voxels without the others ([`VolumeOptions::voxels`]), if they are stored so.
    fn reads_boxes(&self) -> bool {
        false
    }

    /// Reads what is asked for.
    fn read(&self, input: &Input<'_>) -> Result<LoadedVolume, IoError>;

    /// What would be read, as far as headers say it.
    fn list(&self, input: &Input<'_>) -> Result<VolumeListing, IoError>;
}

/// That a file does not begin as those of its name do; `listed` is [`Reader::listed`].
pub(super) fn not_begun(listed: &str, path: &Path) -> IoError {
    let name = listed.split(" (").next().unwrap_or_default();
    let what = format!("not a {name} file, or cut off: it does not begin as one");
    IoError::malformed(path, what)
}

/// No system has longer paths.
const MAX_NAME_BYTES: usize = 4096;

/// What is to be read.
pub(super) struct Input<'a> {
    pub(super) store: Store<'a>,
    /// The file that says what the volume is like, or the folder that is one.
    pub(super) path: &'a Path,
    pub(super) options: &'a VolumeOptions,
    /// Where samples go instead of into memory.
    pub(super) spill: Option<Arc<Spill>>,
}

/// What a file says that it holds, before any sample is read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct VolumeListing {
    /// In which format.
    pub format: VolumeFormat,
    /// Voxels along each axis of the volume that would be read.
    pub dims: [usize; 3],
    /// The type of its samples.
    pub sample_type: SampleType,
    /// What else there is.
    pub choices: VolumeChoices,
}

impl VolumeListing {
    /// Bytes that the samples will take in memory, on the word of the header, which nothing has backed yet.
    pub fn bytes(&self) -> u64 {
        let n_voxels = self.dims.into_iter().fold(1, |n: u64, size| n.saturating_mul(size as u64));
        // Beside colours there is the scalar that is made of them.
        let n_values = if self.choices.is_color { self.choices.channel.n + 1 } else { 1 };
        let voxel_bytes = n_values * self.sample_type.size_bytes();
        n_voxels.saturating_mul(voxel_bytes as u64)
    }
}

impl Input<'_> {
    /// The path of a file that the header names, which must be in the header's folder or below, unless the
    /// caller allows others.
    ///
    /// # Errors
    /// If it is not.
    pub(super) fn beside(&self, name: &str) -> Result<PathBuf, IoError> {
        if MAX_NAME_BYTES < name.len() {
            let what = format!("it names a file by {} bytes, which no name has", name.len());
            return Err(IoError::malformed(self.path, what));
        }
        let is_below = |component| matches!(component, Component::Normal(_) | Component::CurDir);
        if self.options.allow_external || Path::new(name).components().all(is_below) {
            return Ok(self.path.parent().unwrap_or(Path::new("")).join(name));
        }
        let (path, name) = (self.path.to_owned(), name.to_owned());
        Err(IoError::External { path, name })
    }
}

impl Input<'_> {
    /// The folder of files whose names are made of `pattern`, as of [`Self::beside`].
    ///
    /// # Errors
    /// If they would be outside of the header's folder.
    pub(super) fn folder_of(&self, pattern: &str) -> Result<PathBuf, IoError> {
        self.beside(pattern)?;
        Ok(self.path.parent().map(PathBuf::from).unwrap_or_default())
    }
}

/// What is to be read, and how.
pub(super) struct Found {
    pub(super) reader: &'static dyn Reader,
    pub(super) path: PathBuf,
    pub(super) options: VolumeOptions,
}

/// The reader of a file or a folder, where the path may end in the name of an array, as `a.npz:name`.
pub(super) fn find(
    store: Store<'_>,
    path: &Path,
    options: &VolumeOptions,
) -> Result<Found, IoError> {
    let mut options = options.clone();
    let (path, name) = split_array(store, path);
    options.array = name.or(options.array);
    let (reader, path) = find_reader(store, &path)?;
    match &options.array {
        Some(name) if !reader.names_arrays() => {
            let what = format!("there are no arrays with names here: leave out {name:?}");
            Err(IoError::unsupported(path, what))
        }
        _ => Ok(Found { reader, path, options }),
    }
}

/// A path that there is, and what comes after it and a colon.
fn split_array(store: Store<'_>, path: &Path) -> (PathBuf, Option<String>) {
    let is_there = |path: &Path| store.has(path) || store.is_folder(path);
    let whole = || (path.to_owned(), None);
    let Some(text) = path.to_str().filter(|_| !is_there(path)) else { return whole() };
    let mut colons = text.match_indices(':').map(|(at, _)| at);
    let split = colons.find(|&at| store.has(Path::new(&text[..at])));
    split.map_or_else(whole, |at| (PathBuf::from(&text[..at]), Some(text[at + 1..].to_owned())))
}

/// The reader of a file or a folder, and the path that it needs.
fn find_reader(store: Store<'_>, path: &Path) -> Result<(&'static dyn Reader, PathBuf), IoError> {
    if store.is_folder(path) {
        return find_folder(store, path);
    }
    let start = stream::first_bytes(store, path)?;
    if let Some(reader) =
        READERS.iter().find(|reader| reader.is_begun_by(&start) && !reader.is_other(store, path))
    {
        return Ok((*reader, path.to_owned()));
    }
    if let Some((foreign, folder)) = foreign::of_part(path, &start) {
        return Err(foreign.error(folder));
    }
    let is_it =
        |reader: &&&dyn Reader| reader.is_named(store, path) && !reader.is_other(store, path);
    let foreign = foreign::of_content(&start);
    match (READERS.iter().find(is_it), foreign.or_else(|| foreign::of_name(path))) {
        (Some(reader), _) => match (reader.header_of(store, path), foreign) {
            (Err(_), Some(foreign)) => Err(foreign.error(path)),
            (header, _) => Ok((*reader, header?)),
        },
        (None, Some(foreign)) => Err(foreign.error(path)),
        (None, None) => Err(IoError::UnknownFormat { path: path.to_owned(), known: known() }),
    }
}

fn find_folder(store: Store<'_>, folder: &Path) -> Result<(&'static dyn Reader, PathBuf), IoError> {
    let files = store.files_in(folder)?;
    let reader = READERS.iter().find(|reader| reader.is_folder(store, folder, &files));
    match reader.ok_or_else(|| foreign::of_folder(store, folder)) {
        Ok(reader) => Ok((*reader, folder.to_owned())),
        Err(Some(foreign)) => Err(foreign.error(folder)),
        Err(None) if files.is_empty() => {
            Err(IoError::malformed(folder, "the folder itself holds no files that can be read"))
        }
        Err(None) => {
            let held = held_by(&files);
            Err(IoError::UnknownFolder { path: folder.to_owned(), held })
        }
    }
}

/// What can be read, for people.
fn known() -> String {
    READERS.iter().map(|reader| reader.listed()).collect::<Vec<_>>().join(", ")
}

/// How many kinds of files are told of, and how many of each by name.
const MAX_TOLD: usize = 5;

/// How many files there are of each extension, those that are read first, and the first of each, `2 .png
/// (a.png, b.png)`.
fn held_by(files: &[PathBuf]) -> String {
    let mut kinds: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in files {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        kinds.entry(stream::plain_extension(file)).or_default().push(printable(&name));
    }
    let mut kinds: Vec<(String, Vec<String>)> = kinds.into_iter().collect();
    let is_read = |extension: &str| READERS.iter().any(|it| it.extensions().contains(&extension));
    kinds.sort_by_key(|(extension, names)| (!is_read(extension), Reverse(names.len())));
    let told = |(extension, names): &(String, Vec<String>)| {
        let kind = match extension.as_str() {
            "" => "without an extension".to_owned(),
            extension => format!(".{}", printable(extension)),
        };
        format!("{} {kind} ({})", names.len(), first_of(names))
    };
    kinds.iter().take(MAX_TOLD).map(told).collect::<Vec<_>>().join(", ")
}

fn first_of(names: &[String]) -> String {
    let mut names = names.to_vec();
    names.sort();
    if names.len() > MAX_TOLD {
        names.truncate(MAX_TOLD);
        names.push("…".to_owned());
    }
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beside_a_header_and_nowhere_else() {
        let mut options = VolumeOptions::default();
        let beside = |options: &VolumeOptions, name: &str| {
            let input =
                Input { store: Store::Disk, path: Path::new("in/a.nhdr"), options, spill: None };
            input.beside(name).map_err(|error| error.to_string())
        };
        assert_eq!(beside(&options, "b.raw").unwrap(), Path::new("in/b.raw"));
        assert_eq!(beside(&options, "./c/b.raw").unwrap(), Path::new("in/./c/b.raw"));
        let long = beside(&options, &"b".repeat(5000)).unwrap_err();
        assert_eq!(long, "in/a.nhdr: it names a file by 5000 bytes, which no name has");
        for name in ["../b.raw", "/etc/passwd", "c/../../b.raw"] {
            let error = beside(&options, name).unwrap_err();
            assert!(error.contains(name) && error.contains("outside of its folder"), "{error}");
        }
        options.allow_external = true;
        assert_eq!(beside(&options, "../b.raw").unwrap(), Path::new("in/../b.raw"));
    }

    #[test]
    fn documentation_has_every_format() {
        let text = include_str!("../../docs/formats.md");
        for format in VolumeFormat::ALL {
            let heading = format!("\n## {}\n", format.name());
            assert!(text.contains(&heading), "docs/formats.md lacks {:?}", format.name());
        }
    }

    #[test]
    fn folders_say_what_they_hold() {
        let files = ["a.PNG", "b.png", "c.txt", "d"].map(PathBuf::from);
        assert_eq!(
            held_by(&files),
            "2 .png (a.PNG, b.png), 1 without an extension (d), 1 .txt (c.txt)"
        );
        let slices = ["a.1", "a.2", "a.3", "a.4", "a.5", "a.nhdr"].map(PathBuf::from);
        assert!(held_by(&slices).starts_with("1 .nhdr (a.nhdr), 1 .1 (a.1), "));
        let many = ["6.a", "5.a", "4.a", "3.a", "2.a", "1.a"].map(PathBuf::from);
        assert_eq!(held_by(&many), "6 .a (1.a, 2.a, 3.a, 4.a, 5.a, …)");
    }
}
