//! What a film is stored as.

use crate::encode::check_ffmpeg;
use crate::{FilmDesc, FilmError};
use std::path::Path;

/// A format of films.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FilmFormat {
    /// H.264 in MP4, which every player shows; made by the program ffmpeg.
    Mp4,
    /// VP9 in WebM, for browsers; made by ffmpeg.
    WebM,
    /// 255 colours, the same for all frames.
    Gif,
    /// Lossless WebP, with opacity.
    WebP,
    /// Animated PNG: lossless, with opacity.
    Apng,
    /// A folder with a PNG for each frame.
    PngSequence,
}

impl FilmFormat {
    /// All of them.
    pub const ALL: &[Self] =
        &[Self::Mp4, Self::WebM, Self::Gif, Self::WebP, Self::Apng, Self::PngSequence];

    /// The format's name, which is the extension of its files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mp4 => "mp4",
            Self::WebM => "webm",
            Self::Gif => "gif",
            Self::WebP => "webp",
            Self::Apng => "apng",
            Self::PngSequence => "png-sequence",
        }
    }

    /// How frames are stored, as people call it.
    pub fn codec(self) -> &'static str {
        match self {
            Self::Mp4 => "h264",
            Self::WebM => "vp9",
            Self::Gif => "gif",
            Self::WebP => "webp-lossless",
            Self::Apng | Self::PngSequence => "png",
        }
    }

    /// The format that a name's extension says; `None` if it says none of these.
    pub fn of_name(path: impl AsRef<Path>) -> Option<Self> {
        let extension = path.as_ref().extension()?;
        Self::ALL.iter().find(|it| extension.eq_ignore_ascii_case(it.name())).copied()
    }

    /// Whether the program ffmpeg makes it.
    pub fn needs_ffmpeg(self) -> bool {
        matches!(self, Self::Mp4 | Self::WebM)
    }

    /// That the program which makes it is there, if one does.
    ///
    /// # Errors
    /// If it is not, or cannot be started.
    pub fn check_program(self) -> Result<(), FilmError> {
        check_ffmpeg(self)
    }

    /// Whether something may shine through its frames.
    pub fn has_opacity(self) -> bool {
        matches!(self, Self::WebP | Self::Apng | Self::PngSequence)
    }

    /// The longest side of a frame, in pixels.
    fn max_side(self) -> u32 {
        match self {
            // WebP has 14 bits for a side, as has what H.264 and VP9 are usually decoded by.
            Self::WebP | Self::Mp4 | Self::WebM => 1 << 14,
            Self::Gif => u16::MAX.into(),
            Self::Apng | Self::PngSequence => i32::MAX as u32,
        }
    }

    /// Width and height of the film in pixels. Those of MP4 and WebM are even: of an odd side the last row or
    /// column is there twice.
    pub fn size(self, desc: &FilmDesc) -> [u32; 2] {
        let size = [desc.width, desc.height];
        if self.needs_ffmpeg() { size.map(|side| side.next_multiple_of(2)) } else { size }
    }

    /// That the format has room for such a film.
    ///
    /// # Errors
    /// If its frames are too large or too fast.
    pub fn check(self, desc: &FilmDesc) -> Result<(), FilmError> {
        let max_side = self.max_side();
        if max_side < desc.width.max(desc.height) {
            let (name, FilmDesc { width, height, .. }) = (self.name(), *desc);
            return Err(FilmError::TooLarge { name, width, height, max_side });
        }
        // What is seen for less than 2/100 s browsers show for 10/100.
        if self == Self::Gif && 50.0 < desc.rate.per_second() {
            return Err(FilmError::TooFast { name: self.name(), max: 50.0 });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FrameRate;

    #[test]
    fn film_format_by_extension() {
        for format in FilmFormat::ALL {
            assert_eq!(FilmFormat::of_name(format!("a.{}", format.name())), Some(*format));
        }
        assert_eq!(FilmFormat::of_name("A.GIF"), Some(FilmFormat::Gif));
        assert_eq!(FilmFormat::of_name("a.png"), None);
        assert_eq!(FilmFormat::of_name("gif"), None);
    }

    #[test]
    fn film_format_has_limits() {
        let desc = |width, rate| FilmDesc::new(width, 1, 1, FrameRate::new(rate).unwrap()).unwrap();
        assert!(FilmFormat::WebP.check(&desc(1 << 14, 25.0)).is_ok());
        assert!(FilmFormat::WebP.check(&desc((1 << 14) + 1, 25.0)).is_err());
        assert!(FilmFormat::Gif.check(&desc(1, 50.0)).is_ok());
        assert!(FilmFormat::Gif.check(&desc(1, 60.0)).is_err());
        assert!(FilmFormat::Apng.check(&desc(1, 240.0)).is_ok());
    }
}
