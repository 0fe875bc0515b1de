//! By how much pictures differ: every figure of that kind in slabsplat comes from here.
//!
//! Differences are those of premultiplied channels, from 0 to 1. A channel that is NaN in one picture and not
//! in the other differs infinitely, so that no figure passes over it; NaN and NaN are equal.

use crate::Image;

/// By how much a picture differs from another one, its reference.
///
/// ```
/// use slabsplat_core::{Image, ImageDifference};
///
/// let black = Image::filled(2, 1, [0.0, 0.0, 0.0, 1.0]);
/// let mut picture = black.clone();
/// picture.pixels_mut()[0][1] = 0.6;
/// let ImageDifference { largest, mean, psnr_db, .. } = ImageDifference::between(&picture, &black);
/// assert_eq!(largest, 0.6);
/// assert!((mean - 0.6 / 8.0).abs() < 1e-7);
/// assert!((psnr_db - 10.0 * (6.0_f64 / 0.36).log10()).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ImageDifference {
    /// The largest difference of a premultiplied channel, opacity included, as a tolerance counts.
    pub largest: f32,
    /// The mean difference of all four premultiplied channels.
    pub mean: f64,
    /// The peak signal-to-noise ratio in decibels, `10·log₁₀(1/MSE)`, of red, green and blue as on black:
    /// what other programs compute from an opaque picture. Infinite if these do not differ.
    pub psnr_db: f64,
}

impl ImageDifference {
    /// By how much `image` differs from `reference`.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn between(image: &Image, reference: &Image) -> Self {
        Self {
            largest: image.max_difference(reference),
            mean: image.mean_difference(reference),
            psnr_db: -10.0 * image.mean_squared_color_difference(reference).log10(),
        }
    }
}

impl Image {
    /// The largest difference of any channel from `other`.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn max_difference(&self, other: &Self) -> f32 {
        self.differences::<4>(other).fold(0.0, f32::max)
    }

    /// The largest difference of red, green or blue from `other`, as on black: where an edge passes, opacity
    /// may change from all to nothing, which nobody sees.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn max_color_difference(&self, other: &Self) -> f32 {
        self.differences::<3>(other).fold(0.0, f32::max)
    }

    /// The mean difference of all channels from `other`.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn mean_difference(&self, other: &Self) -> f64 {
        let sum: f64 = self.differences::<4>(other).map(f64::from).sum();
        sum / (4 * self.pixels().len()) as f64
    }

    /// The mean second difference of all channels, `|self − 2·before + before_that|`: how far this image is
    /// from where an even change from `before_that` to `before` leads.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn mean_second_difference(&self, before: &Self, before_that: &Self) -> f64 {
        self.check_size(before);
        self.check_size(before_that);
        let [a, b, c] = [self, before, before_that].map(|image| image.pixels().as_flattened());
        let triples = a.iter().zip(b).zip(c).map(|((a, b), c)| [a, b, c].map(|&v| f64::from(v)));
        let sum: f64 = triples.map(|[a, b, c]| (a - 2.0 * b + c).abs()).sum();
        sum / (4 * self.pixels().len()) as f64
    }

    fn mean_squared_color_difference(&self, other: &Self) -> f64 {
        let sum: f64 = self.differences::<3>(other).map(|d| f64::from(d).powi(2)).sum();
        sum / (3 * self.pixels().len()) as f64
    }

    /// Of the first `N` channels of every pixel.
    fn differences<'a, const N: usize>(
        &'a self,
        other: &'a Self,
    ) -> impl Iterator<Item = f32> + 'a {
        self.check_size(other);
        let channels = |image: &'a Self| image.pixels().iter().flat_map(|pixel| &pixel[..N]);
        channels(self).zip(channels(other)).map(|(&a, &b)| difference(a, b))
    }

    fn check_size(&self, other: &Self) {
        let sizes = [self, other].map(|image| (image.width(), image.height()));
        assert_eq!(sizes[0], sizes[1], "images of different size cannot be compared");
    }
}

fn difference(a: f32, b: f32) -> f32 {
    let difference = (a - b).abs();
    match (difference.is_nan(), a.is_nan() && b.is_nan()) {
        (false, _) => difference,
        (true, true) => 0.0,
        // The same infinity is the same picture.
        (true, false) if a == b => 0.0,
        (true, false) => f32::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_differences() {
        let a = Image::filled(2, 1, [1.0; 4]);
        let mut b = a.clone();
        b.pixels_mut()[1][2] = 0.5;
        assert_eq!(a.max_difference(&b), 0.5);
        assert_eq!(a.mean_difference(&b), 0.0625);
        assert_eq!(a.mean_second_difference(&b, &a), 0.125, "there and back");
        let mut c = a.clone();
        c.pixels_mut()[1][2] = 0.0;
        assert_eq!(c.mean_second_difference(&b, &a), 0.0, "it falls evenly");
    }

    #[test]
    fn image_difference_by_hand() {
        let reference = Image::filled(2, 2, [0.25, 0.5, 0.75, 1.0]);
        let mut image = reference.clone();
        // Squares of 0.01 and 0.04 over twelve colour channels: 10·log10(240).
        image.pixels_mut()[0][0] += 0.1;
        image.pixels_mut()[3][2] -= 0.2;
        let found = ImageDifference::between(&image, &reference);
        assert!((found.largest - 0.2).abs() < 1e-6, "{found:?}");
        assert!((found.mean - 0.3 / 16.0).abs() < 1e-7, "{found:?}");
        assert!((found.psnr_db - 23.802).abs() < 1e-3, "{found:?}");
        let same = ImageDifference::between(&image, &image);
        assert_eq!(same, ImageDifference { largest: 0.0, mean: 0.0, psnr_db: f64::INFINITY });
    }

    #[test]
    fn image_difference_in_opacity_alone() {
        let [clear, black] =
            [0.0, 0.5].map(|opacity| Image::filled(3, 1, [0.0, 0.0, 0.0, opacity]));
        assert_eq!(clear.max_color_difference(&black), 0.0, "on black nobody sees it");
        let found = ImageDifference::between(&clear, &black);
        let expected = ImageDifference { largest: 0.5, mean: 0.125, psnr_db: f64::INFINITY };
        assert_eq!(found, expected);
    }

    /// A picture that is nowhere a number is not a good copy of one that is.
    #[test]
    fn image_difference_of_what_is_no_number() {
        let check =
            |a: f32, b: f32, expected: f32| assert_eq!(difference(a, b), expected, "{a} {b}");
        check(f32::NAN, 0.5, f32::INFINITY);
        check(0.5, f32::NAN, f32::INFINITY);
        check(f32::INFINITY, f32::NAN, f32::INFINITY);
        check(f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY);
        check(f32::INFINITY, f32::INFINITY, 0.0);
        check(f32::NAN, -f32::NAN, 0.0);
        let [number, none] = [0.5, f32::NAN].map(|value| Image::filled(1, 1, [value; 4]));
        let found = ImageDifference::between(&none, &number);
        assert_eq!((found.largest, found.mean), (f32::INFINITY, f64::INFINITY));
        assert_eq!(found.psnr_db, f64::NEG_INFINITY);
    }
}
