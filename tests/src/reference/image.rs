//! The reference's picture, and how far another one is from it.

use slabsplat_core::Image;

/// A picture of premultiplied RGBA in 64-bit floats, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceImage {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// All pixels, row by row.
    pub pixels: Vec<[f64; 4]>,
}

/// How far two pictures are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The largest difference of any channel; infinite where one of the two is NaN.
    pub max: f64,
    /// The mean difference of all channels.
    pub mean: f64,
    /// Column and row of the pixel with the largest difference.
    pub worst_pixel: [u32; 2],
}

impl ReferenceImage {
    /// Takes over the pixels of a picture that depend on how planes, edges and crossings are rounded.
    #[must_use]
    pub fn leaving(mut self, undecided: &[bool], image: &Image) -> Self {
        for (idx, _) in undecided.iter().enumerate().filter(|(_, is_undecided)| **is_undecided) {
            self.pixels[idx] = image.pixels()[idx].map(f64::from);
        }
        self
    }

    /// The pixel in column `x` of row `y`.
    pub fn pixel(&self, x: u32, y: u32) -> [f64; 4] {
        self.pixels[(y * self.width + x) as usize]
    }

    /// How far `image` is from this one.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn compare(&self, image: &Image) -> Difference {
        let size = (image.width(), image.height());
        let pixels: Vec<[f64; 4]> = image.pixels().iter().map(|p| p.map(f64::from)).collect();
        self.compare_reference(&Self { width: size.0, height: size.1, pixels })
    }

    /// How far another reference picture is from this one.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn compare_reference(&self, other: &Self) -> Difference {
        assert_eq!(
            (self.width, self.height),
            (other.width, other.height),
            "pictures of different size cannot be compared"
        );
        let mut difference = Difference { max: 0.0, mean: 0.0, worst_pixel: [0, 0] };
        let n_channels = 4 * self.pixels.len();
        for (pixel_idx, (a, b)) in self.pixels.iter().zip(&other.pixels).enumerate() {
            for (a, b) in a.iter().zip(b) {
                // NaN must not pass for agreement, which a plain `max` would let it.
                let error = Some((a - b).abs()).filter(|e| !e.is_nan()).unwrap_or(f64::INFINITY);
                difference.mean += error / n_channels as f64;
                if difference.max < error {
                    difference.max = error;
                    let pixel_idx = pixel_idx as u32;
                    difference.worst_pixel = [pixel_idx % self.width, pixel_idx / self.width];
                }
            }
        }
        difference
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compare_finds_the_worst_pixel() {
        let reference = ReferenceImage { width: 2, height: 2, pixels: vec![[0.25; 4]; 4] };
        let mut image = Image::filled(2, 2, [0.25; 4]);
        assert_eq!(reference.compare(&image).max, 0.0);
        image.pixels_mut()[3][1] = 0.75;
        let expected = Difference { max: 0.5, mean: 0.5 / 16.0, worst_pixel: [1, 1] };
        assert_eq!(reference.compare(&image), expected);
        image.pixels_mut()[2][0] = f32::NAN;
        assert_eq!(reference.compare(&image).max, f64::INFINITY);
    }
}
