//! Two-dimensional transfer functions as pictures (model §6).

use crate::IsoRange;
use crate::transfer_2d::{Transfer2dError, check_share};
use std::sync::Arc;

/// A picture of opacities and colours: values run from its left edge to its right one, gradients from its
/// lower edge to its upper one. It is interpolated between the centres of its pixels and constant beyond
/// them. A copy shares the pixels.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(
    feature = "serde",
    serde(
        try_from = "crate::serialized::TransferImageKeys",
        into = "crate::serialized::TransferImageKeys"
    )
)]
pub struct TransferImage {
    width: usize,
    height: usize,
    values: [f64; 2],
    gradients: [f64; 2],
    /// Red, green, blue, not premultiplied, and opacity; the top row first.
    pixels: Arc<[[f32; 4]]>,
}

impl TransferImage {
    /// `width` pixels a row, as many rows as there are pixels for, the top one first: red, green, blue, not
    /// premultiplied, and opacity per `unit`, 0 … 1 each. `values` and `gradients` are those of its edges.
    ///
    /// # Errors
    /// If there are no pixels, or no whole rows, or a channel is not within 0 to 1; if the first of a pair is
    /// not below the second, or either is not finite.
    pub fn new(
        width: usize,
        pixels: Vec<[f32; 4]>,
        values: [f64; 2],
        gradients: [f64; 2],
    ) -> Result<Self, Transfer2dError> {
        let n_pixels = pixels.len();
        let height = n_pixels.checked_div(width).unwrap_or(0);
        if n_pixels == 0 || width * height != n_pixels {
            return Err(Transfer2dError::BadSize { width, height, n_pixels });
        }
        for (what, ends) in [("values", values), ("gradients", gradients)] {
            let extent = 0.5 * ends[1] - 0.5 * ends[0];
            if !(0.0 < extent && extent.is_finite()) {
                return Err(Transfer2dError::NoExtent { what, ends });
            }
        }
        for &[r, g, b, opacity] in &pixels {
            [r, g, b]
                .into_iter()
                .try_for_each(|channel| check_share("the colour", channel.into()))?;
            check_share("the opacity", opacity.into())?;
        }
        Ok(Self { width, height, values, gradients, pixels: pixels.into() })
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The values at its left and its right edge.
    pub fn values(&self) -> [f64; 2] {
        self.values
    }

    /// The gradients at its lower and its upper edge.
    pub fn gradients(&self) -> [f64; 2] {
        self.gradients
    }

    /// All pixels, the top row first: red, green, blue, not premultiplied, and opacity.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// Opacity, and the colour of the pixels around, each counted by its opacity.
    pub(crate) fn at(&self, value: f64, gradient: f64) -> (f64, [f64; 3]) {
        let (x, right) = pixel_and_part(value, self.values, self.width);
        let (from_below, up) = pixel_and_part(gradient, self.gradients, self.height);
        let mut opacity = 0.0;
        let mut weighted = [0.0; 3];
        for (y, of_row) in [(from_below, 1.0 - up), (from_below + 1, up)] {
            for (x, of_column) in [(x, 1.0 - right), (x + 1, right)] {
                let of_pixel = of_row * of_column;
                if of_pixel <= 0.0 {
                    continue;
                }
                let [r, g, b, alpha] =
                    self.pixels[(self.height - 1 - y) * self.width + x].map(f64::from);
                opacity += of_pixel * alpha;
                for (sum, channel) in weighted.iter_mut().zip([r, g, b]) {
                    *sum += of_pixel * alpha * channel;
                }
            }
        }
        if opacity <= 0.0 {
            return (0.0, [0.0; 3]);
        }
        (opacity.min(1.0), weighted.map(|sum| (sum / opacity).min(1.0)))
    }

    /// As [`TransferFunction2d::iso_ranges`](crate::TransferFunction2d::iso_ranges).
    pub(crate) fn iso_ranges(&self) -> Vec<IsoRange> {
        let is_visible = |&x: &usize| {
            let mut column = self.pixels.iter().skip(x).step_by(self.width);
            column.any(|&[.., opacity]| 0.0 < opacity)
        };
        IsoRange::union((0..self.width).filter(is_visible).map(|x| self.values_around(x)))
    }

    /// The values that a column of pixels has a part in, and no fewer for rounding.
    fn values_around(&self, x: usize) -> IsoRange {
        let [first, last] = self.values;
        let center =
            |pixels: f64| first + (last / self.width as f64 - first / self.width as f64) * pixels;
        let is_last = x + 1 == self.width;
        IsoRange {
            lo: if x == 0 { f64::NEG_INFINITY } else { center(x as f64 - 0.5 - 1e-6) },
            hi: if is_last { f64::INFINITY } else { center(x as f64 + 1.5 + 1e-6) },
        }
    }

    /// All numbers that it is made of.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let ends = [self.values, self.gradients].into_iter().flatten();
        let pixels = self.pixels.iter().flatten().map(|&channel| f64::from(channel));
        [self.width as f64].into_iter().chain(ends).chain(pixels)
    }
}

impl PartialEq for TransferImage {
    /// Pixels are compared one by one only if they are not the same ones.
    fn eq(&self, other: &Self) -> bool {
        let Self { width, height, values, gradients, pixels } = other;
        [self.width, self.height] == [*width, *height]
            && [self.values, self.gradients] == [*values, *gradients]
            && (Arc::ptr_eq(&self.pixels, pixels) || self.pixels == *pixels)
    }
}

/// The pixel whose centre is at or before a number, and how far that lies behind it, 0 … 1, on the way to the
/// next one; 0 where there is none.
fn pixel_and_part(number: f64, [first, last]: [f64; 2], n_pixels: usize) -> (usize, f64) {
    let share = (0.5 * number - 0.5 * first) / (0.5 * last - 0.5 * first);
    let centers = (share * n_pixels as f64 - 0.5).clamp(0.0, (n_pixels - 1) as f64);
    (centers as usize, centers.fract())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TransferFunction2d;

    const CLEAR: [f32; 4] = [0.0; 4];
    const RED: [f32; 4] = [1.0, 0.0, 0.0, 0.5];
    const BLUE: [f32; 4] = [0.0, 0.0, 1.0, 1.0];

    /// Values 0 … 40 in four columns, gradients 0 … 20 in two rows.
    fn image() -> TransferFunction2d {
        let pixels = vec![CLEAR, CLEAR, BLUE, CLEAR, CLEAR, RED, BLUE, CLEAR];
        TransferFunction2d::Image(TransferImage::new(4, pixels, [0.0, 40.0], [0.0, 20.0]).unwrap())
    }

    #[test]
    fn transfer_image_is_interpolated_between_pixels() {
        let image = image();
        assert_eq!(image.at(15.0, 5.0), (0.5, [1.0, 0.0, 0.0]));
        assert_eq!(image.at(25.0, 15.0), (1.0, [0.0, 0.0, 1.0]));
        // Half way to what is invisible: its colour does not count.
        assert_eq!(image.at(15.0, 10.0), (0.25, [1.0, 0.0, 0.0]));
        // Half way to a colour that is twice as opaque.
        let (opacity, color) = image.at(20.0, 5.0);
        assert!((opacity - 0.75).abs() < 1e-12);
        assert!((color[0] - 1.0 / 3.0).abs() < 1e-12 && (color[2] - 2.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn transfer_image_is_constant_beyond_its_ends() {
        let pixels = vec![RED, BLUE];
        let image = TransferImage::new(2, pixels, [0.0, 2.0], [0.0, 1.0]).unwrap();
        assert_eq!(image.at(f64::NEG_INFINITY, 0.0), (0.5, [1.0, 0.0, 0.0]));
        assert_eq!(image.at(0.25, f64::INFINITY), (0.5, [1.0, 0.0, 0.0]));
        assert_eq!(image.at(f64::INFINITY, 9.0), (1.0, [0.0, 0.0, 1.0]));
        let all = [IsoRange { lo: f64::NEG_INFINITY, hi: f64::INFINITY }];
        assert_eq!(image.iso_ranges(), all);
    }

    /// The ranges hold every visible value, and little else.
    #[test]
    fn transfer_image_ranges_hold_what_is_visible() {
        let image = image();
        let ranges = image.iso_ranges();
        for step in -100..=500 {
            let value = f64::from(step) * 0.1;
            let is_visible =
                [0.0, 5.0, 15.0, 20.0].into_iter().any(|g| 0.0 < image.opacity(value, g));
            let is_in = ranges.iter().any(|range| range.lo <= value && value <= range.hi);
            assert!(is_in || !is_visible, "{value} is in none of {ranges:?}");
        }
        assert_eq!(ranges.len(), 1);
        assert!(
            (ranges[0].lo - 5.0).abs() < 1e-3 && (ranges[0].hi - 35.0).abs() < 1e-3,
            "{ranges:?}"
        );
    }

    #[test]
    fn transfer_image_errors_name_what_is_wrong() {
        let check = |width, pixels: &[[f32; 4]], values, expected: &str| {
            let made = TransferImage::new(width, pixels.to_vec(), values, [0.0, 1.0]);
            let error = made.unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        check(0, &[], [0.0, 1.0], "0 x 0 pixels");
        check(2, &[RED; 3], [0.0, 1.0], "2 x 1 pixels cannot have 3");
        check(1, &[RED], [1.0, 1.0], "the values of a picture need");
        check(1, &[RED], [0.0, f64::INFINITY], "finite end, not 0 and inf");
        check(1, &[[0.0, 0.0, 0.0, 2.0]], [0.0, 1.0], "the opacity of a transfer function");
        check(1, &[[0.0, f32::NAN, 0.0, 1.0]], [0.0, 1.0], "the colour of a transfer function");
    }
}
