//! Where two pictures differ, by how much, and in which direction.

use slabsplat_core::Image;

/// White where nothing differs, towards red where the picture is more and towards blue where it is less.
const MORE: [f32; 3] = [0.72, 0.03, 0.09];
const LESS: [f32; 3] = [0.03, 0.22, 0.62];

/// Beyond the ends of the scale, so that no size is hidden: magenta above and green below.
const BEYOND_MORE: [f32; 3] = [0.95, 0.0, 0.95];
const BEYOND_LESS: [f32; 3] = [0.0, 0.7, 0.3];

/// What is no number in one picture and not in the other.
const NOT_A_NUMBER: [f32; 3] = [0.0; 3];

/// By how much `image` differs from `reference`, times `gain`: of each pixel that premultiplied channel which
/// differs most, opacity included. White is no difference, red more and blue less, evenly up to `1/gain`;
/// beyond it is magenta and green, and black where one is no number.
///
/// # Panics
/// If the sizes differ.
pub fn difference_picture(image: &Image, reference: &Image, gain: f64) -> Image {
    let sizes = [image, reference].map(|image| (image.width(), image.height()));
    assert_eq!(sizes[0], sizes[1], "images of different size cannot be compared");
    let mut picture = image.clone();
    for (pixel, other) in picture.pixels_mut().iter_mut().zip(reference.pixels()) {
        let [r, g, b] = color(gain as f32 * largest(pixel, other));
        *pixel = [r, g, b, 1.0];
    }
    picture
}

/// The gain, one of 1, 2 or 5 times a power of ten or such a fraction, with which the largest difference of
/// some pictures just stays on the scale; 1 if nothing differs, or infinitely.
pub fn gain_for(largest: f64) -> f64 {
    if !(0.0 < largest && largest.is_finite()) {
        return 1.0;
    }
    let power = largest.log10().floor();
    let end = [1.0, 2.0, 5.0, 10.0].map(|step| step * 10_f64.powf(power));
    // The largest difference is a 32-bit number, which lies a little beside the one that is meant.
    let fits = |end: &&f64| largest <= **end * (1.0 + 1e-6);
    1.0 / end.iter().find(fits).copied().unwrap_or(largest)
}

/// The colour of a difference, from −1 to 1 on the scale.
pub(super) fn color(difference: f32) -> [f32; 3] {
    // The gain is rounded, too.
    const END: f32 = 1.0 + 1e-5;
    let share = difference.abs().min(1.0);
    let towards = |end: [f32; 3]| end.map(|channel| (1.0 - share) + share * channel);
    match difference {
        d if d.is_nan() => NOT_A_NUMBER,
        d if END < d => BEYOND_MORE,
        d if d < -END => BEYOND_LESS,
        d if d < 0.0 => towards(LESS),
        _ => towards(MORE),
    }
}

/// The difference, with its sign, of the channel that differs most.
fn largest(pixel: &[f32; 4], other: &[f32; 4]) -> f32 {
    let mut largest = 0.0_f32;
    for (&a, &b) in pixel.iter().zip(other) {
        if a.is_nan() != b.is_nan() {
            return f32::NAN;
        }
        // What is no number in both does not differ: no comparison holds of it.
        if largest.abs() < (a - b).abs() {
            largest = a - b;
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn difference_has_sign_and_size() {
        let check = |pixel: [f32; 4], gain: f64, expected: [f32; 3]| {
            let reference = Image::filled(1, 1, [0.5, 0.5, 0.5, 0.5]);
            let image = Image::filled(1, 1, pixel);
            let [r, g, b, a] = difference_picture(&image, &reference, gain).pixel(0, 0);
            assert_eq!(([r, g, b], a), (expected, 1.0), "{pixel:?} {gain}");
        };
        check([0.5; 4], 10.0, [1.0; 3]);
        check([0.75, 0.5, 0.5, 0.5], 4.0, MORE);
        check([0.5, 0.5, 0.5, 0.25], 4.0, LESS);
        check([0.625, 0.5, 0.25, 0.5], 4.0, LESS);
        check([0.5, 0.75, 0.5, 0.5], 2.0, MORE.map(|channel| 0.5 + 0.5 * channel));
        check([0.5, 0.75, 0.5, 0.5], 8.0, BEYOND_MORE);
        check([0.5, 0.25, 0.5, 0.5], 8.0, BEYOND_LESS);
        check([0.75, f32::NAN, 0.25, 0.5], 1.0, NOT_A_NUMBER);
    }

    #[test]
    fn difference_gain_fits_the_largest() {
        for (largest, gain) in [(0.0, 1.0), (0.7, 1.0), (0.5, 2.0), (0.03, 20.0), (0.001, 1000.0)] {
            assert!(
                (gain_for(largest) / gain - 1.0).abs() < 1e-9,
                "{largest}: {}",
                gain_for(largest)
            );
        }
        assert_eq!(gain_for(f64::from(0.2_f32)), 5.0);
        assert_eq!(gain_for(f64::INFINITY), 1.0);
        assert_eq!(gain_for(f64::NAN), 1.0);
    }
}
