//! How much of each pixel a shape covers, within the picture, and what becomes of a pixel that is covered.

use slabsplat_core::{Image, over};

/// Covered parts of pixels, 0 … 1, in a rectangle of a picture.
#[derive(Debug)]
pub(crate) struct Coverage {
    /// Column and row of the first pixel.
    origin: [usize; 2],
    width: usize,
    values: Vec<f32>,
}

impl Coverage {
    /// Nothing, in the pixels of `image` between two points, or `None` if there are none.
    pub(crate) fn between(image: &Image, [from, to]: [[f32; 2]; 2]) -> Option<Self> {
        let sides = [image.width(), image.height()];
        // A cast saturates, and NaN becomes 0.
        let first = [0, 1].map(|axis| from[axis].floor().max(0.0) as usize);
        let end = [0, 1].map(|axis| (to[axis].ceil().max(0.0) as usize).min(sides[axis] as usize));
        let [width, height] = [0, 1].map(|axis| end[axis].saturating_sub(first[axis]));
        let is_empty = width == 0 || height == 0;
        (!is_empty).then(|| Self { origin: first, width, values: vec![0.0; width * height] })
    }

    /// Whether any column between two, in pixels of the picture, is in the rectangle.
    pub(crate) fn reaches(&self, [left, right]: [f32; 2]) -> bool {
        self.origin[0] as f32 <= right && left <= (self.origin[0] + self.width) as f32
    }

    /// Covers a part more of a pixel of the picture; what is outside of the rectangle is nowhere.
    pub(crate) fn add(&mut self, [x, y]: [i64; 2], part: f32) {
        let [Ok(x), Ok(y)] =
            [x - self.origin[0] as i64, y - self.origin[1] as i64].map(usize::try_from)
        else {
            return;
        };
        if x < self.width
            && let Some(value) = self.values.get_mut(y * self.width + x)
        {
            *value = (*value + part).min(1.0);
        }
    }

    /// The same grown by `radius` pixels all around.
    ///
    /// ```text
    /// for each offset (dx, dy) within the radius:
    ///     for each row: grown[row][x] = max(grown[row][x], weight(dx, dy) · coverage[row + dy][x + dx])
    /// ```
    ///
    /// Offsets are the outer loop, so that the inner one is of whole rows and needs no branch.
    pub(crate) fn grown(&self, radius: f32) -> Self {
        let reach = radius.ceil() as i64;
        let mut grown = vec![0.0_f32; self.values.len()];
        for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
            let weight = (radius + 0.5 - (dx as f32).hypot(dy as f32)).clamp(0.0, 1.0);
            if 0.0 < weight {
                self.raise(&mut grown, [dx, dy], weight);
            }
        }
        Self { values: grown, ..*self }
    }

    /// Raises `grown` to a part of what is covered `offset` further on.
    fn raise(&self, grown: &mut [f32], [dx, dy]: [i64; 2], weight: f32) {
        let (width, height) = (self.width as i64, (self.values.len() / self.width) as i64);
        let columns = (-dx).clamp(0, width)..(width - dx).clamp(0, width);
        if columns.is_empty() {
            return;
        }
        for y in (-dy).clamp(0, height)..(height - dy).clamp(0, height) {
            let row = |y: i64, shift: i64| {
                let start = (y * width + columns.start + shift) as usize;
                start..start + (columns.end - columns.start) as usize
            };
            let of_shape = &self.values[row(y + dy, dx)];
            for (grown, value) in grown[row(y, 0)].iter_mut().zip(of_shape) {
                *grown = grown.max(weight * value);
            }
        }
    }

    /// Paints what is covered.
    pub(crate) fn paint(&self, image: &mut Image, color: [f32; 3]) {
        let stride = image.width() as usize;
        let [left, top] = self.origin;
        let rows = image.pixels_mut().chunks_exact_mut(stride).skip(top);
        for (row, values) in rows.zip(self.values.chunks_exact(self.width)) {
            for (pixel, part) in row[left..].iter_mut().zip(values) {
                paint(pixel, color, *part);
            }
        }
    }
}

/// Paints a part of a pixel.
pub(crate) fn paint(pixel: &mut [f32; 4], [r, g, b]: [f32; 3], part: f32) {
    if 0.0 < part {
        *pixel = over([r * part, g * part, b * part, part], *pixel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot() -> (Image, Coverage) {
        let image = Image::filled(9, 7, [0.0; 4]);
        let mut dot = Coverage::between(&image, [[-3.0, -1.5], [1e9, 99.0]]).unwrap();
        assert_eq!((dot.origin, dot.width, dot.values.len()), ([0, 0], 9, 63));
        dot.add([4, 3], 1.0);
        (image, dot)
    }

    #[test]
    fn coverage_stays_in_the_picture() {
        let (mut image, mut dot) = dot();
        for outside in [[-1, 3], [9, 3], [4, -1], [4, 7], [i64::MAX, 0]] {
            dot.add(outside, 1.0);
        }
        dot.paint(&mut image, [1.0, 0.5, 0.0]);
        assert_eq!(image.pixel(4, 3), [1.0, 0.5, 0.0, 1.0]);
        assert_eq!(image.pixels().iter().filter(|pixel| 0.0 < pixel[3]).count(), 1);
        for nowhere in [[[9.0, 0.0], [20.0, 5.0]], [[0.0, -9.0], [5.0, 0.0]], [[f32::NAN; 2]; 2]] {
            assert!(Coverage::between(&image, nowhere).is_none(), "{nowhere:?}");
        }
    }

    #[test]
    fn coverage_grows_all_around() {
        let (_, dot) = dot();
        let grown = dot.grown(2.0);
        let at = |x: usize, y: usize| grown.values[y * 9 + x];
        assert_eq!([at(4, 3), at(6, 3), at(2, 3), at(4, 5), at(4, 1)], [1.0, 0.5, 0.5, 0.5, 0.5]);
        assert_eq!([at(7, 3), at(6, 5), at(0, 0)], [0.0; 3], "the corners of a square are cut off");
        assert_eq!(at(5, 4), 1.0);
        let total: f32 = grown.values.iter().sum();
        assert!((total - 12.57).abs() < 1.5, "the area of a disc: {total}");
    }
}
