//! What colours mean, at the right edge: a bar with round values beside it, or a legend of labels.

use slabsplat_core::glam::DVec2;
use slabsplat_core::{Layer, Scene, round_ticks};

use crate::color_key::ColorKey;
use crate::shapes::{Pen, draw_lines, fill_box};
use crate::sheet::{Sheet, Words, written};
use crate::text::measure_text;

/// Where a bar begins and ends, in parts of the picture's height.
const BAR: [f64; 2] = [0.22, 0.78];

/// Ems from a row of a legend to the next, and the part of the picture's height that all may take.
const ROW: f64 = 1.5;
const LEGEND: f64 = 0.7;

/// Ems: the side of a colour, the gap to what is written beside it, and the space that is left of it.
const SIDE: f64 = 1.0;
const GAP: f64 = 0.65;
const SPACE: f64 = 0.6;

/// Draws the colours of the first layer's values that are visible, or of its labels.
pub(crate) fn draw_color_key(sheet: &mut Sheet<'_>, scene: &Scene) {
    match ColorKey::of(scene) {
        Ok(ColorKey::Bar(layer, range)) => draw_bar(sheet, layer, range),
        Ok(ColorKey::Legend(legend)) => draw_legend(sheet, &legend),
        Err(why) => sheet.notes.push(format!("no colour bar is drawn: {why}")),
    }
}

/// Pixels of a picture's width that it takes; `None` if there is nothing to draw.
pub(crate) fn key_width(scene: &Scene, em: f64) -> Option<f64> {
    let texts = match ColorKey::of(scene).ok()? {
        ColorKey::Bar(_, range) => values_of(range, f64::from(scene.image.height), em).1,
        ColorKey::Legend(legend) => legend.into_iter().map(|(text, _)| text).collect(),
    };
    // The margin at the edge is 0.8 em.
    Some((SPACE + SIDE + GAP + 0.8) * em + widest(&texts, em))
}

fn widest(texts: &[String], em: f64) -> f64 {
    texts.iter().map(|text| f64::from(measure_text(text, em as f32)[0])).fold(0.0, f64::max)
}

/// Round values in a range, and how they are written.
fn values_of(range: [f64; 2], height: f64, em: f64) -> (Vec<f64>, Vec<String>) {
    let n_steps = ((BAR[1] - BAR[0]) * height / (2.2 * em)).clamp(1.0, 8.0) as u32;
    let ticks = round_ticks(range, n_steps);
    let texts = ticks.iter().map(|tick| written(*tick)).collect();
    (ticks, texts)
}

fn draw_bar(sheet: &mut Sheet<'_>, layer: &Layer, [lo, hi]: [f64; 2]) {
    let (size, size_pixels) = (sheet.size(), sheet.text_size());
    let em = f64::from(size_pixels);
    let [top, bottom] = BAR.map(|part: f64| (part * size.y).round());
    let (ticks, texts) = values_of([lo, hi], size.y, em);
    let right = (size.x - sheet.margin() - widest(&texts, em) - GAP * em).floor();
    let bar = [DVec2::new(right - (SIDE * em).round(), top), DVec2::new(right, bottom)];
    let all = [bar[0] - SPACE * em, DVec2::new(size.x - sheet.margin() + 0.5, bottom + SPACE * em)];
    if bottom - top < 3.0 * em || !sheet.is_free(all) {
        return sheet.no_room_for("the colour bar");
    }
    let row_of = |value: f64| bottom - (bottom - top) * ((value - lo) / (hi - lo));
    let [min, max] = bar;
    let mut lines = outline(bar);
    let tick_end = right + 0.35 * em;
    lines.extend(ticks.iter().map(|tick| [right, tick_end].map(|x| DVec2::new(x, row_of(*tick)))));
    let (pen, ink) = (sheet.pen(), sheet.ink_at(0.5 * size.y));
    draw_lines(sheet.image, &lines, pen, ink);
    for row in top as u32..bottom as u32 {
        let y = f64::from(row);
        let value = lo + (hi - lo) * ((bottom - y - 0.5) / (bottom - top));
        let color = layer.transfer.color(value).map(|channel| channel as f32);
        fill_box(sheet.image, [DVec2::new(min.x, y), DVec2::new(max.x, y + 1.0)], color);
    }
    // The frame is drawn again, as colours lie on the inner half of it.
    draw_lines(sheet.image, &lines, Pen { halo: 0.0, ..pen }, ink);
    for (tick, text) in ticks.iter().zip(&texts) {
        let at = DVec2::new(tick_end + 0.3 * em, row_of(*tick));
        sheet.write(&Words { text, at, anchor: [0.0, 0.5], size_pixels });
    }
    sheet.take(all);
}

/// Draws the colour of each label beside it, the first at the top.
fn draw_legend(sheet: &mut Sheet<'_>, legend: &[(String, [f64; 3])]) {
    let (size, size_pixels) = (sheet.size(), sheet.text_size());
    let em = f64::from(size_pixels);
    let height = ROW * em * legend.len() as f64;
    if LEGEND * size.y < height {
        let n_rows = (LEGEND * size.y / (ROW * em)) as usize;
        let n_labels = legend.len();
        let what = format!("no legend is drawn: of {n_labels} labels it has room for {n_rows}");
        return sheet.notes.push(what);
    }
    let texts: Vec<String> = legend.iter().map(|(text, _)| text.clone()).collect();
    let left = (size.x - sheet.margin() - widest(&texts, em) - (GAP + SIDE) * em).floor();
    let top = (0.5 * (size.y - height)).round();
    let all = [
        DVec2::new(left - SPACE * em, top),
        DVec2::new(size.x - sheet.margin() + 0.5, top + height),
    ];
    if !sheet.is_free(all) {
        return sheet.no_room_for("the legend");
    }
    let (pen, ink) = (sheet.pen(), sheet.ink_at(0.5 * size.y));
    for (idx, (text, color)) in legend.iter().enumerate() {
        let middle = top + ROW * em * (idx as f64 + 0.5);
        let [upper, lower] = [-0.5, 0.5].map(|part| (middle + part * SIDE * em).round());
        let square = [DVec2::new(left, upper), DVec2::new(left + (SIDE * em).round(), lower)];
        draw_lines(sheet.image, &outline(square), pen, ink);
        fill_box(sheet.image, square, color.map(|channel| channel as f32));
        draw_lines(sheet.image, &outline(square), Pen { halo: 0.0, ..pen }, ink);
        let at = DVec2::new(left + (SIDE + GAP) * em, middle);
        sheet.write(&Words { text, at, anchor: [0.0, 0.5], size_pixels });
    }
    sheet.take(all);
}

fn outline([min, max]: [DVec2; 2]) -> Vec<[DVec2; 2]> {
    let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
    (0..4).map(|idx| [corners[idx], corners[(idx + 1) % 4]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color_key::tests::{BLUE, RED, layer, scene, steps};
    use slabsplat_core::{Image, ImageDesc, TransferFunction};

    fn drawn(layer: Layer, [width, height]: [u32; 2]) -> (Image, Vec<String>) {
        let background = [0.0, 0.0, 0.0, 1.0];
        let scene = scene(layer).image(ImageDesc::new(width, height).background(background));
        let mut image = Image::filled(width, height, background);
        let mut sheet = Sheet::new(&mut image, &scene);
        draw_color_key(&mut sheet, &scene);
        let notes = sheet.notes;
        (image, notes)
    }

    #[test]
    fn color_bar_has_the_colors_of_values() {
        let (image, notes) = drawn(layer(), [400, 300]);
        assert_eq!(notes, [""; 0]);
        // Somewhere right of the middle a column has the colours, red below and blue above.
        let [top, bottom] = BAR.map(|part| (part * 300.0).round() as u32);
        let is_bar = |x: &u32| {
            let [low, high] = [bottom - 3, top + 3].map(|y| image.pixel(*x, y));
            low[0] > 0.7 && low[2] < 0.3 && high[0] < 0.1 && high[2] > 0.9 && high[1] == 0.0
        };
        let columns = (200..400).filter(is_bar).count();
        assert!((8..12).contains(&columns), "{columns}");
    }

    #[test]
    fn color_bar_of_labels_is_a_legend() {
        let (image, notes) = drawn(layer().transfer(steps()), [400, 300]);
        assert_eq!(notes, [""; 0]);
        let n_pixels = |[r, g, b]: [f64; 3]| {
            let color = [r as f32, g as f32, b as f32, 1.0];
            image.pixels().iter().filter(|pixel| **pixel == color).count()
        };
        for color in [RED, BLUE] {
            assert!((60..=121).contains(&n_pixels(color)), "{color:?}: {}", n_pixels(color));
        }
        // The even numbers up to 198.
        let borders = (0..200).map(|idx| f64::from((idx + 1) / 2 * 2 - 1).clamp(0.0, 198.0));
        let points: Vec<f64> = borders.collect();
        let color =
            points.iter().enumerate().map(|(idx, at)| (*at, [(idx / 2 % 7) as f64 / 7.0; 3]));
        let transfer = TransferFunction::new(points.iter().map(|at| (*at, 0.5)), color);
        let (image, notes) = drawn(layer().transfer(transfer.unwrap()), [400, 300]);
        assert!(
            notes[0].starts_with("no legend is drawn: of 100 labels it has room for 12"),
            "{notes:?}"
        );
        assert!(image == Image::filled(400, 300, [0.0, 0.0, 0.0, 1.0]));
    }

    #[test]
    fn color_bar_needs_room() {
        let clear = TransferFunction::new([(0.0, 0.0)], [(0.0, [1.0; 3])]).unwrap();
        let (image, notes) = drawn(layer().transfer(clear), [400, 300]);
        assert_eq!(notes, ["no colour bar is drawn: no value is visible"]);
        assert!(image == Image::filled(400, 300, [0.0, 0.0, 0.0, 1.0]));
        for size in [[20, 300], [300, 30], [16, 16], [1, 1]] {
            let (_, notes) = drawn(layer(), size);
            assert!(notes[0].starts_with("the colour bar has no room"), "{notes:?}");
        }
    }
}
