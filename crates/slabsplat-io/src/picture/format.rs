//! The formats of pictures, each with room for what the picture was made of.

use std::io::{BufReader, Cursor, Seek, Write};
use std::path::Path;

use slabsplat_core::Image;

use super::{Provenance, atomic, exr, png};
use crate::IoError;
use crate::store::Store;

/// How a picture is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PictureFormat {
    /// 8 bits a channel, not premultiplied.
    Png,
    /// OpenEXR: 32-bit floats, premultiplied, bit by bit what was drawn.
    Exr,
}

impl PictureFormat {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Png, Self::Exr];

    /// The format's name, which is the extension of its files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }

    /// The format that a name's extension says; `None` if it says none of these.
    pub fn of_name(path: impl AsRef<Path>) -> Option<Self> {
        let extension = path.as_ref().extension()?;
        let is_its = |format: &&Self| extension.eq_ignore_ascii_case(format.name());
        Self::ALL.iter().find(is_its).copied()
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
            Self::Exr => exr::encode(writer, image, provenance),
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
            Self::Exr => exr::read_provenance(file),
        };
        read.map_err(|what| {
            let name = self.name().to_uppercase();
            IoError::malformed(path, format!("not a picture in {name} that can be read: {what}"))
        })
    }
}
