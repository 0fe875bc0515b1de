//! The mean opacity and colour of a part of a ray on which the density goes evenly from one value to another
//! (model §8).

use super::GaussLegendre;
use super::sheet::weight;
use slabsplat_core::{Compositing, TransferFunction};
use std::sync::LazyLock;

/// What a part of a ray is in the mean.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// `W`: of `μ`, or of `α`.
    pub(super) weight: f64,
    /// Of the colour, weighted with that.
    pub(super) color: [f64; 3],
    /// Where on the part that weight lies in the mean: 0 at its start, 1 at its end.
    pub(super) position: f64,
}

/// The part from density `start` to `end`; `None` if nothing of it is visible.
pub(super) fn part(
    transfer: &TransferFunction,
    compositing: Compositing,
    [start, end]: [f64; 2],
) -> Option<Part> {
    let at = |position: f64| {
        let density = start + (end - start) * position;
        let weight = weight(compositing, transfer.opacity(density));
        let [r, g, b] = transfer.color(density);
        [weight, weight * r, weight * g, weight * b, weight * position]
    };
    let mut sums = [0.0; 5];
    for [from, to] in pieces(transfer, [start, end]) {
        let of_piece = RULE.integrate_each(from, to, at);
        sums.iter_mut().zip(of_piece).for_each(|(sum, term)| *sum += term);
    }
    let [weight, r, g, b, position] = sums;
    let color = [r, g, b].map(|sum| sum / weight);
    (0.0 < weight).then_some(Part { weight, color, position: position / weight })
}

/// For a piece on which the transfer function has no point.
static RULE: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(24));

/// The pieces between the points of the transfer function, as positions on the part.
fn pieces(transfer: &TransferFunction, [start, end]: [f64; 2]) -> Vec<[f64; 2]> {
    let position = |density: f64| (density - start) / (end - start);
    let mut positions: Vec<f64> = transfer
        .positions()
        .map(position)
        .filter(|position| 0.0 < *position && *position < 1.0)
        .collect();
    positions.extend([0.0, 1.0]);
    positions.sort_by(f64::total_cmp);
    positions.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}
