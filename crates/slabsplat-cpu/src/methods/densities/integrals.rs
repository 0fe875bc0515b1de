//! Pre-integrated classification (Engel, Kraus & Ertl, "High-Quality Pre-Integrated Volume Rendering Using
//! Hardware-Accelerated Pixel Shading", Graphics Hardware 2001): the mean opacity and colour of a part of a
//! ray on which the density goes evenly from one value to another (model §8).
//!
//! With running integrals over the density a mean is a difference of two:
//!
//! ```text
//! I(x) = ∫ᵡ f(d) dd,   f = μ, μ·r, μ·g, μ·b, μ·d
//! W = (I(b) − I(a))/(b − a)
//! ```
//!
//! In the cells into which the transfer function is cut the weight is nearly a cubic; colours and the
//! density are linear there, so that all integrals are of one and the same weight, and colours and positions
//! are true means. They are in 64 bits, as differences are taken.

use super::sheets::Eight;
use crate::sections::cut::bits;
use fearless_simd::{Simd, f64x8, prelude::*};
use slabsplat_backend::densities::{self, END, NOTHING, ROUNDING, ValueScale, WeightCell};
use slabsplat_core::{Compositing, TransferFunction};

/// A number for each, in as many lanes as a vector has.
type Lanes = [f64; 8];

/// Those of the integral of a cubic times a linear function.
const N_POWERS: usize = 6;

/// A piece of densities; vectors of it do not cross cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Cell {
    /// The integrals up to its start, and from there, in powers of the position in the cell, 0 to 1.
    powers: [Lanes; N_POWERS],
    start: f64,
    per_width: f64,
}

/// Running integrals of one transfer function.
#[derive(Debug)]
pub(super) struct Integrals {
    /// Rising.
    cells: Vec<Cell>,
    /// The first cell that may hold densities from `−END + n·2·END/N_STARTS` on.
    starts: Vec<u32>,
    /// Between these anything may show, scaled.
    visible: Vec<[f32; 2]>,
    plateaus: Plateaus,
}

/// Where a density hardly changes along a part, and what it is there.
#[derive(Debug)]
struct Plateaus {
    transfer: TransferFunction,
    compositing: Compositing,
    scale: ValueScale,
    /// Where the transfer function has a step: value, and scaled.
    steps: Vec<(f64, f64)>,
}

/// What a part of a ray is in the mean.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    /// Of what the compositing sums.
    weight: f32,
    /// Of the colour, weighted with that.
    color: [f32; 3],
    /// Where on the part that weight lies in the mean: 0 at its start, 1 at its end.
    position: f32,
}

/// The same of eight parts: weights and colours of 0 where nothing shows.
#[derive(Default)]
pub(super) struct Means {
    pub(super) weights: Eight,
    pub(super) colors: [Eight; 3],
    pub(super) positions: Eight,
}

/// Parts of the densities that have a first cell each.
const N_STARTS: usize = 1024;

impl Integrals {
    pub(super) fn new(
        transfer: &TransferFunction,
        compositing: Compositing,
        scale: &ValueScale,
    ) -> Self {
        let weight = |opacity: f64| compositing.weight(opacity);
        let mut sums = [0.0; 8];
        let cells = densities::weight_cells(transfer, weight, scale);
        let cells: Vec<Cell> = cells.iter().map(|cell| Cell::new(cell, &mut sums)).collect();
        let first = |start: usize| {
            let density = END * (2.0 * start as f64 / N_STARTS as f64 - 1.0);
            cells.partition_point(|cell| cell.start <= density).saturating_sub(1) as u32
        };
        let starts = (0..=N_STARTS).map(first).collect();
        Self {
            cells,
            starts,
            visible: densities::visible_densities(transfer, scale),
            plateaus: Plateaus {
                transfer: transfer.clone(),
                compositing,
                scale: *scale,
                steps: densities::steps(transfer)
                    .map(|step| (step, scale.unclamped(step)))
                    .collect(),
            },
        }
    }

    /// Ranges of scaled densities outside of which nothing shows.
    pub(super) fn visible(&self) -> &[[f32; 2]] {
        &self.visible
    }

    pub(super) fn resident_bytes(&self) -> usize {
        self.cells.capacity() * size_of::<Cell>() + self.starts.capacity() * size_of::<u32>()
    }

    /// Parts from some scaled densities to others, as far as they are `seen`, a bit each. A function of its
    /// own, as the rest has other vectors.
    #[inline(never)]
    pub(super) fn means<S: Simd>(&self, simd: S, [starts, ends]: [Eight; 2], seen: u64) -> Means {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut means = Means::default();
                for lane in bits(seen) {
                    let mean = self.mean(simd, [starts[lane], ends[lane]]);
                    let Some(mean) = mean else { continue };
                    means.weights[lane] = mean.weight;
                    means.positions[lane] = mean.position;
                    for (colors, color) in means.colors.iter_mut().zip(mean.color) {
                        colors[lane] = color;
                    }
                }
                means
            },
        )
    }

    /// A part from one scaled density to another; `None` if nothing of it shows.
    #[inline(always)]
    fn mean<S: Simd>(&self, simd: S, ends: [f32; 2]) -> Option<Mean> {
        let [a, b] = ends.map(|end| f64::from(end).clamp(-END, END));
        let width = b - a;
        if width.abs() <= 2.0 * ROUNDING {
            return self.plateaus.mean(0.5 * (a + b));
        }
        let sums: Lanes = (self.up_to(simd, b) - self.up_to(simd, a)).into();
        let per_width = 1.0 / width;
        let weight = sums[0] * per_width;
        if weight <= NOTHING {
            return None;
        }
        let per_sum = 1.0 / sums[0];
        Some(Mean {
            weight: weight as f32,
            color: [1, 2, 3].map(|channel| (sums[channel] * per_sum) as f32),
            position: ((sums[4] * per_sum - a) * per_width).clamp(0.0, 1.0) as f32,
        })
    }

    /// The integrals up to a density.
    #[inline(always)]
    fn up_to<S: Simd>(&self, simd: S, density: f64) -> f64x8<S> {
        let start = (density + END) * (N_STARTS as f64 / (2.0 * END));
        let mut idx = self.starts[(start as usize).min(N_STARTS)] as usize;
        while idx + 1 < self.cells.len() && self.cells[idx + 1].start <= density {
            idx += 1;
        }
        let cell = &self.cells[idx];
        let t = f64x8::splat(simd, (density - cell.start) * cell.per_width);
        let [rest @ .., last] = &cell.powers;
        let mut sums = f64x8::from_slice(simd, last);
        for powers in rest.iter().rev() {
            sums = sums.mul_add(t, f64x8::from_slice(simd, powers));
        }
        sums
    }
}

impl Cell {
    /// The integrals on a cell, where they have come to `sums` at its start, and come to them at its end.
    fn new(cell: &WeightCell, sums: &mut Lanes) -> Self {
        let mut powers = [*sums; N_POWERS];
        powers[1..].copy_from_slice(&cell.integrals());
        for powers in &powers[1..] {
            sums.iter_mut().zip(powers).for_each(|(sum, term)| *sum += term);
        }
        Self { start: cell.start, per_width: 1.0 / cell.width, powers }
    }
}

impl Plateaus {
    /// A part of one density.
    #[cold]
    fn mean(&self, scaled: f64) -> Option<Mean> {
        let is_before = |(_, step): &&(f64, f64)| scaled < *step && *step - ROUNDING <= scaled;
        let value = match self.steps.iter().find(is_before) {
            Some((value, _)) => *value,
            None => self.scale.value(scaled),
        };
        // What falls to 0 at a step on its far side is 0 a rounding before it, too.
        let behind = self.scale.value(scaled + ROUNDING);
        let opacity = self.transfer.opacity(value);
        if opacity <= 0.0 || self.transfer.opacity(value.max(behind)) <= 0.0 {
            return None;
        }
        Some(Mean {
            weight: self.compositing.weight(opacity) as f32,
            color: self.transfer.color(value).map(|channel| channel as f32),
            position: 0.5,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use slabsplat_seeds::for_each_seed;

    /// Against a sum over many points of the part.
    #[test]
    fn integrals_are_means_over_parts() {
        let level = Level::new();
        for_each_seed(1, |mut rng| {
            for _ in 0..60 {
                let mut positions: Vec<f64> = (0..6).map(|_| 100.0 * rng.f64()).collect();
                positions.sort_by(f64::total_cmp);
                if rng.bool() {
                    positions[3] = positions[2];
                }
                let opacities =
                    positions.iter().map(|&x| (x, 0.95 * rng.f64())).collect::<Vec<_>>();
                let colors = vec![(10.0, [0.9, 0.1, 0.4]), (60.0, [0.2, 0.7, 0.4])];
                let transfer = TransferFunction::new(opacities, colors).unwrap();
                let scale = ValueScale::new(Some([0.0, 100.0]), [positions[0], positions[5]]);
                let compositing = Compositing::ALL[rng.usize(..Compositing::ALL.len())];
                let integrals = Integrals::new(&transfer, compositing, &scale);
                for _ in 0..50 {
                    let start = 1.8 * rng.f32() - 0.9;
                    let reach = [1.0, 0.1, 1e-3][rng.usize(..3)];
                    let ends = [start, start + reach * (rng.f32() - 0.5)];
                    let mean = dispatch!(level, simd => integrals.mean(simd, ends));
                    check(&mean.unwrap_or_default(), ends, |density| {
                        let value = scale.value(density);
                        let weight = compositing.weight(transfer.opacity(value));
                        (weight, transfer.color(value))
                    });
                }
            }
        });
    }

    fn check(mean: &Mean, ends: [f32; 2], at: impl Fn(f64) -> (f64, [f64; 3])) {
        const N: usize = 4000;
        let [start, end] = ends.map(f64::from);
        let (mut sum, mut red, mut position) = (0.0, 0.0, 0.0);
        for idx in 0..N {
            let t = (idx as f64 + 0.5) / N as f64;
            let (weight, color) = at(start + t * (end - start));
            sum += weight / N as f64;
            red += weight * color[0] / N as f64;
            position += weight * t / N as f64;
        }
        // A step lies between two points of the sum.
        let bound = 3.0 / N as f64;
        assert!((sum - f64::from(mean.weight)).abs() < bound, "{mean:?} {sum} {ends:?}");
        if 0.01 < sum && 1e-4 < (end - start).abs() {
            let [red, position] = [red, position].map(|moment| moment / sum);
            let off = (red - f64::from(mean.color[0])).abs()
                + (position - f64::from(mean.position)).abs();
            assert!(off < 0.02 / sum.min(1.0), "{mean:?} {red} {position} {ends:?}");
        }
    }
}
