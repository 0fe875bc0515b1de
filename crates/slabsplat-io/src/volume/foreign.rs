//! Formats of volumes and meshes that are not read: how they are known, and what converts them. A stranger
//! with such a file is told a program, and not only a list of what else there is.

use std::path::Path;

use super::stream::plain_extension;
use crate::IoError;
use crate::store::Store;

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

/// Of microscopes' makers: all are read by one library.
const BIO_FORMATS: &str =
    "`bfconvert IN OUT.ome.tif` (Bio-Formats), or Fiji, saves an OME-TIFF of it";

const FORMATS: &[Foreign] = &[
    Foreign {
        name: "FreeSurfer's MGH",
        magic: &[],
        extensions: &["mgz", "mgh"],
        remedy: "`mri_convert IN OUT.nii.gz` (FreeSurfer), or `mrconvert IN OUT.nii.gz` (MRtrix), converts it",
    },
    Foreign {
        name: "Nikon's ND2",
        magic: &[(0, b"\xda\xce\xbe\x0a")],
        extensions: &["nd2"],
        remedy: BIO_FORMATS,
    },
    Foreign {
        name: "Zeiss's CZI, LSM or ZVI",
        magic: &[(0, b"ZISRAWFILE")],
        extensions: &["czi", "lsm", "zvi"],
        remedy: BIO_FORMATS,
    },
    Foreign { name: "Leica's LIF", magic: &[], extensions: &["lif", "xlef"], remedy: BIO_FORMATS },
    Foreign {
        name: "a microscope's format",
        magic: &[],
        extensions: &[
            "oib", "oif", "oir", "vsi", "dv", "r3d", "stk", "svs", "ndpi", "ics", "ids", "sld",
        ],
        remedy: BIO_FORMATS,
    },
    Foreign {
        name: "NetCDF as it was before HDF5, maybe MINC",
        magic: &[(0, b"CDF\x01"), (0, b"CDF\x02"), (0, b"CDF\x05")],
        extensions: &["mnc"],
        remedy: "`nccopy -k nc4 IN OUT.nc` makes it HDF5, and `mnc2nii IN OUT.nii` a NIfTI of a MINC",
    },
    Foreign {
        name: "MRtrix's MIF",
        magic: &[(0, b"mrtrix image")],
        extensions: &["mif", "mih"],
        remedy: "`mrconvert IN OUT.nii.gz` converts it",
    },
    Foreign {
        name: "AFNI's BRIK",
        magic: &[],
        extensions: &["brik", "head"],
        remedy: "`3dAFNItoNIFTI IN` converts it",
    },
    Foreign {
        name: "Philips's PAR/REC",
        magic: &[],
        extensions: &["par"],
        remedy: "`dcm2niix`, or nibabel's `parrec2nii`, converts it",
    },
    Foreign {
        name: "GIPL",
        magic: &[],
        extensions: &["gipl"],
        remedy: "`c3d IN -o OUT.nii.gz` (ITK-SNAP's Convert3D) converts it",
    },
    Foreign {
        name: "ENVI's header",
        magic: &[(0, b"ENVI\n"), (0, b"ENVI\r")],
        extensions: &[],
        remedy: "its samples are raw: name the file without .hdr, with --dims, --type and --header-bytes as \
                 the header says them; if its interleave is not bsq, make it so by `gdal_translate -of ENVI \
                 -co INTERLEAVE=BSQ IN OUT`",
    },
    Foreign {
        name: "AmiraMesh",
        magic: &[(0, b"# AmiraMesh"), (0, b"# Avizo"), (0, b"# HyperMesh")],
        extensions: &["am", "amiramesh"],
        remedy: "Amira and Avizo save TIFF, and `bfconvert IN OUT.ome.tif` (Bio-Formats) makes an OME-TIFF of it",
    },
    Foreign {
        name: "OpenVDB",
        magic: &[(0, b" BDV")],
        extensions: &["vdb"],
        remedy: "a dense array is read: in Python, `openvdb`'s `copyToArray`, then `numpy.save` of its `.T`, as \
                 x comes first in it",
    },
    Foreign {
        name: "VTK's SLC",
        magic: &[],
        extensions: &["slc"],
        remedy: "VTK's `vtkSLCReader` and `vtkXMLImageDataWriter` make a .vti of it",
    },
    Foreign {
        name: "Bio-Rad's PIC",
        magic: &[],
        extensions: &["pic"],
        remedy: "Fiji opens it, and saves TIFF",
    },
    Foreign {
        name: "Blender's BVOX",
        magic: &[],
        extensions: &["bvox"],
        remedy: "it is raw: --dims, --type float32 and --header-bytes 16 read a frame of it",
    },
    Foreign {
        name: "MRtrix's TCK",
        magic: &[(0, b"mrtrix tracks")],
        extensions: &["tck"],
        remedy: "`tckconvert IN OUT.ply` makes tubes of it",
    },
    Foreign {
        name: "TrackVis's TRK",
        magic: &[(0, b"TRACK\0")],
        extensions: &["trk"],
        remedy: "`nib-trk2tck IN` (nibabel) makes a .tck, and MRtrix's `tckconvert` a .ply of that",
    },
    Foreign {
        name: "GIfTI, a surface",
        magic: &[],
        extensions: &["gii"],
        remedy: "`mris_convert IN OUT.stl` (FreeSurfer) converts it",
    },
    Foreign {
        name: "a mesh",
        magic: &[(0, b"glTF"), (0, b"OFF\n")],
        extensions: &["gltf", "glb", "off", "3mf", "dae", "fbx"],
        remedy: "ParaView, MeshLab or Blender saves it as .ply, .stl or .obj",
    },
    Foreign {
        name: "JPEG 2000",
        magic: &[(0, b"\0\0\0\x0cjP  \r\n"), (0, b"\xff\x4f\xff\x51")],
        extensions: &["jp2", "j2k", "jpx"],
        remedy: "`opj_decompress -i IN -o OUT.tif` unpacks it",
    },
    Foreign {
        name: "a picture",
        magic: &[(0, b"\x89PNG"), (0, b"\xff\xd8\xff")],
        extensions: &["png", "jpg", "jpeg"],
        remedy: "one picture is no volume: name the folder that holds all slices",
    },
    Foreign {
        name: "a tar archive",
        magic: &[(257, b"ustar")],
        extensions: &["tar", "tgz"],
        remedy: "unpack it, and name what is in it",
    },
    Foreign {
        name: "packed as a whole",
        magic: &[
            (0, b"7z\xbc\xaf"),
            (0, b"Rar!"),
            (0, b"\xfd7zXZ\0"),
            (0, b"BZh"),
            (0, b"\x28\xb5\x2f\xfd"),
        ],
        extensions: &["7z", "rar", "xz", "bz2", "zst"],
        remedy: "unpack it, as by `zstd -dc IN | slabsplat info -`",
    },
];

/// Folders, of which those below need not say what they are.
const N5: Foreign = Foreign {
    name: "N5",
    magic: &[],
    extensions: &["n5"],
    remedy: "in Python with zarr 2, `numpy.save(\"OUT.npy\", zarr.open(zarr.N5FSStore(\"IN\"))[\"ARRAY\"])` \
             saves an array of it, and Fiji opens it, and saves TIFF",
};

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
