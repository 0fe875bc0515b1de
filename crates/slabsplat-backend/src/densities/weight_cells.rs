//! A transfer function cut into cells, on which integrals over densities are polynomials.

use super::{END, ROUNDING, ValueScale};
use slabsplat_core::{IsoRange, TransferFunction};

/// A piece of scaled densities on which the weight is nearly a cubic, and the colour linear.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::exhaustive_structs, reason = "its layout is what loops read")]
pub struct WeightCell {
    /// Where it begins.
    pub start: f64,
    /// How far it goes.
    pub width: f64,
    /// The weight, in powers of the position in the cell, 0 to 1.
    pub weight: [f64; 4],
    /// Red, green and blue: at the start, and how much more at the end.
    pub color: [[f64; 2]; 3],
}

/// What is integrated: the weight, and that times red, green, blue and the density.
const N_FUNCTIONS: usize = 5;

/// Those of the integral of a cubic times a linear function, but for the constant.
const N_POWERS: usize = 5;

impl WeightCell {
    /// The integrals from its start on: of the weight, and of that times red, green, blue and the density.
    /// By powers of the position in the cell, from the first on; three numbers fill each up to eight.
    pub fn integrals(&self) -> [[f64; 8]; N_POWERS] {
        let [red, green, blue] = self.color;
        let factors: [[f64; 2]; N_FUNCTIONS] =
            [[1.0, 0.0], red, green, blue, [self.start, self.width]];
        let mut powers = [[0.0; 8]; N_POWERS];
        for (function, [constant, slope]) in factors.into_iter().enumerate() {
            for (power, coefficient) in self.weight.into_iter().enumerate() {
                let [of_power, of_next] =
                    [power + 1, power + 2].map(|power| self.width / power as f64);
                powers[power][function] += of_power * coefficient * constant;
                powers[power + 1][function] += of_next * coefficient * slope;
            }
        }
        powers
    }
}

/// What cubics may miss, of a weight.
const ERROR: f64 = 1e-5;

/// Least width of a cell: nothing that is narrower than rounding.
const LEAST_WIDTH: f64 = 1.0 / (1 << 22) as f64;

/// The cells of a transfer function, where an opacity weighs that: from −END to END, rising, without a gap.
pub fn weight_cells(
    transfer: &TransferFunction,
    weight: impl Fn(f64) -> f64,
    scale: &ValueScale,
) -> Vec<WeightCell> {
    let at = |scaled: f64| {
        let value = scale.value(scaled);
        (weight(transfer.opacity(value)), transfer.color(value))
    };
    let mut cells = Cells { cells: Vec::new(), at: &at };
    let points = points(transfer, scale);
    points.windows(2).for_each(|pair| cells.add(pair[0], pair[1]));
    cells.cells
}

/// Ranges of scaled densities outside of which nothing shows.
pub fn visible_densities(transfer: &TransferFunction, scale: &ValueScale) -> Vec<[f32; 2]> {
    let on_scale = |range: IsoRange| {
        let ends = [range.lo, range.hi].map(|end| scale.unclamped(end).clamp(-2.0, 2.0));
        [(ends[0] - 2.0 * ROUNDING) as f32, (ends[1] + ROUNDING) as f32]
    };
    transfer.iso_ranges().into_iter().map(on_scale).collect()
}

/// Where either function has a step.
pub fn steps(transfer: &TransferFunction) -> impl Iterator<Item = f64> + '_ {
    fn of<const N: usize>(points: &[(f64, [f64; N])]) -> impl Iterator<Item = f64> + '_ {
        points.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[0].0)
    }
    of(transfer.opacity_points().points()).chain(of(transfer.color_points().points()))
}

/// Cells as they are made.
struct Cells<'a> {
    cells: Vec<WeightCell>,
    /// Weight and colour at a scaled density.
    at: &'a dyn Fn(f64) -> (f64, [f64; 3]),
}

impl Cells<'_> {
    /// Adds those of a piece between two points of the transfer function.
    fn add(&mut self, start: f64, end: f64) {
        let (width, middle) = (end - start, 0.5 * (start + end));
        let at = |t: f64| (self.at)(start + width * t);
        let weight = cubic(NODES.map(|node| at(node).0));
        let [c0, c1, c2, c3] = weight;
        let is_off = |t: &f64| ERROR < (((c3 * t + c2) * t + c1) * t + c0 - at(*t).0).abs();
        if LEAST_WIDTH < width && CHECKED.iter().any(is_off) {
            self.add(start, middle);
            self.add(middle, end);
            return;
        }
        let [near, far] = [NODES[0], NODES[3]].map(|node| at(node).1);
        let color = |channel: usize| {
            let slope = (far[channel] - near[channel]) / (NODES[3] - NODES[0]);
            [near[channel] - slope * NODES[0], slope]
        };
        let color = [0, 1, 2].map(color);
        self.cells.push(WeightCell { start, width, weight, color });
    }
}

/// Where cubics meet what they stand for: no end, where there may be a step.
const NODES: [f64; 4] = [0.038, 0.309, 0.691, 0.962];

/// Where they are compared with it.
const CHECKED: [f64; 6] = [0.002, 0.14, 0.41, 0.59, 0.86, 0.998];

/// The coefficients of the cubic through four values at the nodes.
fn cubic(values: [f64; 4]) -> [f64; 4] {
    // Newton's divided differences, and then powers.
    let mut c = values;
    for order in 1..4 {
        for idx in (order..4).rev() {
            c[idx] = (c[idx] - c[idx - 1]) / (NODES[idx] - NODES[idx - order]);
        }
    }
    let [x0, x1, x2, _] = NODES;
    [
        c[0] - c[1] * x0 + c[2] * x0 * x1 - c[3] * x0 * x1 * x2,
        c[1] - c[2] * (x0 + x1) + c[3] * (x0 * x1 + x0 * x2 + x1 * x2),
        c[2] - c[3] * (x0 + x1 + x2),
        c[3],
    ]
}

/// The points of both functions, scaled, and both ends; rising, none twice.
fn points(transfer: &TransferFunction, scale: &ValueScale) -> Vec<f64> {
    let scaled = transfer.positions().map(|value| scale.unclamped(value));
    let mut points: Vec<f64> = scaled.filter(|point| point.abs() < END).collect();
    points.extend([-END, END]);
    points.sort_by(f64::total_cmp);
    points.dedup();
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::Compositing;

    /// From end to end, over a step and up to where extinction is cut off.
    #[test]
    fn weight_cells_are_the_function() {
        let opacities = vec![(0.0, [0.0]), (40.0, [1.0]), (40.0, [0.2]), (100.0, [0.7])];
        let colors = vec![(10.0, [0.9, 0.1, 0.4]), (60.0, [0.2, 0.7, 0.4])];
        let transfer = TransferFunction::new(opacities, colors).unwrap();
        let scale = ValueScale::new(Some([-20.0, 140.0]), [0.0, 100.0]);
        for &compositing in Compositing::ALL {
            let weight = |opacity| compositing.weight(opacity);
            let cells = weight_cells(&transfer, weight, &scale);
            assert_eq!((cells[0].start, steps(&transfer).collect::<Vec<_>>()), (-END, vec![40.0]));
            let ends = cells.iter().skip(1).map(|cell| cell.start).chain([END]);
            for (cell, end) in cells.iter().zip(ends) {
                assert!((cell.start + cell.width - end).abs() < 1e-12, "{cell:?} {end}");
                for t in [0.1, 0.5, 0.9] {
                    let value = scale.value(cell.start + t * cell.width);
                    let [c0, c1, c2, c3] = cell.weight;
                    let off = c0 + t * (c1 + t * (c2 + t * c3)) - weight(transfer.opacity(value));
                    // A cell that is as narrow as rounding may hold the end of extinction.
                    assert!(off.abs() < 2.0 * ERROR || cell.width <= LEAST_WIDTH, "{off} {cell:?}");
                    let red = cell.color[0][0] + t * cell.color[0][1];
                    assert!((red - transfer.color(value)[0]).abs() < 1e-9, "{red} {cell:?}");
                }
            }
        }
    }
}
