//! The formats, by what tells them.

use super::Foreign;

/// Of microscopes' makers: all are read by one library.
const BIO_FORMATS: &str =
    "`bfconvert IN OUT.ome.tif` (Bio-Formats), or Fiji, saves an OME-TIFF of it";

pub(super) const FORMATS: &[Foreign] = &[
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
pub(super) const N5: Foreign = Foreign {
    name: "N5",
    magic: &[],
    extensions: &["n5"],
    remedy: "in Python with zarr 2, `numpy.save(\"OUT.npy\", zarr.open(zarr.N5FSStore(\"IN\"))[\"ARRAY\"])` \
             saves an array of it, and Fiji opens it, and saves TIFF",
};
