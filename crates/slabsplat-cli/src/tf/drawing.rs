//! A transfer function drawn with letters: how often values are, opacities over that, colours below.

use crate::plain::plain;
use slabsplat::{TransferFunction, ValueCounts, Volume};
use std::fmt::Write;
use std::io::IsTerminal;

/// Letters in a row, and rows.
const WIDTH: usize = 72;
const HEIGHT: usize = 12;

/// The drawing, with lines for its axis; colours only on a terminal that shows them.
pub(super) fn text(transfer: &TransferFunction, volume: Option<&Volume>) -> String {
    let range = slabsplat::plotted_range(transfer, volume);
    let heights = volume.and_then(|volume| ValueCounts::of(volume, WIDTH)).map(|it| heights(&it));
    let curve: Vec<usize> =
        (0..WIDTH).map(|column| row_of(transfer.opacity(value_of(range, column)))).collect();
    let mut text = String::new();
    for row in 0..HEIGHT {
        let label = match row {
            0 => "1",
            _ if row + 1 == HEIGHT => "0",
            _ => "",
        };
        let letters = (0..WIDTH).map(|column| {
            let is_counted =
                heights.as_ref().is_some_and(|heights| HEIGHT - row <= heights[column]);
            match curve[column] == row {
                true => '*',
                false if is_counted => ':',
                false => ' ',
            }
        });
        let letters: String = letters.collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{label:>1} |{}", letters.trim_end());
    }
    let _ = writeln!(text, "  +{}", "-".repeat(WIDTH));
    if shows_colors() {
        let _ = writeln!(text, "   {}\x1b[0m", strip(transfer, range));
    }
    let [lo, hi] = range.map(plain);
    let gap = WIDTH.saturating_sub(lo.len() + hi.len());
    let _ = writeln!(text, "   {lo}{}{hi}", " ".repeat(gap.max(1)));
    text
}

/// Rows of each column, on a logarithmic scale.
fn heights(counts: &ValueCounts) -> Vec<usize> {
    let height = |&count: &u64| (count as f64).ln_1p();
    let most = counts.counts.iter().map(height).fold(1.0, f64::max);
    counts
        .counts
        .iter()
        .map(|count| (height(count) / most * HEIGHT as f64).ceil() as usize)
        .collect()
}

fn row_of(opacity: f64) -> usize {
    ((1.0 - opacity) * (HEIGHT - 1) as f64).round() as usize
}

fn value_of([lo, hi]: [f64; 2], column: usize) -> f64 {
    let t = column as f64 / (WIDTH - 1) as f64;
    lo * (1.0 - t) + hi * t
}

/// As <https://no-color.org> asks.
fn shows_colors() -> bool {
    std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|it| it.is_empty())
}

fn strip(transfer: &TransferFunction, range: [f64; 2]) -> String {
    let cell = |column| {
        let [r, g, b] = transfer.color(value_of(range, column)).map(|c| (255.0 * c).round() as u8);
        format!("\x1b[48;2;{r};{g};{b}m ")
    };
    (0..WIDTH).map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawing_shows_the_ramp() {
        let transfer = TransferFunction::new([(0.0, 0.0), (71.0, 1.0)], [(0.0, [1.0; 3])]).unwrap();
        let text = text(&transfer, None);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), HEIGHT + 2, "no colours where nobody sees them");
        assert!(lines[0].starts_with("1 |") && lines[0].ends_with('*'), "{text}");
        assert!(lines[HEIGHT - 1].starts_with("0 |*"), "{text}");
        assert!(lines[HEIGHT + 1].trim().starts_with('0') && text.trim_end().ends_with("71"));
    }
}
