//! The inner loop: one footprint's weights over the pixels of a tile.
//!
//! ```text
//! for each row of the ellipse ρ ≤ ρ_max that has open pixels:
//!     find the run of open pixels inside; for each:
//!         half chord = √(R² − along·Y² − across·(X + lean·Y)²)
//!         visit pixel with weight(half chord, …)
//! ```
//!
//! The run of a row is found exactly, so corners of the ellipse's box (a fifth of it) cost nothing, and an
//! outer section of a ball, whose disc is smaller, costs only that disc. Half chords are measured in
//! samples of the table from the start: the quadratic form is scaled once a footprint.

use crate::open_pixels::OpenPixels;
use crate::raster::PixelShape;
use crate::sheet::Sheet;
use crate::tile::TILE_SIDE;
use std::ops::Range;

/// A footprint that is about to be splatted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    /// Its centre, in pixels from the tile's upper left corner.
    pub(crate) center: [f32; 2],
    /// The kernel's radius in index units.
    pub(crate) radius: f32,
    /// Where it ends, in index units from the centre: at the radius, or before it.
    pub(crate) rho_max: f32,
    /// Table samples per index unit.
    pub(crate) samples_per_index: f32,
}

/// A run of pixels inside a footprint, on one row of the tile.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) row: usize,
    pub(crate) columns: Range<usize>,
    /// The first pixel's place, right of and below the centre.
    dx: f32,
    dy: f32,
    /// `lean·Y`.
    shift: f32,
    /// The squared half chord in table samples: `[0] − [1]·(dx + shift)²`.
    half_chord: [f32; 2],
}

/// A pixel of a footprint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Where in a row of the table its weight is: the half chord in samples.
    pub(crate) position: f32,
    /// Pixels to the right of the centre.
    pub(crate) dx: f32,
    /// Pixels below the centre.
    pub(crate) dy: f32,
}

/// Adds `color` to a sheet, weighted.
#[inline(always)]
pub(crate) fn splat(
    sheet: &mut Sheet,
    open: &OpenPixels,
    shape: &PixelShape,
    footprint: &Footprint,
    color: [f32; 4],
    weight: impl Fn(Sample) -> f32,
) {
    for_each_run(open, shape, footprint, |run| {
        let pixels = sheet.run(run.row, run.columns.clone());
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let weight = weight(run.sample(column));
            for (sum, channel) in pixel.iter_mut().zip(color) {
                *sum += weight * channel;
            }
        }
    });
}

/// Calls `visit` with the run of every row on which the footprint covers open pixels.
#[inline(always)]
pub(crate) fn for_each_run(
    open: &OpenPixels,
    shape: &PixelShape,
    footprint: &Footprint,
    mut visit: impl FnMut(&Run),
) {
    let Footprint { center: [cx, cy], radius, rho_max, samples_per_index } = *footprint;
    let PixelShape { across, lean, along, .. } = *shape;
    let half_height = shape.half_extent[1] * rho_max;
    let form = samples_per_index * samples_per_index;
    for row in pixels_between(cy - half_height, cy + half_height, open.rows()) {
        let dy = row as f32 + 0.5 - cy;
        let half_width_squared = (rho_max * rho_max - along * dy * dy) / across;
        if half_width_squared <= 0.0 {
            continue;
        }
        let shift = lean * dy;
        let (middle, half_width) = (cx - shift, half_width_squared.sqrt());
        let columns = pixels_between(middle - half_width, middle + half_width, open.columns(row));
        if !columns.is_empty() {
            visit(&Run {
                row,
                dx: columns.start as f32 + 0.5 - cx,
                dy,
                columns,
                shift,
                half_chord: [form * (radius * radius - along * dy * dy), form * across],
            });
        }
    }
}

impl Footprint {
    /// Whether any pixel of it may be open.
    #[inline]
    pub(crate) fn is_open(&self, open: &OpenPixels, shape: &PixelShape) -> bool {
        let between = |axis: usize, within: Range<usize>| {
            let half = shape.half_extent[axis] * self.rho_max;
            pixels_between(self.center[axis] - half, self.center[axis] + half, within)
        };
        open.meets(&between(0, 0..TILE_SIDE), between(1, open.rows()))
    }
}

impl Run {
    /// The pixel that many columns after the first.
    #[inline(always)]
    pub(crate) fn sample(&self, column: usize) -> Sample {
        let dx = self.dx + column as f32;
        let [constant, square] = self.half_chord;
        let from_middle = dx + self.shift;
        // Rounding may make the square negative at the edge.
        let squared = (constant - square * from_middle * from_middle).max(0.0);
        Sample { position: squared.sqrt(), dx, dy: self.dy }
    }
}

/// The pixels of `within` that have their centres between two coordinates.
#[inline]
fn pixels_between(min: f32, max: f32, within: Range<usize>) -> Range<usize> {
    let [start, end] = [within.start, within.end].map(|pixel| pixel as f32);
    let first = ceil((min - 0.5).clamp(start, end));
    let end = (max + 0.5).clamp(start, end) as i32 as usize;
    first..end.max(first)
}

/// Rounds up what is neither negative nor large. `f32::ceil` is a call where the baseline instruction set
/// lacks it, and conversions to 64 bits take three times as long.
#[inline]
fn ceil(value: f32) -> usize {
    let down = value as i32;
    down as usize + usize::from((down as f32) < value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The runs hold every pixel of the ellipse, and their distances are those of the form.
    #[test]
    fn splat_runs_cover_the_ellipse() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        let side = 20;
        for _ in 0..300 {
            let [xx, yy] = [0, 1].map(|_| 0.02 + rng.f32());
            let xy = (rng.f32() * 1.8 - 0.9) * (xx * yy).sqrt();
            let determinant = xx * yy - xy * xy;
            let shape = PixelShape {
                across: xx,
                lean: xy / xx,
                along: determinant / xx,
                tilt: [0.0; 2],
                half_extent: [(yy / determinant).sqrt(), (xx / determinant).sqrt()],
                scale: 1.0,
                gain: 1.0,
            };
            let center = [0, 1].map(|_| rng.f32() * 30.0 - 5.0);
            let footprint =
                Footprint { center, radius: 2.0, rho_max: 1.9, samples_per_index: 64.0 };
            let mut half_chords = vec![None; side * side];
            for_each_run(&OpenPixels::all([side; 2]), &shape, &footprint, |run| {
                for (offset, column) in run.columns.clone().enumerate() {
                    let half_chord = run.sample(offset).position / 64.0;
                    half_chords[run.row * side + column] = Some(half_chord);
                }
            });
            for (pixel_idx, half_chord) in half_chords.iter().enumerate() {
                let dx = (pixel_idx % side) as f32 + 0.5 - center[0];
                let dy = (pixel_idx / side) as f32 + 0.5 - center[1];
                let rho = (xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy).max(0.0).sqrt();
                match half_chord {
                    Some(half_chord) => {
                        let expected = (4.0 - rho * rho).sqrt();
                        assert!((half_chord - expected).abs() < 1e-3, "{half_chord} {expected}");
                    }
                    None => assert!(1.899 < rho, "a pixel at {rho} was left out"),
                }
            }
        }
    }
}
