//! Distances between points that are clicked.

use crate::state::{ViewPoint, seen_at};
use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Stroke};
use slabsplat::glam::DVec3;
use slabsplat::{Acquisition, Camera};

/// A distance that is measured.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ruler {
    /// Whether clicks are its ends.
    pub(crate) is_on: bool,
    ends: Vec<DVec3>,
}

impl Ruler {
    /// One more end; a third one begins anew.
    pub(crate) fn click(&mut self, point: DVec3) {
        if self.ends.len() == 2 {
            self.ends.clear();
        }
        self.ends.push(point);
    }

    /// Switches it on or off; what was measured is gone.
    pub(crate) fn toggle(&mut self) {
        *self = Self { is_on: !self.is_on, ends: Vec::new() };
    }

    /// What is measured, in the units of the file, once there are two ends.
    pub(crate) fn length(&self, acquisition: Acquisition) -> Option<String> {
        let [a, b] = self.ends[..] else { return None };
        let unit = if acquisition.is_metric { " mm" } else { "" };
        Some(format!("{}{unit}", super::number(a.distance(b))))
    }

    /// Draws it where `to_screen` says that points of the view are.
    pub(crate) fn paint(
        &self,
        painter: &Painter,
        camera: &Camera,
        acquisition: Acquisition,
        to_screen: impl Fn(ViewPoint) -> Pos2,
    ) {
        let seen: Vec<Pos2> =
            self.ends.iter().filter_map(|end| seen_at(camera, *end)).map(to_screen).collect();
        for at in &seen {
            painter.circle(*at, 4.0, Color32::YELLOW, Stroke::new(1.0, Color32::BLACK));
        }
        if let ([a, b], Some(length)) = (&seen[..], self.length(acquisition)) {
            painter.line_segment([*a, *b], Stroke::new(4.0, Color32::from_black_alpha(160)));
            painter.line_segment([*a, *b], Stroke::new(1.5, Color32::YELLOW));
            let font = FontId::proportional(15.0);
            let at = a.lerp(*b, 0.5) + eframe::egui::vec2(0.0, -8.0);
            let galley = painter.layout_no_wrap(length.clone(), font.clone(), Color32::YELLOW);
            let rect = Align2::CENTER_BOTTOM.anchor_size(at, galley.size()).expand(3.0);
            painter.rect_filled(rect, 3.0, Color32::from_black_alpha(170));
            painter.text(at, Align2::CENTER_BOTTOM, length, font, Color32::YELLOW);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_in_the_units_of_the_file() {
        let mut ruler = Ruler::default();
        ruler.toggle();
        ruler.click(DVec3::ZERO);
        assert_eq!(ruler.length(Acquisition::default()), None);
        ruler.click(DVec3::new(3.0, 0.0, 4.0));
        assert_eq!(ruler.length(Acquisition::default().metric()).unwrap(), "5 mm");
        assert_eq!(ruler.length(Acquisition::default()).unwrap(), "5");
        ruler.click(DVec3::ONE);
        assert_eq!(ruler.length(Acquisition::default()), None);
    }
}
