//! What films and their frames say of themselves. Whoever renders knows what that is; here is where each
//! format has room for it.

use slabsplat_core::Image;

/// What a file says of itself, beside its pixels.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Metadata {
    /// Keywords and texts, for animated PNGs and for frames in a folder.
    pub png_texts: Vec<(String, String)>,
    /// A packet of XMP, for WebP.
    pub xmp: Option<String>,
}

/// A frame, and what its file says of itself where every frame has one.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FilmFrame {
    /// What is seen.
    pub image: Image,
    /// What is said; an empty one is nothing.
    pub metadata: Metadata,
}

impl Metadata {
    /// Those texts for PNG and that packet of XMP.
    pub fn new(png_texts: impl IntoIterator<Item = (String, String)>, xmp: Option<String>) -> Self {
        Self { png_texts: png_texts.into_iter().collect(), xmp }
    }
}

impl FilmFrame {
    /// The same, whose file says that.
    #[must_use]
    pub fn metadata(self, metadata: Metadata) -> Self {
        Self { metadata, ..self }
    }
}

impl From<Image> for FilmFrame {
    fn from(image: Image) -> Self {
        Self { image, metadata: Metadata::default() }
    }
}
