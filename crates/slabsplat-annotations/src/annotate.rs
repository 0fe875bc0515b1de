//! All annotations of a scene, in the order in which they take their places.

use slabsplat_core::glam::DVec2;
use slabsplat_core::{Acquisition, Image, Scene};

use crate::axes::{draw_coordinates, draw_edges};
use crate::color_bar::draw_color_key;
use crate::orientation_marker::{draw_orientation_marker, marker_bounds};
use crate::room::Room;
use crate::scale_bar::draw_scale_bar;
use crate::screen::Screen;
use crate::sheet::{Sheet, Words};
use crate::text::{lacks, measure_text, text_size};

/// Draws what lies behind all that the scene shows, the edges of the box of its axes, onto what is to be
/// behind its frame: a background of the picture's size.
pub fn draw_behind(background: &mut Image, scene: &Scene) {
    let room = Room::of(scene);
    if !room.has_axes {
        return;
    }
    let screen = Screen::new(&scene.camera, &scene.image);
    let clear = background.clone();
    draw_edges(background, scene, &screen);
    if room.has_marker {
        let em = f64::from(text_size(background.width(), background.height()));
        restore(background, &clear, marker_bounds(screen.size(), em));
    }
}

/// Gives the pixels between two points what they were.
fn restore(image: &mut Image, before: &Image, [min, max]: [DVec2; 2]) {
    let width = image.width() as usize;
    let columns = min.x.max(0.0) as usize..(max.x.ceil() as usize).min(width);
    let rows = image.pixels_mut().chunks_exact_mut(width).zip(before.pixels().chunks_exact(width));
    for (row, before) in rows.take(max.y.ceil() as usize).skip(min.y.max(0.0) as usize) {
        row[columns.clone()].copy_from_slice(&before[columns.clone()]);
    }
}

/// Draws the annotations of `scene` onto a picture of it, of whose first volume `acquisition` says how it
/// stands and whether lengths are millimetres. Returns what is not drawn and why, and what people must know
/// of what is, a line each.
///
/// # Panics
/// If the picture has another size than the scene's.
#[must_use]
pub fn annotate(image: &mut Image, scene: &Scene, acquisition: Acquisition) -> Vec<String> {
    let sizes = [[image.width(), image.height()], [scene.image.width, scene.image.height]];
    assert_eq!(sizes[0], sizes[1], "the picture has another size than its scene");
    let wanted = &scene.finish.annotations;
    let screen = Screen::new(&scene.camera, &scene.image);
    let room = Room::of(scene);
    let mut sheet = Sheet::new(image, scene);
    sheet.notes = room.notes;
    if let Some(title) = wanted.title.as_ref().filter(|_| room.has_title) {
        draw_title(&mut sheet, title);
    }
    if room.has_scale_bar {
        draw_scale_bar(&mut sheet, &screen, acquisition.is_metric);
    }
    if room.has_color_bar {
        draw_color_key(&mut sheet, scene);
    }
    if room.has_marker {
        draw_orientation_marker(&mut sheet, &screen, acquisition.orientation);
    }
    if room.has_axes {
        draw_coordinates(&mut sheet, scene, &screen, acquisition);
    }
    let has_lengths = room.has_scale_bar || room.has_axes;
    if has_lengths && !acquisition.is_metric {
        let what = "the file does not say in which unit lengths are: they are shown without one";
        sheet.notes.push(what.to_owned());
    }
    sheet.notes
}

/// How much larger a title is than other text, if it has room.
const TITLE_SIZE: f32 = 1.4;

/// Text smaller than this many pixels an em is not legible.
const LEAST_SIZE: f32 = 9.0;

/// Draws a title at the top, as large as it has room, and cut off if it has none.
fn draw_title(sheet: &mut Sheet<'_>, title: &str) {
    let lacking = lacks(title);
    if !lacking.is_empty() {
        let lacking: String = lacking.into_iter().collect();
        sheet
            .notes
            .push(format!("the font of the title has no {lacking}: boxes are in their place"));
    }
    let size = sheet.size();
    let room = size.x - 2.0 * sheet.margin();
    let usual = TITLE_SIZE * sheet.text_size();
    let [width, _] = measure_text(title, usual).map(f64::from);
    let size_pixels = (usual * (room / width).min(1.0) as f32).max(LEAST_SIZE);
    let at = DVec2::new(0.5 * size.x, 0.6 * sheet.margin());
    let words = Words { text: title, at, anchor: [0.5, 0.0], size_pixels };
    if sheet.write(&words) {
        return;
    }
    let n_chars = title.chars().count();
    let shortened =
        |n: usize| title.chars().take(n).collect::<String>().trim_end().to_owned() + "…";
    let fits = |text: &String| sheet.is_free(Words { text, ..words }.bounds());
    match (1..n_chars).rev().map(shortened).find(fits) {
        Some(text) => {
            sheet.write(&Words { text: &text, ..words });
            sheet.no_room_for("all of the title");
        }
        None => sheet.no_room_for("the title"),
    }
}

#[cfg(test)]
mod tests;
