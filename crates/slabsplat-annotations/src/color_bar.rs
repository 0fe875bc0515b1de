//! The colours of a layer's values, at the right edge.

use slabsplat_core::glam::DVec2;
use slabsplat_core::{Layer, Mode, Scene, round_ticks};

use crate::shapes::{draw_lines, fill_box};
use crate::sheet::{Sheet, Words, written};

/// Draws the colours of the first layer's values that are visible, with round values beside them.
pub(crate) fn draw_color_bar(sheet: &mut Sheet<'_>, scene: &Scene) {
    match bar_of(scene) {
        Ok((layer, range)) => draw(sheet, layer, range),
        Err(why) => sheet.notes.push(format!("no colour bar is drawn: {why}")),
    }
}

/// The layer whose colours are shown, and for which values; or why there are none.
fn bar_of(scene: &Scene) -> Result<(&Layer, [f64; 2]), &'static str> {
    let layer = scene.layers.first().ok_or("meshes have no values")?;
    if layer.labels.is_some() {
        return Err("labels decide which colours voxels have");
    }
    if layer.colors.is_some() {
        return Err("voxels have colours of their own");
    }
    if layer.transfer_2d.is_some() {
        return Err("colours depend on gradients, too");
    }
    if scene.settings.mode == Mode::Isosurfaces {
        return Err("isosurfaces have a colour each");
    }
    visible_range(layer).map(|range| (layer, range)).ok_or("no value is visible")
}

/// From the least visible value to the greatest, of those that the volume has and the transfer function
/// speaks of.
fn visible_range(layer: &Layer) -> Option<[f64; 2]> {
    let transfer = &layer.transfer;
    let visible = transfer.iso_ranges();
    let (first, last) = (visible.first()?, visible.last()?);
    let positions = || transfer.positions();
    let ends =
        [positions().fold(f64::INFINITY, f64::min), positions().fold(f64::NEG_INFINITY, f64::max)];
    let [least, greatest] = layer.volume.summary().range?;
    let lo = first.lo.max(ends[0]).max(least);
    let hi = last.hi.min(ends[1]).min(greatest);
    // One value, or a function of one point, has a colour as well.
    Some(if lo < hi {
        [lo, hi]
    } else {
        [least, if least < greatest { greatest } else { least + 1.0 }]
    })
}

fn draw(sheet: &mut Sheet<'_>, layer: &Layer, [lo, hi]: [f64; 2]) {
    let (size, size_pixels) = (sheet.size(), sheet.text_size());
    let em = f64::from(size_pixels);
    let [top, bottom] = [0.22, 0.78].map(|part: f64| (part * size.y).round());
    let n_steps = ((bottom - top) / (2.2 * em)).clamp(1.0, 8.0) as u32;
    let ticks = round_ticks([lo, hi], n_steps);
    let texts: Vec<String> = ticks.iter().map(|tick| written(*tick)).collect();
    let label_width = texts.iter().map(|text| f64::from(crate::measure_text(text, size_pixels)[0]));
    let label_width = label_width.fold(0.0, f64::max);
    let right = (size.x - sheet.margin() - label_width - 0.7 * em).floor();
    let bar = [DVec2::new(right - em.round(), top), DVec2::new(right, bottom)];
    let all = [bar[0] - 0.6 * em, DVec2::new(size.x - sheet.margin() + 0.5, bottom + 0.6 * em)];
    // A bar over half of the picture is none beside it.
    if bottom - top < 3.0 * em || !sheet.is_free(all) || all[0].x < 0.4 * size.x {
        return sheet.no_room_for("the colour bar");
    }
    let row_of = |value: f64| bottom - (bottom - top) * ((value - lo) / (hi - lo));
    let [min, max] = bar;
    let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
    let mut lines: Vec<_> = (0..4).map(|idx| [corners[idx], corners[(idx + 1) % 4]]).collect();
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
    let thin = crate::shapes::Pen { halo: 0.0, ..pen };
    draw_lines(sheet.image, &lines, thin, ink);
    for (tick, text) in ticks.iter().zip(&texts) {
        let at = DVec2::new(tick_end + 0.3 * em, row_of(*tick));
        sheet.write(&Words { text, at, anchor: [0.0, 0.5], size_pixels });
    }
    sheet.take(all);
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{
        Camera, ColorSamples, Grid, Image, ImageDesc, LabelMap, Labels, Projection, Scaling,
        TransferBox, TransferFunction, TransferFunction2d, Volume, VoxelColors,
    };

    fn layer() -> Layer {
        let grid = Grid::centered([2, 2, 2], [1.0; 3]).unwrap();
        let volume =
            Volume::new(grid, vec![0_u8, 50, 100, 150, 200, 250, 3, 4].into(), Scaling::IDENTITY);
        let colors = [(0.0, [1.0, 0.0, 0.0]), (200.0, [0.0, 0.0, 1.0])];
        let transfer = TransferFunction::new([(40.0, 0.0), (60.0, 0.5), (300.0, 0.5)], colors);
        Layer::new(volume.unwrap(), transfer.unwrap())
    }

    fn scene(layer: Layer, [width, height]: [u32; 2]) -> Scene {
        let projection = Projection::Orthographic { view_height: 3.0 };
        let camera = Camera::new(DVec3::X * 9.0, DVec3::ZERO, DVec3::Z, projection).unwrap();
        Scene::new(layer, camera).image(ImageDesc {
            width,
            height,
            background: [0.0, 0.0, 0.0, 1.0],
        })
    }

    fn drawn(scene: &Scene) -> (Image, Vec<String>) {
        let ImageDesc { width, height, background } = scene.image;
        let mut image = Image::filled(width, height, background);
        let mut sheet = Sheet::new(&mut image, scene);
        draw_color_bar(&mut sheet, scene);
        let notes = sheet.notes;
        (image, notes)
    }

    #[test]
    fn color_bar_is_of_visible_values() {
        let [lo, hi] = visible_range(&layer()).unwrap();
        assert!((39.99..40.01).contains(&lo) && hi == 250.0, "{lo} {hi}");
        let (image, notes) = drawn(&scene(layer(), [400, 300]));
        assert_eq!(notes, [""; 0]);
        // Somewhere right of the middle a column has the colours, red below and blue above.
        let [top, bottom] = [0.22 * 300.0, 0.78 * 300.0].map(|row: f32| row.round() as u32);
        let is_bar = |x: &u32| {
            let [low, high] = [bottom - 3, top + 3].map(|y| image.pixel(*x, y));
            low[0] > 0.7 && low[2] < 0.3 && high[0] < 0.1 && high[2] > 0.9 && high[1] == 0.0
        };
        let columns = (200..400).filter(is_bar).count();
        assert!((8..12).contains(&columns), "{columns}");
    }

    #[test]
    fn color_bar_says_why_there_is_none() {
        let check = |layer: Layer, expected: &str| {
            let (image, notes) = drawn(&scene(layer, [400, 300]));
            assert_eq!(notes, [format!("no colour bar is drawn: {expected}")]);
            assert!(image == Image::filled(400, 300, [0.0, 0.0, 0.0, 1.0]));
        };
        let layer = layer();
        let map = LabelMap::new(&layer.volume, layer.volume.grid()).unwrap();
        let labels = Labels::new(map, []).unwrap();
        check(layer.clone().labels(labels), "labels decide which colours voxels have");
        let colors = VoxelColors::new([2; 3], ColorSamples::U8(vec![[0; 3]; 8])).unwrap();
        check(layer.clone().colors(colors), "voxels have colours of their own");
        let boxes = vec![TransferBox::new([0.0, 9.0], [0.0, 1.0]).unwrap()];
        let by_both = TransferFunction2d::Boxes(boxes);
        check(layer.clone().transfer_2d(by_both), "colours depend on gradients, too");
        let clear = TransferFunction::new([(0.0, 0.0)], [(0.0, [1.0; 3])]).unwrap();
        check(layer.clone().transfer(clear), "no value is visible");
        let mut isosurfaces = scene(layer, [400, 300]);
        isosurfaces.settings.mode = Mode::Isosurfaces;
        assert!(bar_of(&isosurfaces).is_err());
        isosurfaces.layers.clear();
        assert!(bar_of(&isosurfaces).is_err());
        for size in [[40, 300], [300, 40], [16, 16], [1, 1]] {
            let (_, notes) = drawn(&scene(self::layer(), size));
            assert!(notes[0].starts_with("the colour bar has no room"), "{notes:?}");
        }
    }
}
