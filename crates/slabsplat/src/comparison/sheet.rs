//! One picture of many: each with its label, where it differs from the reference, and figures; below them,
//! what the colours of differences mean.

use super::difference_picture::color;
use slabsplat_annotations::{Label, draw_text, measure_text};
use slabsplat_core::{Image, ImageDesc, ImageError, over};

/// What a sheet holds, before anything is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SheetDesc {
    /// How many pictures there are.
    pub n_panes: usize,
    /// How many stand in a row, 1 or more.
    pub n_columns: usize,
    /// Width and height of each in pixels.
    pub pane_size: [u32; 2],
}

/// A picture of the sheet.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Pane {
    /// What stands above it.
    pub label: String,
    /// The picture and where it differs, or a sentence why there is none.
    pub pictures: Result<[Image; 2], String>,
    /// What stands below it: its figures.
    pub figures: String,
}

/// A sheet that has room for its panes.
#[derive(Clone, Copy, Debug)]
pub struct Sheet {
    desc: SheetDesc,
    cell: [u32; 2],
    image: ImageDesc,
}

/// Around everything, in pixels.
const GAP: u32 = 8;

/// Pixels of an em, and the height of a line.
const TEXT: f32 = 13.0;
const LINE: u32 = 18;

/// The least width of a cell, for its label and its figures.
const MIN_CELL_WIDTH: u32 = 270;

/// The scale of colours below all panes, in pixels.
const BAR: [u32; 2] = [200, 12];

const BACKGROUND: [f32; 4] = [0.11, 0.12, 0.14, 1.0];

/// Behind what is transparent.
const BEHIND: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

impl SheetDesc {
    /// So many pictures of that size, so many of them in a row.
    pub fn new(n_panes: usize, n_columns: usize, pane_size: [u32; 2]) -> Self {
        Self { n_panes, n_columns, pane_size }
    }
}

impl Pane {
    /// A picture and where it differs, or why there is none, between its label and its figures.
    pub fn new(
        label: impl Into<String>,
        pictures: Result<[Image; 2], String>,
        figures: impl Into<String>,
    ) -> Self {
        Self { label: label.into(), pictures, figures: figures.into() }
    }
}

impl Sheet {
    /// The sheet for so many panes.
    ///
    /// # Errors
    /// If it would have more pixels than a picture may.
    pub fn new(desc: SheetDesc) -> Result<Self, ImageError> {
        let [width, height] = desc.pane_size;
        let cell_width = width.max(MIN_CELL_WIDTH);
        let cell_height = height.saturating_mul(2).saturating_add(4 * LINE);
        let n_columns = desc.n_columns.clamp(1, desc.n_panes.max(1));
        let n_rows = desc.n_panes.div_ceil(n_columns);
        let span = |n: usize, each: u32| {
            u32::try_from(n).unwrap_or(u32::MAX).saturating_mul(each.saturating_add(GAP))
        };
        let image = ImageDesc::new(
            span(n_columns, cell_width).saturating_add(GAP),
            span(n_rows, cell_height).saturating_add(GAP + 3 * LINE),
        )
        .background(BACKGROUND);
        let desc = SheetDesc { n_columns, ..desc };
        Ok(Self { desc, cell: [cell_width, cell_height], image: image.checked()? })
    }

    /// The sheet as a picture; `scale` says in words what the differences are, and `end` is the difference at
    /// the end of the scale.
    pub fn draw(&self, panes: &[Pane], scale: &str, end: f64) -> Image {
        let ImageDesc { width, height, .. } = self.image;
        let mut sheet = Image::filled(width, height, BACKGROUND);
        for (idx, pane) in panes.iter().enumerate().take(self.desc.n_panes) {
            let [column, row] = [idx % self.desc.n_columns, idx / self.desc.n_columns];
            let left = GAP + column as u32 * (self.cell[0] + GAP);
            let top = GAP + row as u32 * (self.cell[1] + GAP);
            self.draw_pane(&mut sheet, pane, [left, top]);
        }
        draw_scale(&mut sheet, scale, end);
        sheet
    }

    fn draw_pane(&self, sheet: &mut Image, pane: &Pane, [left, top]: [u32; 2]) {
        let [width, height] = [self.cell[0], self.desc.pane_size[1]];
        write(sheet, &shortened(&pane.label, width as f32), [left, top]);
        match &pane.pictures {
            Ok([picture, difference]) => {
                put(sheet, picture, [left, top + LINE]);
                put(sheet, difference, [left, top + LINE + height + LINE / 2]);
            }
            Err(why) => {
                let n_lines = (2 * height / LINE).max(1) as usize;
                for (idx, line) in wrapped(why, width as f32).iter().take(n_lines).enumerate() {
                    write(sheet, line, [left, top + LINE + idx as u32 * LINE]);
                }
            }
        }
        for (idx, line) in wrapped(&pane.figures, width as f32).iter().take(2).enumerate() {
            let below = 3 * LINE / 2 + 2 * height + idx as u32 * LINE;
            write(sheet, line, [left, top + below]);
        }
    }
}

fn draw_scale(sheet: &mut Image, scale: &str, end: f64) {
    let (width, top) = (sheet.width(), sheet.height() - 3 * LINE - GAP / 2);
    for (idx, line) in wrapped(scale, (width - 2 * GAP) as f32).iter().take(2).enumerate() {
        write(sheet, line, [GAP, top + idx as u32 * LINE]);
    }
    let bar = [GAP + 50, top + 2 * LINE + 3];
    let mut colors = Image::filled(BAR[0], BAR[1], [0.0; 4]);
    for (idx, pixel) in colors.pixels_mut().iter_mut().enumerate() {
        let share = (idx as u32 % BAR[0]) as f32 / (BAR[0] - 1) as f32;
        let [r, g, b] = color(2.0 * share - 1.0);
        *pixel = [r, g, b, 1.0];
    }
    put(sheet, &colors, bar);
    let at = bar[1] - 3;
    let digits = format!("{}", (end * 1e9).round() / 1e9);
    write(sheet, &format!("−{digits}"), [GAP, at]);
    write(sheet, &format!("+{digits}"), [bar[0] + BAR[0] + 6, at]);
}

fn write(sheet: &mut Image, text: &str, [left, top]: [u32; 2]) {
    let at = [left as f32, top as f32];
    let label = Label::new(text, at).size_pixels(TEXT);
    draw_text(sheet, &label);
}

/// Puts a picture before black; what is outside of the sheet is cut off.
fn put(sheet: &mut Image, picture: &Image, [left, top]: [u32; 2]) {
    let (width, height) = (sheet.width() as usize, sheet.height() as usize);
    let rows = picture.pixels().chunks_exact(picture.width().max(1) as usize);
    for (y, row) in rows.enumerate().take(height.saturating_sub(top as usize)) {
        let start = (top as usize + y) * width + left as usize;
        let n = row.len().min(width.saturating_sub(left as usize));
        for (pixel, from) in sheet.pixels_mut()[start..start + n].iter_mut().zip(row) {
            *pixel = over(*from, BEHIND);
        }
    }
}

/// The text, with an ellipsis where it is too wide.
fn shortened(text: &str, width: f32) -> String {
    if measure_text(text, TEXT)[0] <= width {
        return text.to_owned();
    }
    let mut short = String::new();
    for c in text.chars() {
        if width < measure_text(&format!("{short}{c}…"), TEXT)[0] {
            break;
        }
        short.push(c);
    }
    short + "…"
}

/// The text in lines between words, each no wider than `width` unless a word is.
fn wrapped(text: &str, width: f32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if measure_text(&format!("{line} {word}"), TEXT)[0] <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.iter().map(|line| shortened(line, width)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pane(value: f32, size: [u32; 2]) -> Pane {
        let picture = Image::filled(size[0], size[1], [value, 0.0, 0.0, 1.0]);
        let difference = Image::filled(size[0], size[1], [0.0, value, 0.0, 1.0]);
        Pane {
            label: "a label".into(),
            pictures: Ok([picture, difference]),
            figures: "figures".into(),
        }
    }

    #[test]
    fn sheet_has_each_picture_and_its_difference() {
        let pane_size = [300, 40];
        let sheet = Sheet::new(SheetDesc { n_panes: 3, n_columns: 2, pane_size }).unwrap();
        let mut panes = vec![pane(0.25, pane_size), pane(0.5, pane_size)];
        panes.push(Pane { pictures: Err("it cannot be drawn".into()), ..pane(0.75, pane_size) });
        let image = sheet.draw(&panes, "what it means", 0.5);
        let count =
            |color: [f32; 4]| image.pixels().iter().filter(|pixel| **pixel == color).count();
        for value in [0.25, 0.5] {
            assert_eq!(count([value, 0.0, 0.0, 1.0]), 300 * 40, "{value}");
            assert_eq!(count([0.0, value, 0.0, 1.0]), 300 * 40, "{value}");
        }
        assert_eq!(count([0.75, 0.0, 0.0, 1.0]), 0, "it was not drawn");
        let last_row = image.pixels().len() - 1;
        assert_eq!(image.pixels()[last_row], BACKGROUND);
    }

    #[test]
    fn sheet_of_any_size() {
        for size in [[1, 1], [64, 64], [4000, 3]] {
            let sheet =
                Sheet::new(SheetDesc { n_panes: 1, n_columns: 9, pane_size: size }).unwrap();
            let image = sheet.draw(&[pane(0.5, size)], "a word", 1e-6);
            assert!(size[0] <= image.width() && 2 * size[1] < image.height());
        }
        let huge = SheetDesc { n_panes: 64, n_columns: 1, pane_size: [32768, 4096] };
        assert!(Sheet::new(huge).is_err());
    }

    #[test]
    fn sheet_text_fits() {
        let long = "slab_width 1, method image-aligned, and many words more than there is room for";
        assert!(shortened(long, 200.0).ends_with('…'));
        assert!(measure_text(&shortened(long, 200.0), TEXT)[0] <= 200.0);
        assert_eq!(shortened("short", 200.0), "short");
        let lines = wrapped(long, 200.0);
        assert!(1 < lines.len() && lines.iter().all(|line| measure_text(line, TEXT)[0] <= 200.0));
        assert_eq!(lines.join(" "), long);
    }
}
