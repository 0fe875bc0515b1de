//! A picture of a transfer function: how often values are, and over that how opaque, in their colours.

use slabsplat_core::{Image, TransferFunction, Volume, number_text, round_ticks};

use super::values::ValueCounts;

/// Least pixels in a row and rows of a picture that has room for everything.
const LEAST_SIZE: [u32; 2] = [160, 120];

/// Pixels around the plot: left, right, above, below.
const MARGINS: [u32; 4] = [44, 20, 12, 46];

/// Rows of the strip of colours below the plot.
const STRIP_HEIGHT: u32 = 14;

/// Between the plot and its strip.
const GAP: u32 = 4;

/// Pixels of a dot of a digit.
const DOT: u32 = 2;

/// Columns of the dots of a character, with the gap to the next.
const CHARACTER_WIDTH: u32 = 4 * DOT;

const PAPER: [f64; 3] = [1.0; 3];
const GRID: [f64; 3] = [0.88; 3];
const COUNTS: [f64; 3] = [0.72; 3];
const INK: [f64; 3] = [0.13; 3];

/// How opaque the colour under the curve is.
const FILL_OPACITY: f64 = 0.75;

/// Draws `transfer` over the values of `volume`, or where there is none over its own: in gray how many voxels
/// have a value, on a logarithmic scale; opacities from 0 to 1 as a curve; below it the colours. A side of
/// the picture that is too short for that is lengthened.
pub fn plot_transfer(
    transfer: &TransferFunction,
    volume: Option<&Volume>,
    size: [u32; 2],
) -> Image {
    let size = [0, 1].map(|axis| size[axis].max(LEAST_SIZE[axis]));
    let range = plotted_range(transfer, volume);
    let mut plot = Plot::new(size, range);
    plot.grid();
    if let Some(counts) = volume.and_then(|volume| ValueCounts::of(volume, plot.width as usize)) {
        plot.counts(&counts);
    }
    plot.curve(transfer);
    plot.strip(transfer);
    plot.labels();
    plot.image
}

/// The values from the left to the right of a plot: those of the volume, else those of the transfer function;
/// the second is larger.
pub fn plotted_range(transfer: &TransferFunction, volume: Option<&Volume>) -> [f64; 2] {
    let of_volume = volume.and_then(|volume| volume.summary().range);
    let [lo, hi] = of_volume.unwrap_or_else(|| transfer.span());
    // As wide as numbers may be, ticks would have no room.
    let [lo, hi] = [lo, hi].map(|end| end.clamp(-1e300, 1e300));
    if lo < hi { [lo, hi] } else { [lo - 0.5 * lo.abs().max(1.0), hi + 0.5 * hi.abs().max(1.0)] }
}

struct Plot {
    image: Image,
    range: [f64; 2],
    /// Of the plot itself.
    width: u32,
    height: u32,
}

impl Plot {
    fn new([width, height]: [u32; 2], range: [f64; 2]) -> Self {
        let [left, right, above, below] = MARGINS;
        let image = Image::filled(width, height, pixel(PAPER));
        Self { image, range, width: width - left - right, height: height - above - below }
    }

    fn grid(&mut self) {
        for quarter in 0..=4 {
            let row = self.row_of(f64::from(quarter) / 4.0);
            (0..self.width).for_each(|column| self.mix(column, row, GRID, 1.0));
        }
        for tick in round_ticks(self.range, 5) {
            let column = self.column_of(tick);
            (0..self.height).for_each(|row| self.mix(column, row, GRID, 1.0));
        }
    }

    fn counts(&mut self, counts: &ValueCounts) {
        let height = |count: u64| (count as f64).ln_1p();
        let most = counts.counts.iter().map(|&count| height(count)).fold(0.0, f64::max);
        for (column, &count) in (0..self.width).zip(&counts.counts) {
            let top = self.row_of(height(count) / most.max(1.0));
            (top..self.height).for_each(|row| self.mix(column, row, COUNTS, 1.0));
        }
    }

    fn curve(&mut self, transfer: &TransferFunction) {
        let mut before = None;
        for column in 0..self.width {
            let value = self.value_of(column);
            let row = self.row_of(transfer.opacity(value));
            for below in row..self.height {
                self.mix(column, below, transfer.color(value), FILL_OPACITY);
            }
            // Steep parts have no gaps, and all are two pixels thick.
            let last = before.replace(row).unwrap_or(row);
            for thick in row.min(last)..=row.max(last) + 1 {
                self.mix(column, thick.min(self.height - 1), INK, 1.0);
            }
        }
    }

    fn strip(&mut self, transfer: &TransferFunction) {
        for column in 0..self.width {
            let color = transfer.color(self.value_of(column));
            for row in 0..STRIP_HEIGHT {
                self.mix(column, self.height + GAP + row, color, 1.0);
            }
        }
    }

    fn labels(&mut self) {
        let [left, _, above, _] = MARGINS;
        for tick in round_ticks(self.range, 5) {
            let text = number_text(tick);
            let middle = left + self.column_of(tick);
            let start = middle.saturating_sub(text.len() as u32 * CHARACTER_WIDTH / 2);
            self.write(&text, start, above + self.height + GAP + STRIP_HEIGHT + 6);
        }
        for (opacity, text) in [(0.0, "0"), (0.5, "0.5"), (1.0, "1")] {
            let end = left - 6;
            let row = above + self.row_of(opacity);
            let start = end - text.len() as u32 * CHARACTER_WIDTH;
            self.write(text, start, row.saturating_sub(2 * DOT));
        }
    }

    /// Writes from a pixel of the picture on, to the right and below.
    fn write(&mut self, text: &str, start: u32, top: u32) {
        for (idx, character) in (0..).zip(text.chars()) {
            for (row, dots) in (0..).zip(dots_of(character)) {
                for dot in (0..3).filter(|dot| dots >> (2 - dot) & 1 == 1) {
                    let corner = [start + idx * CHARACTER_WIDTH + dot * DOT, top + row * DOT];
                    for (x, y) in (0..DOT * DOT).map(|part| (part % DOT, part / DOT)) {
                        self.set([corner[0] + x, corner[1] + y], INK);
                    }
                }
            }
        }
    }

    fn column_of(&self, value: f64) -> u32 {
        let [lo, hi] = self.range;
        let t = (0.5 * value - 0.5 * lo) / (0.5 * hi - 0.5 * lo);
        (t * f64::from(self.width - 1)).round() as u32
    }

    fn value_of(&self, column: u32) -> f64 {
        let [lo, hi] = self.range;
        let t = f64::from(column) / f64::from(self.width - 1);
        lo * (1.0 - t) + hi * t
    }

    /// The row of a part of the height, 1 at the top.
    fn row_of(&self, part: f64) -> u32 {
        ((1.0 - part) * f64::from(self.height - 1)).round() as u32
    }

    /// Lays a colour on a pixel of the plot.
    fn mix(&mut self, column: u32, row: u32, color: [f64; 3], opacity: f64) {
        let at = [MARGINS[0] + column, MARGINS[2] + row];
        let was = self.image.pixel(at[0], at[1]);
        self.set(at, [0, 1, 2].map(|c| f64::from(was[c]) * (1.0 - opacity) + color[c] * opacity));
    }

    /// Sets a pixel of the picture, if it is one.
    fn set(&mut self, [x, y]: [u32; 2], color: [f64; 3]) {
        let (width, height) = (self.image.width(), self.image.height());
        if x < width && y < height {
            self.image.pixels_mut()[(y as usize) * (width as usize) + x as usize] = pixel(color);
        }
    }
}

fn pixel([r, g, b]: [f64; 3]) -> [f32; 4] {
    [r as f32, g as f32, b as f32, 1.0]
}

/// Five rows of three dots, the left one the highest bit.
fn dots_of(character: char) -> [u8; 5] {
    match character {
        '0' => [7, 5, 5, 5, 7],
        '1' => [2, 6, 2, 2, 7],
        '2' => [7, 1, 7, 4, 7],
        '3' => [7, 1, 7, 1, 7],
        '4' => [5, 5, 7, 1, 1],
        '5' => [7, 4, 7, 1, 7],
        '6' => [7, 4, 7, 5, 7],
        '7' => [7, 1, 2, 2, 2],
        '8' => [7, 5, 7, 5, 7],
        '9' => [7, 5, 7, 1, 7],
        '.' => [0, 0, 0, 0, 2],
        '-' => [0, 0, 7, 0, 0],
        'e' => [0, 7, 7, 4, 7],
        _ => [0; 5],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plot_shows_curve_and_colors() {
        let transfer = TransferFunction::new(
            [(0.0, 0.0), (100.0, 1.0)],
            [(0.0, [1.0, 0.0, 0.0]), (100.0, [0.0, 0.0, 1.0])],
        )
        .unwrap();
        let image = plot_transfer(&transfer, None, [300, 200]);
        assert_eq!([image.width(), image.height()], [300, 200]);
        let [left, right, above, below] = MARGINS;
        let strip = 200 - below + GAP + STRIP_HEIGHT / 2;
        assert_eq!(image.pixel(left, strip), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(image.pixel(299 - right, strip), [0.0, 0.0, 1.0, 1.0]);
        // The curve goes up: at the top on the right there is ink, on the left paper or grid.
        assert_eq!(image.pixel(299 - right, above), pixel(INK));
        assert_ne!(image.pixel(left, above), pixel(INK));
        for value in [f64::MIN, 0.0, 1e-300, f64::MAX] {
            let single = TransferFunction::new([(value, 0.5)], [(value, [0.5; 3])]).unwrap();
            assert_eq!(plot_transfer(&single, None, [0, 0]).width(), LEAST_SIZE[0], "{value}");
        }
    }
}
