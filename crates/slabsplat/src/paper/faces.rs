//! What is read off a picture of the cube: how bright its faces are, and whether they have stripes.
//!
//! A picture is a function of a pixel's column and row that returns a channel, so that whoever has pictures
//! of another kind reads them alike.

use super::{CUBE_IMAGE_SIDE, FACE_PIXELS};

/// Mean of the left and of the right face of the cube seen at (about) 45°, where `pixel(x, y)` is a
/// channel of its picture.
pub fn face_means(pixel: impl Fn(u32, u32) -> f64) -> [f64; 2] {
    let columns = column_means(pixel);
    let [width, _] = FACE_PIXELS.map(|pixels| pixels as usize);
    let middle = columns.len() / 2;
    [middle - width, middle]
        .map(|first| columns[first..first + width].iter().sum::<f64>() / width as f64)
}

/// Column by column means of the right face, without the pixels that its edges brighten or dim.
pub fn face_profile(pixel: impl Fn(u32, u32) -> f64) -> Vec<f64> {
    let columns = column_means(pixel);
    let first = columns.len() / 2 + 6;
    // 18 pixels hold two periods of slabs of width 2 and four of width 1.
    columns[first..first + 18].to_vec()
}

/// Column by column means of the picture, over the rows that the faces cover.
pub fn column_means(pixel: impl Fn(u32, u32) -> f64) -> Vec<f64> {
    let [_, height] = FACE_PIXELS;
    let first = (CUBE_IMAGE_SIDE - height) / 2;
    let mean = |x| (first..first + height).map(|y| pixel(x, y)).sum::<f64>() / f64::from(height);
    (0..CUBE_IMAGE_SIDE).map(mean).collect()
}

/// How striped a profile is: its standard deviation over its mean (figure 7).
///
/// ```
/// assert_eq!(slabsplat::paper::stripes(&[0.25, 0.75]), 0.5);
/// assert_eq!(slabsplat::paper::stripes(&[0.5; 18]), 0.0);
/// ```
pub fn stripes(profile: &[f64]) -> f64 {
    let n = profile.len() as f64;
    let mean = profile.iter().sum::<f64>() / n;
    (profile.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt() / mean
}

/// A channel summed over all pixels of a picture of `width` × `height`.
pub fn sum_over_picture([width, height]: [u32; 2], pixel: impl Fn(u32, u32) -> f64) -> f64 {
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).sum()
}
