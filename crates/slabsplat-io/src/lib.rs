//! Files in, files out: volumes, meshes, scene files and transfer functions are read, pictures written.
//!
//! The crates that render never see a file; this one never renders. Whatever a file holds, reading it
//! gives a volume or an [`IoError`] of one line that says what, where and what to do: no panic, and
//! no memory taken on a header's word alone.
//!
//! # Formats
//!
//! | read | by |
//! | --- | --- |
//! | NRRD (`.nrrd`, `.nhdr`): raw, gzip, bzip2, hex, text; data attached, detached, in many files | [`read_volume`] |
//! | NIfTI-1 and -2, Analyze 7.5 (`.nii`, `.hdr` with `.img`; all maybe `.gz`) | [`read_volume`] |
//! | MetaImage (`.mha`, `.mhd`): raw, zlib, text; data attached, detached, in many files | [`read_volume`] |
//! | MRC, CCP4 (`.mrc`, `.map`, `.rec`, `.ali`, `.st`; all maybe `.gz`) | [`read_volume`] |
//! | DICOM: a folder or a file; plain, deflated, RLE, JPEG, JPEG-LS, JPEG 2000 | [`read_volume`] |
//! | TIFF, BigTIFF, OME-TIFF, ImageJ's: gray or RGB, a page a slice | [`read_volume`] |
//! | a folder of images: TIFF, PNG, JPEG; gray or RGB, one a slice | [`read_volume`] |
//! | NumPy (`.npy`, `.npz`) | [`read_volume`] |
//! | VTK images (`.vti`, legacy `.vtk`) | [`read_volume`] |
//! | OME-Zarr 0.4 and 0.5, in a folder or a ZIP archive | [`read_volume`] |
//! | HDF5, with the feature `hdf5` | [`read_volume`] |
//! | raw with a `.json` description beside it, or described by its name | [`read_volume`] |
//! | raw, described by the caller | [`read_raw`] |
//! | PLY (text, binary), STL (text, binary), OBJ | [`read_mesh`] |
//! | scene files (TOML), with the keys in [`scene_keys`] | [`read_scene`] |
//! | ParaView colour maps (JSON), volume properties of 3D Slicer (`.vp`) | [`read_transfer`] |
//! | scenes of pictures (PNG, TIFF, JPEG; OpenEXR, WebP with their features) that were written with them | [`read_picture_scene`] |
//!
//! | written | by |
//! | --- | --- |
//! | PNG, 8-bit RGBA, straight | [`write_png`] |
//! | OpenEXR with the feature `exr`, 32-bit float RGBA, premultiplied | `write_exr` |
//! | TIFF of 16 bits or 32-bit floats, JPEG, WebP with the feature `webp` | [`PictureFormat::write`] |
//! | any of them with the scene that it shows | [`PictureFormat::write`], [`Provenance`] |
//! | scene files | [`write_scene`] |
//! | NRRD, NIfTI, MetaImage, NumPy, raw, OME-Zarr | [`write_volume`], [`write_colored_volume`] |
//! | ParaView colour maps, volume properties of 3D Slicer, sections of scenes | [`write_transfer`] |
//!
//! Volumes that do not fit the memory: [`LayerFile::open_boxes`] reads boxes of them, and unpacks what is
//! packed into a scratch file.
//!
//! Files may be in memory: [`FilesInMemory`] reads volumes and meshes, [`png_bytes`] writes.
//! [`read_stream`] puts there what comes by a pipe.
//!
//! And without any file: [`builtin_volume`], [`preset`], [`colormap`].
//!
//! ```
//! use slabsplat_io::{read_scene, write_picture};
//! use slabsplat_core::Image;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let dir = tempfile::tempdir()?;
//! let path = dir.path().join("scene.toml");
//! std::fs::write(&path, "[volume]\ngenerate = \"cube\"\n[image]\nwidth = 64\nheight = 48\n")?;
//!
//! let scene = read_scene(&path)?;
//! let loaded = scene.layers[0].load_volume()?;
//! assert_eq!(loaded.volume.grid().dims(), [28, 28, 28]);
//!
//! let picture = Image::filled(scene.image.width, scene.image.height, [0.0; 4]);
//! write_picture(&dir.path().join("picture.png"), &picture)?;
//! # Ok(())
//! # }
//! ```
//!
//! # Reading order
//!
//! `error`, `printable`, `progress`, `store`, `stream`, `text`; `volume` and its folders; `mesh`; `builtin`;
//! `transfer`; `content_hash`; `background`; `scene`; `memory`; `picture`.

#![cfg_attr(docsrs, feature(doc_cfg))]
#![deny(clippy::exhaustive_enums, clippy::exhaustive_structs)]

mod error;
mod printable;
mod progress;
mod store;
mod stream;
mod text;

mod volume;

mod mesh;

mod builtin;

mod transfer;

mod content_hash;

mod background;

mod scene;

mod picture;

mod memory;

pub mod scene_keys;

pub use background::{Background, NotABackground};
pub use builtin::{BUILTIN_NAMES, builtin_volume};
pub use content_hash::{ContentHash, NotAHash};
pub use error::IoError;
pub use memory::{MemoryNeed, MemoryNeeds, check_memory};
pub use mesh::{LoadedMesh, MeshFormat, is_mesh_name, read_mesh};
pub use picture::{
    PictureFormat, PictureScene, Provenance, jpeg_bytes, png_bytes, quick_png_bytes,
    read_picture_scene, write_picture, write_png, write_whole,
};
#[cfg(feature = "exr")]
pub use picture::{exr_bytes, write_exr};
pub use progress::{ProgressCallback, ReadProgress};
pub use scene::{
    CameraDesc, FilmFile, KeyFile, KeyLayerFile, KeyLook, LabelBoxes, LabelColors, LabelsFile,
    LayerFile, MeshFile, RegionDesc, SceneFile, TransferImageFile, TurnFile, Unsaid, VolumeBoxes,
    VolumeSource, parse_scene, parse_scene_alone, read_scene, scene_text, write_scene,
};
pub use store::FilesInMemory;
pub use stream::read_stream;
pub use transfer::{
    COLORMAP_NAMES, FitError, PRESET_NAMES, Preset, Stretch, Suited, TransferFit, TransferFormat,
    TransferSource, ValueScale, colormap, parse_transfer, preset, read_transfer, transfer_text,
    write_transfer,
};
pub use volume::{
    Choice, ColorUse, Endian, LoadedColors, LoadedVolume, OpacitySource, Part, RawDesc,
    ScratchDesc, ScratchUse, VolumeChoices, VolumeFormat, VolumeListing, VolumeOptions,
    VolumeOutput, list_volume, read_raw, read_volume, read_volume_with, write_colored_volume,
    write_volume,
};
