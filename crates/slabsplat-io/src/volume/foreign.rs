//! Formats of volumes and meshes that are not read: how they are known, and what converts them. A stranger
//! with such a file is told a program, and not only a list of what else there is.

mod known;

use std::path::Path;

use super::stream::plain_extension;
use crate::IoError;
use crate::store::Store;
use known::{FORMATS, N5};

/// A format that is known, and not read.
#[derive(Debug)]
pub(super) struct Foreign {
    /// What it is called: this is ...
    name: &'static str,
    /// The bytes that it begins with, and where they are; none if nothing tells it.
    magic: &'static [(usize, &'static [u8])],
    /// In lower case, without `.gz`.
    extensions: &'static [&'static str],
    /// What makes a file of it that is read.
    remedy: &'static str,
}

/// What tells of a group or an array of N5.
const N5_ATTRIBUTES: &str = "attributes.json";

/// A key of descriptions of raw files, and none of N5.
const DIMS: &[u8] = b"\"dims\"";

/// The N5 that a file is part of, and its folder, if it begins like this.
pub(super) fn of_part<'p>(path: &'p Path, start: &[u8]) -> Option<(&'static Foreign, &'p Path)> {
    // Somebody may have described a raw file by that name.
    let has_dims = start.windows(DIMS.len()).any(|bytes| bytes == DIMS);
    let is_part = path.file_name().is_some_and(|name| name == N5_ATTRIBUTES) && !has_dims;
    is_part.then(|| (&N5, path.parent().unwrap_or(Path::new(""))))
}

/// The format of a folder that is none of those that are read.
pub(super) fn of_folder(store: Store<'_>, folder: &Path) -> Option<&'static Foreign> {
    let is_named = N5.extensions.contains(&plain_extension(folder).as_str());
    (is_named || store.has(&folder.join(N5_ATTRIBUTES))).then_some(&N5)
}

/// The format whose content begins like this.
pub(super) fn of_content(start: &[u8]) -> Option<&'static Foreign> {
    let is_there = |&(at, bytes): &(usize, &[u8])| start.get(at..at + bytes.len()) == Some(bytes);
    FORMATS.iter().find(|format| format.magic.iter().any(is_there))
}

/// The format of files with such a name.
pub(super) fn of_name(path: &Path) -> Option<&'static Foreign> {
    let extension = plain_extension(path);
    FORMATS.iter().find(|format| format.extensions.contains(&extension.as_str()))
}

impl Foreign {
    /// That the file is not read, and what to do.
    pub(super) fn error(&self, path: &Path) -> IoError {
        let Self { name, remedy, .. } = self;
        IoError::unsupported(path, format!("this is {name}, which is not read: {remedy}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FilesInMemory;

    fn refused(name: &str, bytes: &[u8]) -> String {
        let files = FilesInMemory::from_iter([(name, bytes)]);
        files.read_volume(name).map(|loaded| loaded.format).unwrap_err().to_string()
    }

    #[test]
    fn foreign_formats_are_named_with_what_converts_them() {
        for (name, bytes, expected) in [
            (
                "a.mgz",
                &b"\0\0\0\x01"[..],
                "a.mgz: this is FreeSurfer's MGH, which is not read: `mri_convert",
            ),
            ("a.dat", b"ZISRAWFILE\0\0", "Zeiss's CZI"),
            ("a.hdr", b"ENVI\nsamples = 5\n", "--header-bytes"),
            ("a.dat", b"mrtrix tracks\n", "`tckconvert"),
            ("a.dat", b"glTF\x02\0\0\0", "a mesh, which is not read: ParaView"),
            ("a.vdb", b" BDV\0\0", "OpenVDB"),
            ("a.tif", b"\x89PNG\r\n\x1a\n", "name the folder"),
            ("a.nrrd", b"\x28\xb5\x2f\xfd\0", "unpack it"),
        ] {
            let message = refused(name, bytes);
            assert!(message.contains(expected), "{message}");
        }
    }

    /// Of N5 the root has a version, an array its size, and a group may have nothing.
    #[test]
    fn foreign_folders_are_named_with_what_converts_them() {
        let refused = |folder: &str, files: &[&str]| {
            let files = FilesInMemory::from_iter(files.iter().map(|&file| (file, &b"{}"[..])));
            files.read_volume(folder).map(|loaded| loaded.format).unwrap_err().to_string()
        };
        for (folder, files) in [
            ("a", &["a/attributes.json", "a/s0/0/0/0"][..]),
            ("a/s0", &["a/s0/attributes.json", "a/s0/0/0/0"]),
            ("a.n5", &["a.n5/s0/attributes.json", "a.n5/s0/0/0/0"]),
        ] {
            let message = refused(folder, files);
            let expected = format!("{folder}: this is N5, which is not read: in Python");
            assert!(message.starts_with(&expected), "{message}");
        }
        for (file, folder) in [("a/s0/attributes.json", "a/s0"), ("attributes.json", ".")] {
            let message = refused(file, &[file]);
            assert!(message.starts_with(&format!("{folder}: this is N5, which")), "{message}");
        }
        let other = refused("a", &["a/b.json", "a/s0/0"]);
        assert!(!other.contains("N5"), "{other}");
        let zarr = refused("a", &["a/.zgroup", "a/attributes.json"]);
        assert!(!zarr.contains("N5"), "{zarr}");
    }

    #[test]
    fn foreign_is_no_description_of_a_raw_file() {
        let description = br#"{ "dims": [1, 1, 2], "type": "uint8", "file": "a.bin" }"#;
        let files = [("a/attributes.json", &description[..]), ("a/a.bin", &[1, 2])];
        let loaded = FilesInMemory::from_iter(files).read_volume("a/attributes.json").unwrap();
        assert_eq!(loaded.volume.grid().dims(), [1, 1, 2]);
    }

    /// A table that names an extension which is read would be wrong sooner or later.
    #[test]
    fn foreign_extensions_are_none_that_are_read() {
        for extension in FORMATS.iter().flat_map(|format| format.extensions) {
            let message = refused(&format!("a.{extension}"), b"?");
            assert!(message.contains("which is not read"), "{extension}: {message}");
        }
    }
}
