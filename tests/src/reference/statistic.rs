//! One density for all on its ray (model §12).

use super::Premultiplied;
use super::between_sheets::InSheet;
use super::sheet::weight;
use slabsplat_core::{Compositing, Statistic};

/// What stands for all sheets of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OneForAll {
    pub(super) density: f64,
    /// By how much it counts, 0 to 1.
    pub(super) counting: f64,
}

/// The density that stands for all sheets of a ray, each of which has a share in the region; `None` if there
/// is none. Those between `ends` decide, beyond which they count the less the further, up to `rise`; and a
/// sheet counts in full from `full_length` on.
pub(super) fn of_sheets(
    statistic: Statistic,
    sheets: &[InSheet],
    shares: &[f64],
    (ends, rise): ([f64; 2], f64),
    full_length: f64,
) -> Option<OneForAll> {
    let ends = [ends[0] - rise, ends[1] + rise];
    let decides = |n: usize| match statistic {
        Statistic::Maximum => ((peak(sheets, n, 1.0) - ends[0]) / rise).clamp(0.0, 1.0),
        Statistic::Minimum => ((ends[1] - peak(sheets, n, -1.0)) / rise).clamp(0.0, 1.0),
        Statistic::Average => 1.0,
    };
    let weight = |n: usize| (sheets[n].length / full_length).min(1.0) * decides(n);
    let holds = |n: &usize| 0.0 < shares[*n] * sheets[*n].length;
    let counting = || (0..sheets.len()).filter(holds).filter(|&n| 0.0 < weight(n));
    let most_counting = counting().map(weight).fold(0.0, f64::max);
    let faded = |n: usize, up: f64, end: f64| end + weight(n) * (peak(sheets, n, up) - end);
    let shown = |best: f64, end: f64| end + (best - end) / most_counting;
    let density = match statistic {
        Statistic::Maximum => {
            shown(counting().map(|n| faded(n, 1.0, ends[0])).reduce(f64::max)?, ends[0])
        }
        Statistic::Minimum => {
            shown(counting().map(|n| faded(n, -1.0, ends[1])).reduce(f64::min)?, ends[1])
        }
        Statistic::Average => {
            let of_sheet = |n: usize| shares[n] * sheets[n].length;
            let length: f64 = counting().map(of_sheet).sum();
            let weighted: f64 = counting().map(|n| of_sheet(n) * sheets[n].density).sum();
            if length <= 0.0 {
                return None;
            }
            weighted / length
        }
    };
    Some(OneForAll { density, counting: most_counting })
}

/// What layers show together, each by the density that stands for all of it: what goes through all of them is
/// occluded by none, and colours count by extinction.
pub(super) fn joined(layers: impl Iterator<Item = Premultiplied>) -> Premultiplied {
    let (mut through, mut extinction, mut color) = (1.0, 0.0, [0.0; 3]);
    for layer in layers.filter(|layer| 0.0 < layer.opacity) {
        let of_layer = weight(Compositing::Extinction, layer.opacity);
        through *= 1.0 - layer.opacity;
        extinction += of_layer;
        for (sum, channel) in color.iter_mut().zip(layer.color) {
            *sum += of_layer * channel / layer.opacity;
        }
    }
    let opacity = 1.0 - through;
    match 0.0 < extinction {
        true => Premultiplied { color: color.map(|sum| opacity * sum / extinction), opacity },
        false => Premultiplied::default(),
    }
}

/// The most that the parabola through three nodes comes to within the sheet in the middle; the least, if
/// `up` is −1 instead of 1.
fn peak(sheets: &[InSheet], n: usize, up: f64) -> f64 {
    let here = node(sheets, n);
    let to = |other: usize| up * share(sheets, n, other) * (node(sheets, other) - here);
    let (before, behind) = (to(n - 1), to(n + 1));
    let (b, c) = (0.5 * (behind - before), 0.5 * (behind + before));
    let is_within = c < 0.0 && b.abs() <= -c;
    here + up * if is_within { -b * b / (4.0 * c) } else { 0.5 * b.abs() + 0.25 * c }
}

/// `P(d)`.
fn node(sheets: &[InSheet], n: usize) -> f64 {
    let density = |n: usize| sheets[n].density;
    let change = |other: usize| share(sheets, n, other) * (density(other) - density(n));
    density(n) - (change(n - 1) + change(n + 1)) / 24.0
}

/// `r`: by how much the sheet `other` counts, seen from sheet `n`.
fn share(sheets: &[InSheet], n: usize, other: usize) -> f64 {
    let length = sheets[n].length;
    if length <= 0.0 { 0.0 } else { (sheets[other].length / length).min(1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sheets that hold equally much, between sheets that hold nothing.
    fn sheets(densities: &[f64]) -> Vec<InSheet> {
        let empty = [InSheet::default(); 3];
        let held =
            densities.iter().map(|&density| InSheet { length: 0.5, density, slopes: [0.0; 2] });
        empty.into_iter().chain(held).chain(empty).collect()
    }

    fn of(statistic: Statistic, densities: &[f64], shares: &[f64]) -> Option<f64> {
        let outside = [1.0; 3];
        let shares: Vec<f64> = outside.iter().chain(shares).chain(&outside).copied().collect();
        let found = of_sheets(statistic, &sheets(densities), &shares, ([-49.0, 49.0], 1.0), 0.1)?;
        assert_eq!(found.counting, 1.0);
        Some(found.density)
    }

    fn assert_close(actual: Option<f64>, expected: f64) {
        assert!(actual.is_some_and(|actual| (actual - expected).abs() < 1e-12), "{actual:?}");
    }

    /// Means of `7 − (x − 0.2)²` over sheets of width 1: the parabola is found again.
    #[test]
    fn statistic_finds_the_peak_of_a_parabola() {
        let mean = |n: i32| 7.0 - (f64::from(n) - 0.2).powi(2) - 1.0 / 12.0;
        let densities: Vec<f64> = (-3..=3).map(mean).collect();
        assert_close(of(Statistic::Maximum, &densities, &[1.0; 7]), 7.0);
        let upside_down: Vec<f64> = densities.iter().map(|d| -d).collect();
        assert_close(of(Statistic::Minimum, &upside_down, &[1.0; 7]), -7.0);
        // Without the sheet in the middle, where the next best begins.
        let shares = [1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0];
        assert_close(of(Statistic::Maximum, &densities, &shares), 7.0 - 0.09);
    }

    #[test]
    fn statistic_is_a_mean() {
        assert_close(of(Statistic::Average, &[1.0, 2.0, 6.0], &[1.0; 3]), 3.0);
        assert_close(of(Statistic::Average, &[1.0, 2.0, 6.0], &[1.0, 0.0, 0.25]), 2.0);
        assert_eq!(of(Statistic::Average, &[1.0, 2.0], &[0.0; 2]), None);
        assert_eq!(of(Statistic::Maximum, &[], &[]), None);
    }

    /// At the rim, where sheets hold next to nothing.
    #[test]
    fn statistic_fades_out() {
        let thin = |length: f64| {
            let mut sheets = sheets(&[7.0]);
            sheets[3].length = length;
            [Statistic::Maximum, Statistic::Minimum, Statistic::Average].map(|statistic| {
                let found = of_sheets(statistic, &sheets, &[1.0; 7], ([-4.0, 19.0], 1.0), 0.1);
                found.map(|found| [found.density, found.counting])
            })
        };
        assert_eq!(thin(0.1), [Some([7.0, 1.0]); 3]);
        assert_eq!(thin(0.025), [Some([7.0, 0.25]); 3]);
        assert_eq!(thin(0.0), [None; 3]);
    }

    /// Of two sheets the one that holds little is drawn to the end of values.
    #[test]
    fn statistic_by_how_much_sheets_count() {
        let of = |statistic: Statistic, densities: [f64; 2], lengths: [f64; 2]| {
            let mut sheets = sheets(&[densities[0], 0.0, 0.0, 0.0, densities[1]]);
            for (n, length) in [(3, lengths[0]), (4, 0.0), (5, 0.0), (6, 0.0), (7, lengths[1])] {
                sheets[n].length = length;
            }
            of_sheets(statistic, &sheets, &[1.0; 11], ([-4.0, 19.0], 1.0), 0.1).unwrap().density
        };
        // 7 at 1 and 11 at ½ of the way from −5: 3.
        assert_eq!(of(Statistic::Maximum, [7.0, 11.0], [0.1, 0.05]), 7.0);
        // Both at a half, and a quarter: 7 is the better.
        assert_eq!(of(Statistic::Maximum, [7.0, 11.0], [0.05, 0.025]), 7.0);
        assert_eq!(of(Statistic::Maximum, [7.0, 20.0], [0.05, 0.05]), 20.0);
        assert_eq!(of(Statistic::Minimum, [7.0, 3.0], [0.05, 0.05]), 3.0);
    }

    /// What the transfer function does not show hides nothing, however much of it there is, and does not make
    /// the rim of anything more or less visible.
    #[test]
    fn statistic_of_densities_that_decide() {
        let of = |statistic: Statistic, decides: [f64; 2]| {
            let mut sheets = sheets(&[7.0, 0.0, 0.0, 0.0, 2.0]);
            for (n, length) in [(3, 0.025), (4, 0.0), (5, 0.0), (6, 0.0), (7, 0.1)] {
                sheets[n].length = length;
            }
            let found = of_sheets(statistic, &sheets, &[1.0; 11], (decides, 1.0), 0.1);
            found.map(|found| [found.density, found.counting])
        };
        // From −5: 7 at a quarter of the way is −2.
        assert_eq!(of(Statistic::Maximum, [-4.0, 20.0]), Some([2.0, 1.0]));
        assert_eq!(of(Statistic::Maximum, [3.0, 20.0]), Some([7.0, 0.25]));
        assert_eq!(of(Statistic::Minimum, [-5.0, 1.0]), None);
        assert_eq!(of(Statistic::Minimum, [-5.0, 2.0]), Some([2.0, 1.0]));
        // Half way to where it decides 2 counts for a half, from 1.5 on.
        assert_eq!(of(Statistic::Maximum, [2.5, 20.0]), Some([1.5 + 0.25 * 5.5 / 0.5, 0.5]));
        assert_eq!(of(Statistic::Average, [3.0, 20.0]), Some([3.0, 1.0]), "a mean is of all");
    }

    #[test]
    fn statistic_of_layers_by_hand() {
        let layer = |opacity: f64, gray: f64| Premultiplied { color: [opacity * gray; 3], opacity };
        let check = |layers: &[Premultiplied], expected: Premultiplied| {
            for layers in [layers.to_vec(), layers.iter().rev().copied().collect()] {
                let Premultiplied { color, opacity } = joined(layers.into_iter());
                let off = (opacity - expected.opacity).abs();
                let off = (0..3).map(|i| (color[i] - expected.color[i]).abs()).fold(off, f64::max);
                assert!(off < 1e-12, "{color:?} {opacity}, not {expected:?}");
            }
        };
        check(&[], Premultiplied::default());
        check(&[layer(0.0, 0.3)], Premultiplied::default());
        for opacity in [0.4, 1.0] {
            check(&[layer(opacity, 0.3), layer(0.0, 0.9)], layer(opacity, 0.3));
        }
        check(&[layer(0.5, 0.2), layer(0.5, 0.6)], layer(0.75, 0.4));
        check(&[layer(1.0, 0.2), layer(1.0, 0.6)], layer(1.0, 0.4));
        // An extinction twice as large.
        check(&[layer(0.5, 0.6), layer(0.75, 0.0)], layer(0.875, 0.2));
    }
}
