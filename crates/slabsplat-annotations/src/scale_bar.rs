//! A bar of a round length, in the lower right corner.

use slabsplat_core::glam::DVec2;
use slabsplat_core::round_number_to;

use crate::lengths::Unit;
use crate::screen::Screen;
use crate::shapes::fill_box;
use crate::sheet::{Sheet, Words, written};

/// The longest that a bar may be, in parts of the picture's width, or of twice its height if that is less:
/// round numbers are up to 2.5 times apart, so that it is a tenth at least.
const LONGEST: f64 = 0.25;

/// A length of the world as it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bar {
    length: f64,
    pixels: f64,
}

impl Bar {
    /// `None` if lengths are none.
    fn of(screen: &Screen, is_metric: bool) -> Option<Self> {
        let pixels_per_world = screen.pixels_per_world();
        let most = LONGEST * room(screen.size()) / pixels_per_world;
        if !most.is_normal() {
            return None;
        }
        // Round in the unit in which it is written.
        let unit = Unit::of(most, is_metric);
        let length = round_number_to(most / unit.in_world) * unit.in_world;
        Some(Self { length, pixels: length * pixels_per_world })
    }

    /// In a perspective view lengths depend on depth.
    fn text(&self, screen: &Screen, is_metric: bool) -> String {
        let unit = Unit::of(self.length, is_metric);
        let number = written(self.length / unit.in_world);
        let where_to = if screen.is_perspective() { " at target" } else { "" };
        format!("{number} {}{where_to}", unit.symbol).replace("  ", " ").trim_end().to_owned()
    }
}

fn room(size: DVec2) -> f64 {
    size.x.min(2.0 * size.y)
}

/// Pixels from the lower edge of the picture that it takes.
pub(crate) fn scale_bar_height(em: f64) -> f64 {
    2.8 * em
}

/// Draws a bar as long as a round length is at the depth of the camera's target.
pub(crate) fn draw_scale_bar(sheet: &mut Sheet<'_>, screen: &Screen, is_metric: bool) {
    let Some(bar) = Bar::of(screen, is_metric) else { return };
    let text = bar.text(screen, is_metric);
    let size_pixels = sheet.text_size();
    let thickness = (0.3 * f64::from(size_pixels)).max(2.0).round();
    let end = sheet.size() - sheet.margin();
    let words = Words { text: &text, at: DVec2::ZERO, anchor: [0.5, 1.0], size_pixels };
    let [min, max] = words.bounds();
    // Words that are longer than the bar stay in the picture.
    let half = (0.5 * (max.x - min.x)).max(0.5 * bar.pixels);
    let middle = end.x - half;
    let bounds = [
        DVec2::new(middle - 0.5 * bar.pixels, end.y - thickness),
        DVec2::new(middle + 0.5 * bar.pixels, end.y),
    ];
    let gap = 0.2 * f64::from(size_pixels);
    let words = Words { at: DVec2::new(middle, bounds[0].y - gap), ..words };
    if !(sheet.is_free(bounds) && sheet.write(&words)) {
        return sheet.no_room_for("the scale bar");
    }
    let (ink, halo) = (sheet.ink_at(end.y), sheet.pen().halo.round().max(1.0));
    fill_box(sheet.image, [bounds[0] - halo, bounds[1] + halo], ink.halo);
    fill_box(sheet.image, bounds, ink.color);
    sheet.take(bounds);
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{Camera, Image, ImageDesc, Projection, Scene};

    const SIZES: [[u32; 2]; 4] = [[240, 240], [800, 600], [2000, 2000], [3000, 200]];

    fn drawn(projection: Projection, [width, height]: [u32; 2]) -> (Image, Screen) {
        let camera = Camera::new(DVec3::X * 500.0, DVec3::ZERO, DVec3::Z, projection).unwrap();
        let image = ImageDesc::new(width, height).background([0.0, 0.0, 0.0, 1.0]);
        let scene = Scene::of_meshes(Vec::new(), camera).image(image);
        let mut picture = Image::filled(width, height, image.background);
        let screen = Screen::new(&camera, &image);
        let mut sheet = Sheet::new(&mut picture, &scene);
        draw_scale_bar(&mut sheet, &screen, true);
        assert_eq!(sheet.notes, [""; 0]);
        (picture, screen)
    }

    /// The lit pixels of the row through the bar's middle.
    #[test]
    fn scale_bar_is_as_long_as_its_length_is_seen() {
        for size in SIZES {
            for projection in [
                Projection::Orthographic { view_height: 333.0 },
                Projection::Orthographic { view_height: 0.0417 },
                Projection::Perspective { fov_y_radians: 0.5 },
            ] {
                let (picture, screen) = drawn(projection, size);
                let bar = Bar::of(&screen, true).unwrap();
                let ends = [DVec3::ZERO, DVec3::Y * bar.length].map(|p| screen.point(p).unwrap());
                let seen = ends[0].distance(ends[1]);
                let size_pixels = crate::text_size(size[0], size[1]);
                let row = size[1] as f32 - (0.8 * size_pixels).round() - 1.0;
                let lit: f32 = (0..size[0]).map(|x| picture.pixel(x, row as u32)[0]).sum();
                assert!(
                    (f64::from(lit) - seen).abs() < 1e-2,
                    "{size:?} {projection:?}: {lit} {seen}"
                );
                let part = seen / room(screen.size());
                assert!((0.0999..=0.25).contains(&part), "{part}");
            }
        }
    }

    #[test]
    fn scale_bar_says_its_length() {
        let text = |projection, is_metric| {
            let (_, screen) = drawn(projection, [200, 100]);
            Bar::of(&screen, is_metric).unwrap().text(&screen, is_metric)
        };
        let orthographic = |view_height| Projection::Orthographic { view_height };
        assert_eq!(text(orthographic(100.0), true), "50 mm");
        assert_eq!(text(orthographic(200.0), true), "10 cm");
        assert_eq!(text(orthographic(0.1), true), "50 µm");
        assert_eq!(text(orthographic(1e-4), true), "50 nm");
        assert_eq!(text(orthographic(100.0), false), "50");
        assert_eq!(text(Projection::Perspective { fov_y_radians: 0.5 }, true), "10 cm at target");
    }

    #[test]
    fn scale_bar_needs_room() {
        let camera = Camera::new(
            DVec3::X,
            DVec3::ZERO,
            DVec3::Z,
            Projection::Orthographic { view_height: 1.0 },
        );
        let image = ImageDesc::new(16, 16);
        let scene = Scene::of_meshes(Vec::new(), camera.clone().unwrap()).image(image);
        let mut picture = Image::filled(16, 16, [0.0; 4]);
        let mut sheet = Sheet::new(&mut picture, &scene);
        draw_scale_bar(&mut sheet, &Screen::new(&camera.unwrap(), &image), true);
        assert_eq!(sheet.notes, ["the scale bar has no room in a picture of 16 x 16 pixels"]);
        assert!(picture == Image::filled(16, 16, [0.0; 4]));
    }
}
