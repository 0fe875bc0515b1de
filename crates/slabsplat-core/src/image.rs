//! The picture: premultiplied RGBA in 32-bit floats.

use std::fmt;
use thiserror::Error;

/// Size and background of a picture.
///
/// ```
/// use slabsplat_core::ImageDesc;
///
/// let on_white = ImageDesc::new(640, 480).background([1.0; 4]);
/// assert_eq!((on_white.width, on_white.n_pixels()), (640, 307_200));
/// assert_eq!(on_white.size(64, 48).background, [1.0; 4]);
/// assert_eq!(ImageDesc::default(), ImageDesc::new(512, 512), "transparent");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct ImageDesc {
    /// Pixels in a row, 1 … 32768.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue and opacity behind the volume, 0 … 1, not premultiplied.
    pub background: [f32; 4],
}

/// A picture of premultiplied RGBA, row 0 at the top.
#[derive(Clone, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 4]>,
}

impl fmt::Debug for Image {
    /// Its size: thousands of pixels are for nobody to read.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, height, .. } = self;
        f.debug_struct("Image")
            .field("width", width)
            .field("height", height)
            .finish_non_exhaustive()
    }
}

/// Why a picture cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ImageError {
    /// A side is 0 or too long, or there are too many pixels.
    #[error(
        "an image of {width} x {height} pixels cannot be made: sides are 1 to {MAX_SIDE}, and there \
         are at most {MAX_PIXELS} pixels"
    )]
    BadSize {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A background channel is outside 0 … 1.
    #[error("the background must be four numbers from 0 to 1, not {0:?}")]
    BadBackground([f32; 4]),
}

impl ImageError {
    /// The name of the field of [`ImageDesc`] that a person should look at.
    pub fn field(&self) -> &'static str {
        match self {
            Self::BadSize { .. } => "width",
            Self::BadBackground(_) => "background",
        }
    }
}

/// Longest side of a picture in pixels.
const MAX_SIDE: u32 = 32768;

/// Most pixels of a picture: 2 GiB, of which rendering and writing take some copies.
const MAX_PIXELS: usize = 1 << 27;

impl Default for ImageDesc {
    fn default() -> Self {
        Self::new(512, 512)
    }
}

impl ImageDesc {
    /// A picture so many pixels wide and high, transparent behind the volume.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height, background: [0.0; 4] }
    }

    /// The same, so many pixels wide and high.
    #[must_use]
    pub const fn size(self, width: u32, height: u32) -> Self {
        Self { width, height, ..self }
    }

    /// The same before another background: red, green, blue and opacity, 0 … 1, not premultiplied.
    #[must_use]
    pub const fn background(self, background: [f32; 4]) -> Self {
        Self { background, ..self }
    }

    /// The background as a premultiplied pixel.
    pub fn premultiplied_background(&self) -> [f32; 4] {
        let [r, g, b, a] = self.background;
        [r * a, g * a, b * a, a]
    }

    /// The same, if such a picture can be made.
    ///
    /// # Errors
    /// If a side is 0 or over 32768, there are more than 2²⁷ pixels, or a background channel is outside 0 …
    /// 1.
    pub fn checked(self) -> Result<Self, ImageError> {
        let Self { width, height, background } = self;
        let is_side = |side: u32| (1..=MAX_SIDE).contains(&side);
        if !is_side(width) || !is_side(height) || MAX_PIXELS < self.n_pixels() {
            return Err(ImageError::BadSize { width, height });
        }
        if background.iter().any(|c| !(0.0..=1.0).contains(c)) {
            return Err(ImageError::BadBackground(background));
        }
        Ok(self)
    }

    /// Number of pixels.
    pub fn n_pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// A premultiplied colour before another one, `behind`.
#[inline]
pub fn over(front: [f32; 4], behind: [f32; 4]) -> [f32; 4] {
    let through = 1.0 - front[3];
    std::array::from_fn(|channel| front[channel] + through * behind[channel])
}

impl Image {
    /// A picture of one colour, premultiplied.
    pub fn filled(width: u32, height: u32, pixel: [f32; 4]) -> Self {
        Self { width, height, pixels: vec![pixel; width as usize * height as usize] }
    }

    /// A picture of these pixels, premultiplied, row by row from the top.
    ///
    /// ```
    /// let image = slabsplat_core::Image::from_pixels(2, 1, vec![[0.0; 4], [1.0; 4]]);
    /// assert_eq!(image.pixel(1, 0), [1.0; 4]);
    /// assert_eq!(format!("{image:?}"), "Image { width: 2, height: 1, .. }");
    /// ```
    ///
    /// # Panics
    /// If there are not `width * height` of them.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[f32; 4]>) -> Self {
        assert_eq!(pixels.len(), width as usize * height as usize, "as many pixels as there are");
        Self { width, height, pixels }
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// All pixels, to be written.
    pub fn pixels_mut(&mut self) -> &mut [[f32; 4]] {
        &mut self.pixels
    }

    /// The picture as most programs take it: 8 bits of red, green, blue and opacity a pixel, not
    /// premultiplied, row by row from the top. What is outside 0 … 1 is clamped, NaN is 0, and a pixel whose
    /// opacity rounds to 0 is all 0, as its colour is nobody's.
    pub fn to_rgba8(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|&pixel| straight(pixel)).collect()
    }

    /// The same in 16 bits a channel: straight, clamped, and all 0 where opacity rounds to 0.
    pub fn to_rgba16(&self) -> Vec<u16> {
        let full = f32::from(u16::MAX);
        let to_word = |value: f32| (value.clamp(0.0, 1.0) * full).round() as u16;
        let straight = |&[r, g, b, a]: &[f32; 4]| match to_word(a) {
            0 => [0; 4],
            alpha => [to_word(r / a), to_word(g / a), to_word(b / a), alpha],
        };
        self.pixels.iter().flat_map(straight).collect()
    }

    /// The same as an image of the crate `image`.
    ///
    /// # Panics
    /// If the picture has more pixels than memory.
    #[cfg(feature = "image")]
    pub fn to_rgba_image(&self) -> image::RgbaImage {
        image::RgbaImage::from_raw(self.width, self.height, self.to_rgba8())
            .expect("there are four bytes a pixel")
    }

    /// The pixel in column `x` of row `y`.
    ///
    /// # Panics
    /// If it is outside the picture.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        assert!(x < self.width && y < self.height, "pixel ({x}, {y}) is outside the image");
        self.pixels[y as usize * self.width as usize + x as usize]
    }
}

/// A premultiplied pixel as 8 bits of straight colour and opacity.
fn straight([r, g, b, a]: [f32; 4]) -> [u8; 4] {
    // NaN becomes 0 in the cast.
    let to_byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    match to_byte(a) {
        0 => [0; 4],
        alpha => [to_byte(r / a), to_byte(g / a), to_byte(b / a), alpha],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_bytes_are_straight() {
        let check = |pixel, expected| assert_eq!(straight(pixel), expected, "{pixel:?}");
        check([0.0; 4], [0; 4]);
        check([1.0; 4], [255; 4]);
        check([0.25, 0.1, 0.0, 0.5], [128, 51, 0, 128]);
        check([0.001, 0.0, 0.0, 0.001], [0; 4]);
        check([2.0, -1.0, 0.5, 1.5], [255, 0, 85, 255]);
        check([f32::NAN, 0.5, 0.5, 1.0], [0, 128, 128, 255]);
        check([0.5, 0.5, 0.5, f32::NAN], [0; 4]);
        let mut image = Image::filled(2, 1, [0.0; 4]);
        image.pixels_mut()[1] = [0.5, 0.0, 0.0, 0.5];
        assert_eq!(image.to_rgba8(), [0, 0, 0, 0, 255, 0, 0, 128]);
        assert_eq!(image.to_rgba16(), [0, 0, 0, 0, 65535, 0, 0, 32768]);
    }

    #[cfg(feature = "image")]
    #[test]
    fn image_becomes_one_of_the_crate_image() {
        let mut image = Image::filled(3, 2, [0.2, 0.4, 0.6, 1.0]);
        image.pixels_mut()[4] = [0.0, 0.0, 0.2, 0.4];
        let rgba = image.to_rgba_image();
        assert_eq!(rgba.dimensions(), (3, 2));
        assert_eq!(rgba.get_pixel(2, 0).0, [51, 102, 153, 255]);
        assert_eq!(rgba.get_pixel(1, 1).0, [0, 0, 128, 102]);
    }

    #[test]
    fn image_over_is_what_shines_through() {
        assert_eq!(over([0.25, 0.0, 0.0, 0.5], [0.5, 0.5, 0.0, 0.5]), [0.5, 0.25, 0.0, 0.75]);
    }

    #[test]
    fn image_background_is_premultiplied() {
        let desc = ImageDesc::default().background([1.0, 0.5, 0.25, 0.5]);
        assert_eq!(desc.premultiplied_background(), [0.5, 0.25, 0.125, 0.5]);
    }

    #[test]
    fn image_pixels_stand_row_by_row() {
        let mut image = Image::filled(3, 2, [0.0; 4]);
        assert_eq!((image.width(), image.height(), image.pixels().len()), (3, 2, 6));
        for (idx, pixel) in image.pixels_mut().iter_mut().enumerate() {
            *pixel = [idx as f32; 4];
        }
        let rows = [0, 1].map(|y| [0, 1, 2].map(|x| image.pixel(x, y)[0]));
        assert_eq!(rows, [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
        assert_eq!(image.pixels()[4], image.pixel(1, 1));
    }

    #[test]
    fn image_desc_rejects_bad_sizes() {
        assert!(ImageDesc::default().checked().is_ok());
        assert!(ImageDesc { width: 0, ..ImageDesc::default() }.checked().is_err());
        assert!(
            ImageDesc { width: 32768, height: 32768, ..ImageDesc::default() }.checked().is_err()
        );
        assert!(ImageDesc { width: 32768, height: 4096, ..ImageDesc::default() }.checked().is_ok());
        assert!(ImageDesc { height: 1 << 20, ..ImageDesc::default() }.checked().is_err());
        assert!(
            ImageDesc { background: [0.0, 2.0, 0.0, 0.0], ..ImageDesc::default() }
                .checked()
                .is_err()
        );
    }
}
