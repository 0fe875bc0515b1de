//! What becomes of a frame before it is a picture: samples are averaged, a gradient goes behind it, and what
//! people need to read it is drawn on it. No backend knows of it; the facade does it, after the frame.

use crate::ImageDesc;
use thiserror::Error;

/// What is done with a frame.
///
/// ```
/// use slabsplat_core::{Annotations, Finish};
///
/// let annotations = Annotations::default().title("a head").scale_bar();
/// let finish = Finish::default().samples(4).annotations(annotations).checked()?;
/// assert_eq!(finish.samples_side(), 2);
/// # Ok::<(), slabsplat_core::FinishError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Finish {
    /// Samples of a pixel, whose mean it is: a square, 1 … 64, as many of them in a row as in a column.
    pub samples: u32,
    /// Red, green, blue and opacity, 0 … 1, not premultiplied, to which the background goes over evenly from
    /// the upper edge, where it is that of [`ImageDesc`], to the lower one.
    pub background_below: Option<[f32; 4]>,
    /// What is drawn on it.
    pub annotations: Annotations,
}

/// What is drawn on a picture, so that people can tell how large, where and what it is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct Annotations {
    /// A line of text at the top, of 1 to 200 characters.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub title: Option<String>,
    /// The edges of the box around all that there is, behind it, with coordinates.
    pub axes: bool,
    /// A bar of a round length.
    pub scale_bar: bool,
    /// The colours of values.
    pub color_bar: bool,
    /// The directions of the world.
    pub orientation_marker: bool,
}

/// Why a frame cannot be finished like that.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FinishError {
    /// So many samples are in no square grid, or too many.
    #[error("samples of a pixel are 1, 4, 9, 16, 25, 36, 49 or 64, and not {0}")]
    BadSamples(u32),
    /// All samples together are more than a picture may have pixels.
    #[error(
        "{samples} samples for each of {width} x {height} pixels take {gigabytes:.1} GB, and sides of at most \
         32768 samples and 2.1 GB in all are possible: take fewer samples or pixels"
    )]
    TooManySamples {
        /// Of a pixel.
        samples: u32,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// What they would take.
        gigabytes: f64,
    },
    /// A channel of a gradient's lower end is outside 0 … 1.
    #[error("the background must be four numbers from 0 to 1, not {0:?}")]
    BadBackground([f32; 4]),
    /// The title has nothing that is seen.
    #[error("a title says something: leave it out for none")]
    EmptyTitle,
    /// The title has more characters than any picture is wide.
    #[error("a title has at most {MAX_TITLE_CHARS} characters, and this one has {0}")]
    LongTitle(usize),
    /// The title has several lines.
    #[error("a title is one line, and this one has a line break")]
    TitleOfLines,
    /// A character of the title is none that can be drawn.
    #[error("a title has no control characters, and this one has U+{:04X}", u32::from(*.0))]
    ControlInTitle(char),
}

/// Samples in a row of a pixel.
const MAX_SIDE: u32 = 8;

/// Characters of a title; no picture is wide enough for more.
const MAX_TITLE_CHARS: usize = 200;

impl Default for Finish {
    fn default() -> Self {
        Self { samples: 1, background_below: None, annotations: Annotations::default() }
    }
}

impl Finish {
    /// The same with so many samples of a pixel.
    #[must_use]
    pub fn samples(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    /// The same with a background that goes over to that colour at the lower edge.
    #[must_use]
    pub fn background_below(self, color: [f32; 4]) -> Self {
        Self { background_below: Some(color), ..self }
    }

    /// The same with these annotations.
    #[must_use]
    pub fn annotations(self, annotations: Annotations) -> Self {
        Self { annotations, ..self }
    }

    /// The same, if it can be done.
    ///
    /// # Errors
    /// If the number of samples is no square or above 64, a colour is outside 0 … 1, or the title is no line
    /// of 1 to 200 characters that says something.
    pub fn checked(self) -> Result<Self, FinishError> {
        if !(1..=MAX_SIDE).any(|side| side * side == self.samples) {
            return Err(FinishError::BadSamples(self.samples));
        }
        if let Some(color) = self.background_below
            && color.iter().any(|channel| !(0.0..=1.0).contains(channel))
        {
            return Err(FinishError::BadBackground(color));
        }
        self.annotations.title.as_deref().map_or(Ok(()), check_title)?;
        Ok(self)
    }

    /// Samples in a row of a pixel, and in a column.
    pub fn samples_side(&self) -> u32 {
        self.samples.isqrt().max(1)
    }

    /// The frame whose pixels are the samples of `image`'s.
    ///
    /// # Errors
    /// If a frame has no room for them all.
    pub fn sampled(&self, image: &ImageDesc) -> Result<ImageDesc, FinishError> {
        let ImageDesc { width, height, .. } = *image;
        let side = self.samples_side();
        let [wide, high] = [width, height].map(|n| n.saturating_mul(side));
        let sampled = image.size(wide, high);
        sampled.checked().map_err(|_| FinishError::TooManySamples {
            samples: self.samples,
            width,
            height,
            gigabytes: 16e-9 * f64::from(wide) * f64::from(high),
        })
    }
}

fn check_title(title: &str) -> Result<(), FinishError> {
    let n_chars = title.chars().count();
    if title.trim().is_empty() {
        return Err(FinishError::EmptyTitle);
    }
    if MAX_TITLE_CHARS < n_chars {
        return Err(FinishError::LongTitle(n_chars));
    }
    if title.contains(['\n', '\r', '\u{2028}', '\u{2029}']) {
        return Err(FinishError::TitleOfLines);
    }
    match title.chars().find(|c| c.is_control()) {
        Some(control) => Err(FinishError::ControlInTitle(control)),
        None => Ok(()),
    }
}

impl FinishError {
    /// The section of a scene file, and the key in it, that a person should look at.
    pub fn key(&self) -> [&'static str; 2] {
        match self {
            Self::BadSamples(_) | Self::TooManySamples { .. } => ["image", "samples"],
            Self::BadBackground(_) => ["image", "background_below"],
            Self::EmptyTitle
            | Self::LongTitle(_)
            | Self::TitleOfLines
            | Self::ControlInTitle(_) => ["annotations", "title"],
        }
    }
}

impl Annotations {
    /// The same with that title.
    #[must_use]
    pub fn title(self, title: impl Into<String>) -> Self {
        Self { title: Some(title.into()), ..self }
    }

    /// The same with axes.
    #[must_use]
    pub fn axes(self) -> Self {
        Self { axes: true, ..self }
    }

    /// The same with a bar of a round length.
    #[must_use]
    pub fn scale_bar(self) -> Self {
        Self { scale_bar: true, ..self }
    }

    /// The same with the colours of values.
    #[must_use]
    pub fn color_bar(self) -> Self {
        Self { color_bar: true, ..self }
    }

    /// The same with the directions of the world.
    #[must_use]
    pub fn orientation_marker(self) -> Self {
        Self { orientation_marker: true, ..self }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finish_checks_its_numbers() {
        for samples in [1, 4, 9, 64] {
            assert!(Finish { samples, ..Finish::default() }.checked().is_ok(), "{samples}");
        }
        for samples in [0, 2, 8, 65, 81, 100, u32::MAX] {
            let finish = Finish { samples, ..Finish::default() };
            assert_eq!(finish.checked(), Err(FinishError::BadSamples(samples)));
        }
        for color in [[0.0, 0.0, 0.0, 1.1], [f32::NAN, 0.0, 0.0, 0.0]] {
            let finish = Finish { background_below: Some(color), ..Finish::default() };
            assert!(matches!(finish.checked(), Err(FinishError::BadBackground(_))), "{color:?}");
        }
        let titled = |title: &str| {
            let annotations =
                Annotations { title: Some(title.to_owned()), ..Annotations::default() };
            Finish { annotations, ..Finish::default() }.checked()
        };
        assert!(titled(&"ä".repeat(200)).is_ok());
        for (title, expected) in [
            ("", "a title says something"),
            (" \u{a0} ", "a title says something"),
            ("a\nb", "a title is one line"),
            ("a\u{2028}b", "a title is one line"),
            ("\u{1b}[2J", "this one has U+001B"),
            ("a\tb", "this one has U+0009"),
            (&*"a".repeat(201), "at most 200 characters, and this one has 201"),
        ] {
            let error = titled(title).unwrap_err();
            assert!(error.to_string().contains(expected), "{title:?}: {error}");
            assert_eq!(error.key(), ["annotations", "title"]);
        }
    }

    #[test]
    fn finish_samples_are_a_larger_frame() {
        let image = ImageDesc::new(30, 20);
        let sampled = |samples, image| Finish { samples, ..Finish::default() }.sampled(image);
        assert_eq!(sampled(1, &image), Ok(image));
        assert_eq!(sampled(9, &image), Ok(image.size(90, 60)));
        let large = image.size(8000, 8000);
        let error = sampled(16, &large).unwrap_err();
        assert_eq!(error.key(), ["image", "samples"]);
        let expected = "16 samples for each of 8000 x 8000 pixels take 16.4 GB";
        assert!(error.to_string().starts_with(expected), "{error}");
        assert!(sampled(64, &image.size(4097, 1)).is_err(), "a long row");
    }
}
