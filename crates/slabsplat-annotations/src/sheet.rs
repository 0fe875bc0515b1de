//! A picture on which things have places: nothing lies on anything else, or outside.

use slabsplat_core::glam::DVec2;
use slabsplat_core::{Image, Scene};

use crate::Ink;
use crate::shapes::Pen;
use crate::text::{Label, draw_text, measure_text, text_size};

/// The picture, what is taken of it, and what had no room.
#[derive(Debug)]
pub(crate) struct Sheet<'a> {
    pub(crate) image: &'a mut Image,
    scene: &'a Scene,
    taken: Vec<[DVec2; 2]>,
    /// For people, a line each.
    pub(crate) notes: Vec<String>,
}

/// A line of text that is to be somewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Words<'a> {
    pub(crate) text: &'a str,
    pub(crate) at: DVec2,
    /// As of [`Label`].
    pub(crate) anchor: [f64; 2],
    pub(crate) size_pixels: f32,
}

impl<'a> Sheet<'a> {
    pub(crate) fn new(image: &'a mut Image, scene: &'a Scene) -> Self {
        Self { image, scene, taken: Vec::new(), notes: Vec::new() }
    }

    pub(crate) fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.image.width()), f64::from(self.image.height()))
    }

    /// Pixels of an em of usual text.
    pub(crate) fn text_size(&self) -> f32 {
        text_size(self.image.width(), self.image.height())
    }

    /// Between what is drawn and the picture's edges, in pixels.
    pub(crate) fn margin(&self) -> f64 {
        (0.8 * f64::from(self.text_size())).round()
    }

    pub(crate) fn pen(&self) -> Pen {
        Pen::of_text(self.text_size())
    }

    /// What is legible before the background in a row of pixels.
    pub(crate) fn ink_at(&self, y: f64) -> Ink {
        let part = (y / self.size().y).clamp(0.0, 1.0) as f32;
        Ink::on(self.scene.background_at(part))
    }

    /// Whether a box lies in the picture.
    pub(crate) fn holds(&self, [min, max]: [DVec2; 2]) -> bool {
        min.cmpge(DVec2::ZERO).all() && max.cmple(self.size()).all()
    }

    /// Whether it lies on nothing that is there.
    pub(crate) fn is_apart(&self, [min, max]: [DVec2; 2]) -> bool {
        let is_apart = |[from, to]: &[DVec2; 2]| max.cmple(*from).any() || to.cmple(min).any();
        self.taken.iter().all(is_apart)
    }

    /// Both.
    pub(crate) fn is_free(&self, bounds: [DVec2; 2]) -> bool {
        self.holds(bounds) && self.is_apart(bounds)
    }

    /// Takes a box, so that nothing else is drawn there.
    pub(crate) fn take(&mut self, taken: [DVec2; 2]) {
        self.taken.push(taken);
    }

    /// Writes words if there is room for them, and says whether there was.
    pub(crate) fn write(&mut self, words: &Words<'_>) -> bool {
        let bounds = words.bounds();
        let is_free = self.is_free(bounds);
        if is_free {
            self.take(bounds);
            let &Words { text, at, anchor, size_pixels } = words;
            let ink = self.ink_at(bounds[0].midpoint(bounds[1]).y);
            let anchor = anchor.map(|part| part as f32);
            let at = [at.x as f32, at.y as f32];
            draw_text(self.image, &Label { text, at, anchor, size_pixels, ink });
        }
        is_free
    }

    /// Notes that something is not in the picture.
    pub(crate) fn no_room_for(&mut self, what: &str) {
        let [width, height] = [self.image.width(), self.image.height()];
        self.notes.push(format!("{what} has no room in a picture of {width} x {height} pixels"));
    }
}

impl Words<'_> {
    /// The box that they take.
    pub(crate) fn bounds(&self) -> [DVec2; 2] {
        let [width, height] = measure_text(self.text, self.size_pixels).map(f64::from);
        let min = self.at - DVec2::new(width * self.anchor[0], height * self.anchor[1]);
        // Sums of floats are not to push a title that just fits out of the picture.
        [min + 1e-3, min + DVec2::new(width, height) - 1e-3]
    }
}

/// A number as it is written on a picture.
pub(crate) fn written(number: f64) -> String {
    slabsplat_core::number_text(number).replace('-', "−")
}
