//! The directions of the world, in the lower left corner: arms that turn with the camera, with letters at
//! their ends.

use slabsplat_core::Orientation;
use slabsplat_core::glam::{DVec2, DVec3};

use crate::Ink;
use crate::screen::Screen;
use crate::shapes::draw_lines;
use crate::sheet::Sheet;
use crate::text::{Label, draw_text};

/// An arm from the marker's middle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Arm {
    letter: &'static str,
    axis: usize,
    /// To the right, upwards and away in the picture; of length 1.
    in_view: DVec3,
}

/// Of x, y and z, as usual.
const COLORS: [[f32; 3]; 3] = [[0.90, 0.25, 0.25], [0.25, 0.75, 0.30], [0.35, 0.50, 1.00]];

/// How long an arm is, and how far from the middle its letter, in ems.
const ARM: f64 = 1.65;
const LETTER: f64 = 2.35;

/// Half the side of its square, and how far that is from the picture's edges.
const HALF: f64 = LETTER + 0.6;
const MARGIN: f64 = 0.4;

/// Arms whose end is nearer to the middle than this part of their length, and point away, lie behind the
/// others.
const SHORT: f64 = 0.35;

impl Arm {
    /// All that have letters, the farthest first: of a body both ways of each axis, otherwise where numbers
    /// grow.
    fn all(screen: &Screen, orientation: Orientation) -> Vec<Self> {
        let (letters, ways): (_, &[f64]) = match orientation {
            Orientation::Anatomical => ([["R", "L"], ["A", "P"], ["S", "I"]], &[1.0, -1.0]),
            Orientation::Unknown | Orientation::Pictures => {
                ([["X", ""], ["Y", ""], ["Z", ""]], &[1.0])
            }
        };
        let axes =
            (0..3).flat_map(|axis| ways.iter().zip(letters[axis]).map(move |pair| (axis, pair)));
        let mut arms: Vec<Self> = axes
            .map(|(axis, (way, letter))| {
                let in_view = screen.in_view(DVec3::AXES[axis] * *way);
                Self { letter, axis, in_view }
            })
            .collect();
        arms.sort_by(|a, b| b.in_view.z.total_cmp(&a.in_view.z));
        arms
    }

    /// Where it points in the picture, whose rows go downwards.
    fn on_screen(&self) -> DVec2 {
        DVec2::new(self.in_view.x, -self.in_view.y)
    }

    /// Where its letter is, in ems from the middle: beyond its end, however short it is seen, until it points
    /// at the eye.
    fn letter(&self) -> DVec2 {
        let at = self.on_screen();
        at * (ARM + (LETTER - ARM) / at.length().max(SHORT))
    }

    fn is_behind(&self) -> bool {
        0.0 < self.in_view.z && self.on_screen().length() < SHORT
    }

    /// What points away is less of its colour and more of the halo's, as in haze.
    fn ink(&self, ink: Ink) -> Ink {
        let haze = (0.45 * self.in_view.z.max(0.0)) as f32;
        let color = COLORS[self.axis];
        ink.colored([0, 1, 2].map(|c| color[c] * (1.0 - haze) + ink.halo[c] * haze))
    }
}

/// Pixels from the edges of the picture that it takes.
pub(crate) fn marker_side(em: f64) -> f64 {
    (2.0 * HALF + MARGIN) * em
}

/// The square that it takes.
pub(crate) fn marker_bounds(size: DVec2, em: f64) -> [DVec2; 2] {
    let corner = DVec2::new(MARGIN * em, size.y - MARGIN * em);
    let side = 2.0 * HALF * em;
    [corner - DVec2::new(0.0, side), corner + DVec2::new(side, 0.0)]
}

/// Draws the marker. A perspective view has it as it is at the target.
pub(crate) fn draw_orientation_marker(
    sheet: &mut Sheet<'_>,
    screen: &Screen,
    orientation: Orientation,
) {
    let size_pixels = sheet.text_size();
    let em = f64::from(size_pixels);
    let bounds @ [min, max] = marker_bounds(sheet.size(), em);
    let middle = min.midpoint(max);
    if !sheet.is_free(bounds) {
        return sheet.no_room_for("the orientation marker");
    }
    sheet.take(bounds);
    let (ink, pen) = (sheet.ink_at(middle.y), sheet.pen());
    let pen = crate::shapes::Pen { width: 1.6 * pen.width, ..pen };
    for arm in Arm::all(screen, orientation) {
        let end = middle + arm.on_screen() * (ARM * em);
        draw_lines(sheet.image, &[[middle, end]], pen, arm.ink(ink));
        if !arm.is_behind() {
            let at = middle + arm.letter() * em;
            let at = [at.x as f32, at.y as f32];
            // Letters are in the colour of text: red ones are hard to read before much.
            let label = Label { text: arm.letter, at, anchor: [0.5, 0.5], size_pixels, ink };
            draw_text(sheet.image, &label);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Camera, Image, ImageDesc, Projection, Scene};

    fn screen(eye: [f64; 3], up: DVec3) -> Screen {
        let projection = Projection::Orthographic { view_height: 3.0 };
        let camera = Camera::new(eye, DVec3::ZERO, up, projection).unwrap();
        Screen::new(&camera, &ImageDesc::default())
    }

    /// The letters at the right, at the top and towards the eye.
    fn seen(screen: &Screen) -> [&'static str; 3] {
        let arms = Arm::all(screen, Orientation::Anatomical);
        let most = |key: fn(DVec3) -> f64| {
            let most = arms.iter().max_by(|a, b| key(a.in_view).total_cmp(&key(b.in_view)));
            most.unwrap().letter
        };
        [most(|v| v.x), most(|v| v.y), most(|v| -v.z)]
    }

    /// World space is RAS+, and who stands before a patient has the patient's left at the right.
    #[test]
    fn orientation_letters_are_those_of_a_body() {
        assert_eq!(seen(&screen([0.0, 9.0, 0.0], DVec3::Z)), ["L", "S", "A"], "from before");
        assert_eq!(seen(&screen([0.0, -9.0, 0.0], DVec3::Z)), ["R", "S", "P"], "from behind");
        assert_eq!(seen(&screen([9.0, 0.0, 0.0], DVec3::Z)), ["A", "S", "R"], "from the right");
        assert_eq!(seen(&screen([0.0, 0.0, -9.0], DVec3::Y)), ["L", "A", "I"], "from the feet");
        let names = Arm::all(&screen([1.0, 2.0, 3.0], DVec3::Z), Orientation::Unknown);
        let mut names: Vec<_> = names.into_iter().map(|arm| arm.letter).collect();
        names.sort_unstable();
        assert_eq!(names, ["X", "Y", "Z"]);
    }

    #[test]
    fn orientation_arms_are_where_axes_are_seen() {
        let eye = [5.0, 7.0, 3.0];
        let screen = screen(eye, DVec3::Z);
        let origin = screen.point(DVec3::ZERO).unwrap();
        for arm in Arm::all(&screen, Orientation::Pictures) {
            let along = screen.point(DVec3::AXES[arm.axis]).unwrap() - origin;
            assert!((along / screen.pixels_per_world()).distance(arm.on_screen()) < 1e-9);
        }
        let behind: Vec<_> =
            Arm::all(&self::screen([0.0, 9.0, 0.0], DVec3::Z), Orientation::Anatomical);
        let behind: Vec<_> = behind.iter().filter(|arm| arm.is_behind()).collect();
        assert!(behind.len() == 1 && behind[0].letter == "P", "{behind:?}");
    }

    #[test]
    fn orientation_marker_is_in_its_corner() {
        let camera = Camera::new(
            [5.0, 7.0, 3.0],
            DVec3::ZERO,
            DVec3::Z,
            Projection::Orthographic { view_height: 3.0 },
        );
        for (width, height, fits) in
            [(240, 240, true), (3000, 200, true), (30, 300, false), (1, 1, false)]
        {
            let desc = ImageDesc::new(width, height).background([1.0; 4]);
            let scene = Scene::of_meshes(Vec::new(), camera.clone().unwrap()).image(desc);
            let mut image = Image::filled(width, height, [1.0; 4]);
            let mut sheet = Sheet::new(&mut image, &scene);
            draw_orientation_marker(
                &mut sheet,
                &Screen::new(&scene.camera, &desc),
                Orientation::Anatomical,
            );
            assert_eq!(sheet.notes.is_empty(), fits);
            let drawn = image.pixels().iter().enumerate().filter(|(_, pixel)| **pixel != [1.0; 4]);
            let drawn: Vec<_> =
                drawn.map(|(idx, _)| (idx % width as usize, idx / width as usize)).collect();
            assert_eq!(drawn.is_empty(), !fits);
            let is_in_corner = |&(x, y): &(usize, usize)| x < 100 && height as usize - 100 < y;
            assert!(drawn.iter().all(is_in_corner));
        }
    }
}
