//! Colours that are stored as luminance and two differences, as red, green and blue (PS3.3 §C.7.6.3.1.2).

use super::frame::Layout;

/// Changes a frame of `YBR_FULL`, 8 bits a value, in its place.
pub(super) fn to_rgb(layout: &Layout, bytes: &mut [u8]) {
    let n_pixels = layout.n_pixels();
    for pixel in 0..n_pixels {
        let at = |channel: usize| match layout.is_planar {
            true => channel * n_pixels + pixel,
            false => pixel * layout.n_channels + channel,
        };
        let rgb = rgb([0, 1, 2].map(|channel| bytes[at(channel)]));
        rgb.into_iter().enumerate().for_each(|(channel, value)| bytes[at(channel)] = value);
    }
}

/// The inverse of the matrix there, whose numbers have four digits (ITU-R BT.601 has the same).
fn rgb(ybr: [u8; 3]) -> [u8; 3] {
    let [y, b, r] = ybr.map(f32::from);
    let (b, r) = (b - 128.0, r - 128.0);
    let rgb = [y + 1.402 * r, y - 0.344_136 * b - 0.714_136 * r, y + 1.772 * b];
    rgb.map(|value| value.round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The forward matrix of the standard, which is printed there.
    fn ybr([r, g, b]: [f32; 3]) -> [u8; 3] {
        [
            0.299 * r + 0.587 * g + 0.114 * b,
            -0.1687 * r - 0.3313 * g + 0.5 * b + 128.0,
            0.5 * r - 0.4187 * g - 0.0813 * b + 128.0,
        ]
        .map(|value| value.round() as u8)
    }

    #[test]
    fn ybr_there_and_back() {
        for red in (0..=255).step_by(51) {
            for green in (0..=255).step_by(51) {
                for blue in (0..=255).step_by(51) {
                    let expected = [red, green, blue];
                    let found = rgb(ybr(expected.map(|value| value as f32)));
                    let off = found.iter().zip(expected).map(|(&f, e)| (i32::from(f) - e).abs());
                    assert!(off.max() <= Some(2), "{expected:?} became {found:?}");
                }
            }
        }
    }
}
