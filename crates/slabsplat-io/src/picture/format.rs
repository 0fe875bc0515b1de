//! The formats of pictures, each with room for what the picture was made of.

use std::io::{BufReader, Cursor, Seek, Write};
use std::path::Path;

use slabsplat_core::Image;

#[cfg(feature = "exr")]
use super::exr;
#[cfg(feature = "webp")]
use super::webp;
use super::{Provenance, atomic, jpeg, png, tiff};
use crate::store::Store;
use crate::{IoError, SceneFile};

/// How a picture is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PictureFormat {
    /// 8 bits a channel, not premultiplied.
    Png,
    /// OpenEXR: 32-bit floats, premultiplied, bit by bit what was drawn.
    #[cfg(feature = "exr")]
    Exr,
    /// TIFF, 16 bits a channel, not premultiplied.
    Tiff,
    /// TIFF, 32-bit floats, premultiplied, bit by bit what was drawn.
    TiffFloat,
    /// JPEG of quality 95, for opaque pictures.
    Jpeg,
    /// WebP: 8 bits a channel, not premultiplied, lossless.
    #[cfg(feature = "webp")]
    WebP,
}

/// Features that add a format of that name and extension, and are off here.
const LEFT_OUT: &[&str] = &[
    #[cfg(not(feature = "exr"))]
    "exr",
    #[cfg(not(feature = "webp"))]
    "webp",
];

/// Why a picture is no JPEG.
pub(super) const NO_TRANSPARENCY: &str =
    "JPEG has no transparency: an opaque background is needed, or another format";

/// Longest side of a WebP.
#[cfg(feature = "webp")]
const MAX_WEBP_SIDE: u32 = 16384;

impl PictureFormat {
    /// All of them.
    pub const ALL: &[Self] = &[
        Self::Png,
        #[cfg(feature = "exr")]
        Self::Exr,
        Self::Tiff,
        Self::TiffFloat,
        Self::Jpeg,
        #[cfg(feature = "webp")]
        Self::WebP,
    ];

    /// The format's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
            #[cfg(feature = "exr")]
            Self::Exr => "exr",
            Self::Tiff => "tiff",
            Self::TiffFloat => "tiff-float",
            Self::Jpeg => "jpeg",
            #[cfg(feature = "webp")]
            Self::WebP => "webp",
        }
    }

    /// The extensions of its files, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Png => &["png"],
            #[cfg(feature = "exr")]
            Self::Exr => &["exr"],
            Self::Tiff | Self::TiffFloat => &["tif", "tiff"],
            Self::Jpeg => &["jpg", "jpeg"],
            #[cfg(feature = "webp")]
            Self::WebP => &["webp"],
        }
    }

    /// All extensions, for people: `.png, .exr or .tif`.
    pub fn endings() -> String {
        let mut endings: Vec<String> = Vec::new();
        for format in Self::ALL {
            let ending = format!(".{}", format.extensions()[0]);
            if !endings.contains(&ending) {
                endings.push(ending);
            }
        }
        let last = endings.pop().unwrap_or_default();
        format!("{} or {last}", endings.join(", "))
    }

    /// The feature that is off here and would add the format that a name's extension says.
    pub fn missing_feature(path: impl AsRef<Path>) -> Option<&'static str> {
        let extension = path.as_ref().extension()?;
        LEFT_OUT.iter().copied().find(|feature| extension.eq_ignore_ascii_case(feature))
    }

    /// The format that a name's extension says, of TIFF the one of 16 bits; `None` if it says none of these.
    pub fn of_name(path: impl AsRef<Path>) -> Option<Self> {
        let extension = path.as_ref().extension()?;
        let is_its = |format: &&Self| {
            format.extensions().iter().any(|its| extension.eq_ignore_ascii_case(its))
        };
        Self::ALL.iter().find(is_its).copied()
    }

    /// The format by which a file of that name is read as a picture: an animated PNG is one, too.
    pub fn of_picture(path: impl AsRef<Path>) -> Option<Self> {
        let is_apng = |extension: &std::ffi::OsStr| extension.eq_ignore_ascii_case("apng");
        let is_png = path.as_ref().extension().is_some_and(is_apng);
        if is_png { Some(Self::Png) } else { Self::of_name(path) }
    }

    /// Whether files of the format may be volumes as well as pictures.
    pub fn holds_volumes(self) -> bool {
        matches!(self, Self::Tiff | Self::TiffFloat)
    }

    /// That it can hold a scene's picture, as far as can be told before anything of it is read.
    ///
    /// # Errors
    /// If the background shines through and the format has no transparency, or a side is too long for it.
    pub fn check(self, scene: &SceneFile) -> Result<(), IoError> {
        let what = match self {
            Self::Jpeg if is_transparent(scene) => NO_TRANSPARENCY.to_owned(),
            #[cfg(feature = "webp")]
            Self::WebP if MAX_WEBP_SIDE < scene.image.width.max(scene.image.height) => {
                format!("sides of a WebP are at most {MAX_WEBP_SIDE} pixels")
            }
            _ => return Ok(()),
        };
        Err(IoError::Encode { source: std::io::Error::other(what) })
    }

    /// Writes a picture, and what it was made of, if that is given.
    ///
    /// # Errors
    /// If the file cannot be written, or the picture has no pixels.
    pub fn write(
        self,
        path: impl AsRef<Path>,
        image: &Image,
        provenance: Option<&Provenance>,
    ) -> Result<(), IoError> {
        let provenance = provenance.unwrap_or(&Provenance::NONE);
        atomic::write(path.as_ref(), |file| self.encode(file, image, provenance))
    }

    /// What [`write`](Self::write) would write.
    ///
    /// # Errors
    /// If the picture has no pixels.
    pub fn bytes(self, image: &Image, provenance: Option<&Provenance>) -> Result<Vec<u8>, IoError> {
        let provenance = provenance.unwrap_or(&Provenance::NONE);
        let mut bytes = Cursor::new(Vec::new());
        let encoded = self.encode(&mut bytes, image, provenance);
        encoded.map_err(|source| IoError::Encode { source })?;
        Ok(bytes.into_inner())
    }

    fn encode(
        self,
        writer: impl Write + Seek,
        image: &Image,
        provenance: &Provenance,
    ) -> std::io::Result<()> {
        match self {
            Self::Png => png::encode(writer, image, provenance),
            #[cfg(feature = "exr")]
            Self::Exr => exr::encode(writer, image, provenance),
            Self::Tiff => tiff::encode_16_bits(writer, image, provenance),
            Self::TiffFloat => tiff::encode_floats(writer, image, provenance),
            Self::Jpeg => jpeg::encode(writer, image, provenance),
            #[cfg(feature = "webp")]
            Self::WebP => webp::encode(writer, image, provenance),
        }
    }

    /// What a picture in this format says that it was made of.
    ///
    /// # Errors
    /// If it cannot be read, or is none.
    pub(super) fn read_provenance(
        self,
        store: Store<'_>,
        path: &Path,
    ) -> Result<Provenance, IoError> {
        let file = BufReader::new(store.open(path)?);
        let read = match self {
            Self::Png => png::read_provenance(file),
            #[cfg(feature = "exr")]
            Self::Exr => exr::read_provenance(file),
            Self::Tiff | Self::TiffFloat => tiff::read_provenance(file),
            Self::Jpeg => jpeg::read_provenance(file),
            #[cfg(feature = "webp")]
            Self::WebP => webp::read_provenance(file),
        };
        read.map_err(|what| {
            let name = self.name().to_uppercase();
            IoError::malformed(path, format!("not a picture in {name} that can be read: {what}"))
        })
    }
}

/// Whether anything shines through a scene's background. One that is found is opaque.
fn is_transparent(scene: &SceneFile) -> bool {
    let above = scene.image.background;
    let below = scene.finish.background_below.unwrap_or(above);
    !scene.unsaid.background && above[3].min(below[3]) < 1.0
}
