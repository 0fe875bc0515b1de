//! Files in, files out: volumes, scenes and pictures; and volumes made from formulas.
//!
//! - [`read_volume`] reads NRRD, NIfTI-1 and -2, and raw samples, in their own type, placed in RAS+
//!   millimetres where the file says where they are.
//! - [`builtin_volume`] makes one of [`BUILTIN_NAMES`].
//! - [`read_scene`] reads a scene file; what it leaves out is left to whoever has seen the volume.
//! - [`write_picture`] writes OpenEXR or PNG, whole or not at all.
//!
//! Files are not trusted: nothing is allocated on a header's word alone, and every complaint is one line
//! that says what, where and what to do.
//!
//! # Reading order
//!
//! `error`; `volume`, `builtin`; `scene`; `picture`.
//!
//! ```
//! use slabsplat_io::{builtin_volume, write_picture};
//! use slabsplat_core::Image;
//!
//! let volume = builtin_volume("cube", None)?;
//! assert_eq!(volume.grid().dims(), [28; 3]);
//!
//! let err = write_picture("picture.jpg".as_ref(), &Image::filled(2, 2, [1.0; 4])).unwrap_err();
//! assert_eq!(err.to_string(), "cannot tell the format of picture.jpg: name the picture .exr or .png");
//! # Ok::<(), slabsplat_io::IoError>(())
//! ```

mod error;
mod text;

mod builtin;
mod volume;

mod scene;

mod picture;

pub use builtin::{BUILTIN_NAMES, builtin_volume};
pub use error::{Found, IoError};
pub use picture::{PictureFormat, write_exr, write_picture, write_png};
pub use scene::{
    CameraDesc, PRESET_NAMES, ProjectionKind, SceneFile, VolumeSource, preset, read_color_map,
    read_scene,
};
pub use volume::{Endian, LoadedVolume, RawDesc, VolumeFormat, read_raw, read_volume};
