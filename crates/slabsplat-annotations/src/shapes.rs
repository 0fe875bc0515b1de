//! Lines and boxes, each with a halo.

use slabsplat_core::Image;
use slabsplat_core::glam::DVec2;

use crate::Ink;
use crate::coverage::paint;

/// A line from one point of the picture to another.
pub(crate) type Line = [DVec2; 2];

/// How thick lines are, and how far their halo reaches, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pen {
    pub(crate) width: f64,
    pub(crate) halo: f64,
}

impl Pen {
    /// For a picture whose text has that size.
    pub(crate) fn of_text(size_pixels: f32) -> Self {
        let size = f64::from(size_pixels);
        Self { width: (0.1 * size).max(1.0), halo: (0.07 * size).max(0.8) }
    }
}

/// Draws lines with round ends; no halo lies on another line.
pub(crate) fn draw_lines(image: &mut Image, lines: &[Line], pen: Pen, ink: Ink) {
    for line in lines {
        draw_line(image, line, 0.5 * pen.width + pen.halo, ink.halo);
    }
    for line in lines {
        draw_line(image, line, 0.5 * pen.width, ink.color);
    }
}

/// Pixels as near to a line as `radius`, row by row.
fn draw_line(image: &mut Image, &[from, to]: &Line, radius: f64, color: [f32; 3]) {
    let size = DVec2::new(f64::from(image.width()), f64::from(image.height()));
    let Some([from, to]) = clipped([from, to], DVec2::splat(-radius - 1.0), size + radius + 1.0)
    else {
        return;
    };
    let along = to - from;
    let length_squared = along.length_squared();
    let stride = image.width() as usize;
    let reach = radius + 1.0;
    let rows = rows_between(from.y.min(to.y) - reach, from.y.max(to.y) + reach, size.y);
    for (y, row) in rows.clone().zip(image.pixels_mut().chunks_exact_mut(stride).skip(rows.start)) {
        let [left, right] = columns_of_row([from, to], y as f64 + 0.5, reach);
        let columns = rows_between(left, right, size.x);
        for x in columns {
            let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let part = ((pixel - from).dot(along) / length_squared).clamp(0.0, 1.0);
            // Of a point, which has no direction, the quotient is NaN.
            let nearest = if part.is_nan() { from } else { from + along * part };
            let covered = (radius + 0.5 - pixel.distance(nearest)).clamp(0.0, 1.0);
            paint(&mut row[x], color, (covered * (2.0 * radius).min(1.0)) as f32);
        }
    }
}

/// Whole numbers from one to another that are at least 0 and less than `n`.
fn rows_between(from: f64, to: f64, n: f64) -> std::ops::Range<usize> {
    from.floor().clamp(0.0, n) as usize..to.ceil().clamp(0.0, n) as usize
}

/// Where a row crosses what is within `reach` of a line.
fn columns_of_row([from, to]: Line, y: f64, reach: f64) -> [f64; 2] {
    let [left, right] = [from.x.min(to.x), from.x.max(to.x)];
    let along = to - from;
    if along.y.abs() < 1e-9 * along.x.abs() || along.y == 0.0 {
        return [left - reach, right + reach];
    }
    let middle = from.x + along.x * (y - from.y) / along.y;
    // As wide as the band that is cut at an angle.
    let half = reach * (along.length() / along.y.abs());
    [(middle - half).max(left - reach), (middle + half).min(right + reach)]
}

/// The part of a line within a box (Liang & Barsky 1984), or `None` if there is none or it is not finite.
pub(crate) fn clipped([from, to]: Line, min: DVec2, max: DVec2) -> Option<Line> {
    if !(from.is_finite() && to.is_finite()) {
        return None;
    }
    let along = to - from;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        for (speed, room) in
            [(-along[axis], from[axis] - min[axis]), (along[axis], max[axis] - from[axis])]
        {
            if speed == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if speed < 0.0 {
                first = first.max(room / speed);
            } else {
                last = last.min(room / speed);
            }
        }
    }
    (first <= last).then(|| [from + along * first, from + along * last])
}

/// Paints a box between two corners; pixels that it covers in part take that part of its colour.
pub(crate) fn fill_box(image: &mut Image, [min, max]: [DVec2; 2], color: [f32; 3]) {
    let size = DVec2::new(f64::from(image.width()), f64::from(image.height()));
    if !(min.is_finite() && max.is_finite()) {
        return;
    }
    let covered = |at: usize, axis: usize| {
        let at = at as f64;
        ((at + 1.0).min(max[axis]) - at.max(min[axis])).clamp(0.0, 1.0)
    };
    let stride = image.width() as usize;
    let rows = rows_between(min.y, max.y, size.y);
    for (y, row) in rows.clone().zip(image.pixels_mut().chunks_exact_mut(stride).skip(rows.start)) {
        for x in rows_between(min.x, max.x, size.x) {
            paint(&mut row[x], color, (covered(x, 0) * covered(y, 1)) as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PEN: Pen = Pen { width: 2.0, halo: 1.0 };

    fn opacity(image: &Image) -> f32 {
        image.pixels().iter().map(|pixel| pixel[3]).sum()
    }

    #[test]
    fn line_covers_its_area_at_any_angle() {
        for degrees in [0.0_f64, 10.0, 45.0, 80.0, 90.0, 135.0] {
            let mut image = Image::filled(100, 100, [0.0; 4]);
            let (sin, cos) = degrees.to_radians().sin_cos();
            let half = DVec2::new(cos, sin) * 30.0;
            let center = DVec2::splat(50.3);
            draw_line(&mut image, &[center - half, center + half], 1.5, [1.0; 3]);
            // A bar of 60 by 3, and half a disc at each end.
            let area = 60.0 * 3.0 + std::f64::consts::PI * 1.5 * 1.5;
            assert!((f64::from(opacity(&image)) - area).abs() < 0.05 * area, "{degrees}");
        }
    }

    #[test]
    fn line_is_cut_off_at_the_edges() {
        let far = 1e12;
        for line in [
            [DVec2::new(-far, -far), DVec2::new(far, far)],
            [DVec2::new(-far, 5.0), DVec2::new(far, 5.0)],
            [DVec2::splat(5.0), DVec2::splat(5.0)],
        ] {
            let mut image = Image::filled(11, 11, [0.0; 4]);
            draw_lines(&mut image, &[line], PEN, Ink::LIGHT);
            assert_eq!(image.pixel(5, 5)[3], 1.0, "{line:?}");
            assert!(image.pixels().as_flattened().iter().all(|c| (0.0..=1.0).contains(c)));
        }
        for line in [
            [DVec2::new(-far, 50.0), DVec2::new(far, 50.0)],
            [DVec2::NAN, DVec2::ONE],
            [DVec2::ONE, DVec2::new(f64::INFINITY, 0.0)],
        ] {
            let mut image = Image::filled(11, 11, [0.0; 4]);
            draw_lines(&mut image, &[line], PEN, Ink::LIGHT);
            assert_eq!(opacity(&image), 0.0, "{line:?}");
        }
    }

    #[test]
    fn box_covers_its_area() {
        let mut image = Image::filled(10, 10, [0.0; 4]);
        fill_box(&mut image, [DVec2::new(1.25, 2.0), DVec2::new(4.5, 5.5)], [1.0; 3]);
        assert!((opacity(&image) - 3.25 * 3.5).abs() < 1e-5);
        assert_eq!(image.pixel(1, 2), [0.75; 4]);
        fill_box(&mut image, [DVec2::splat(-1e9), DVec2::splat(1e9)], [0.0; 3]);
        assert_eq!(image.pixel(9, 9), [0.0, 0.0, 0.0, 1.0]);
        fill_box(&mut image, [DVec2::NAN, DVec2::ONE], [1.0; 3]);
        assert_eq!(image.pixel(0, 0), [0.0, 0.0, 0.0, 1.0]);
    }
}
