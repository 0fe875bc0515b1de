//! The box around all that there is: its edges, which lie behind it, and coordinates along three of them.
//!
//! Reading order: `bounds` (the box, and how its edges are seen), `scale` (an edge with coordinates),
//! `coordinates` (which edges have them, and what of it has room).

mod bounds;
mod coordinates;
mod scale;

use slabsplat_core::{Image, Scene, round_ticks};

pub(crate) use coordinates::draw_coordinates;

use crate::Ink;
use crate::room::Insets;
use crate::screen::Screen;
use crate::shapes::{Line, Pen, draw_lines};
use crate::sheet::written;
use crate::text::{measure_text, text_size};
use bounds::Bounds;

/// The least and the greatest corner of the box that axes are drawn around: that of the world's axes around
/// all volumes and meshes. `None` if there are none.
pub fn axes_box(scene: &Scene) -> Option<[slabsplat_core::glam::DVec3; 2]> {
    Bounds::of(scene).map(|bounds| bounds.0)
}

/// Draws the edges, for a picture behind which nothing but a background is.
pub(crate) fn draw_edges(image: &mut Image, scene: &Scene, screen: &Screen) {
    let Some(bounds) = Bounds::of(scene) else { return };
    let edges = bounds.edges(screen).into_iter().filter(|edge| edge.n_front < 2);
    let lines: Vec<Line> = edges.filter_map(|edge| screen.line(edge.ends)).collect();
    let pen = Pen::of_text(text_size(image.width(), image.height()));
    draw_lines(image, &lines, pen, Ink::on(scene.background_at(0.5)));
}

/// What coordinates take around the box: they stand at its left and below it, and at its right where an edge
/// tilts.
pub(crate) fn axes_insets(scene: &Scene, em: f64) -> Insets {
    let numbers = Bounds::of(scene).map_or(0.0, |bounds| numbers_width(&bounds, em));
    let left = (numbers + 1.1 * em).max(4.2 * em);
    Insets {
        left,
        right: (0.5 * numbers + 1.5 * em).max(3.0 * em),
        top: 2.2 * em,
        bottom: 3.8 * em,
    }
}

/// The width of the longest of some coordinates.
fn numbers_width(bounds: &Bounds, em: f64) -> f64 {
    let ticks = (0..3).flat_map(|axis| {
        let ends = bounds.0.map(|end| end[axis] / bounds.unit(true).in_world);
        round_ticks(ends, 4)
    });
    let widths = ticks.map(|tick| f64::from(measure_text(&written(tick), em as f32)[0]));
    widths.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
