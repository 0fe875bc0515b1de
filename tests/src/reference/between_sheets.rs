//! What lies between the sheets of densities along one ray (model §8): densities and gradients in the middle
//! of sheets, and between two of them.

use slabsplat_core::glam::DVec3;

/// A pixel's ray in one sheet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InSheet {
    /// `L`.
    pub(super) length: f64,
    /// `d`, 0 where `L` is 0.
    pub(super) density: f64,
    /// Slopes to the right and upwards, per world unit.
    pub(super) slopes: [f64; 2],
}

/// A point on a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) density: f64,
    /// Slopes to the right, upwards and along the ray; the last is per sheet.
    pub(super) slopes: DVec3,
}

/// What lies between the middles of two sheets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between {
    /// How much of the ray it is.
    pub(super) length: f64,
    /// Where it begins and where it ends.
    pub(super) ends: [Node; 2],
    /// How much more slopes are half way than in the mean of both.
    bulge: DVec3,
}

impl Between {
    /// Between the third and the fourth of six sheets, of which one at least holds something.
    pub(super) fn new(six: &[InSheet; 6]) -> Self {
        let lengths = [six[2].length, six[3].length];
        Self::with_ends(six, part_ends(nodes(six), lengths))
    }

    /// The same of two sheets that both hold something, from node to node, whatever they hold.
    pub(super) fn of_nodes(six: &[InSheet; 6]) -> Self {
        Self::with_ends(six, nodes(six))
    }

    fn with_ends(six: &[InSheet; 6], ends: [Node; 2]) -> Self {
        let [a, first, last, d] = [six[1], six[2], six[3], six[4]];
        let lateral = |axis: usize| {
            let slope = |sheet: &InSheet| sheet.slopes[axis];
            let outer = share(&first, &a) * (slope(&a) - slope(&first))
                + share(&last, &d) * (slope(&d) - slope(&last));
            -outer / 16.0
        };
        let density = |sheet: &InSheet| sheet.density;
        let outer = step(density, &last, &d) - step(density, &first, &a);
        let half_way = 7.0 / 6.0 * (last.density - first.density) - outer / 12.0;
        let along = half_way - 0.5 * (ends[0].slopes.z + ends[1].slopes.z);
        let evenness = share(&first, &last) * share(&last, &first);
        Self {
            length: 0.5 * (first.length + last.length),
            ends,
            bulge: evenness * DVec3::new(lateral(0), lateral(1), along),
        }
    }

    /// The slopes at a position from 0 to 1.
    pub(super) fn slopes(&self, position: f64) -> DVec3 {
        let [start, end] = self.ends;
        start.slopes.lerp(end.slopes, position) + 4.0 * position * (1.0 - position) * self.bulge
    }
}

/// The middles of the third and the fourth sheet.
fn nodes(six: &[InSheet; 6]) -> [Node; 2] {
    [node(&std::array::from_fn(|i| six[i])), node(&std::array::from_fn(|i| six[i + 1]))]
}

/// The middle of the sheet that has two others before it and behind it.
fn node(five: &[InSheet; 5]) -> Node {
    let [_, before, here, behind, _] = five;
    let at_point = |of: &dyn Fn(&InSheet) -> f64| {
        let change = |other: &InSheet| share(here, other) * (of(other) - of(here));
        of(here) - (change(before) + change(behind)) / 24.0
    };
    Node {
        density: at_point(&|sheet| sheet.density),
        slopes: DVec3::new(
            at_point(&|sheet| sheet.slopes[0]),
            at_point(&|sheet| sheet.slopes[1]),
            slope_along(five),
        ),
    }
}

/// Where the part between the middles of two sheets begins and ends, which hold those lengths: a sheet that
/// holds less is as far from the other one as it holds of it.
fn part_ends([first, last]: [Node; 2], [length, length_behind]: [f64; 2]) -> [Node; 2] {
    let seen_from = |here: Node, other: Node, share: f64| Node {
        density: here.density + share * (other.density - here.density),
        slopes: here.slopes.lerp(other.slopes, share),
    };
    if length <= length_behind {
        [seen_from(last, first, length / length_behind), last]
    } else {
        [first, seen_from(first, last, length_behind / length)]
    }
}

/// `r`: how much of a neighbour counts, seen from `here`.
fn share(here: &InSheet, other: &InSheet) -> f64 {
    if here.length <= 0.0 { 0.0 } else { (other.length / here.length).min(1.0) }
}

/// `Δ`, from `here` to a neighbour.
fn step(of: fn(&InSheet) -> f64, here: &InSheet, other: &InSheet) -> f64 {
    share(here, other) * (of(other) - of(here))
}

/// From both sides, or from the one that there is; where there are two sheets on either side, of the fourth
/// order.
fn slope_along([first, before, here, behind, last]: &[InSheet; 5]) -> f64 {
    let density = |sheet: &InSheet| sheet.density;
    let [r_before, r_behind] = [share(here, before), share(here, behind)];
    let near = step(density, here, behind) - step(density, here, before);
    let far = r_behind * step(density, behind, last) - r_before * step(density, before, first);
    near / (r_before + r_behind).max(1.0) + r_before * r_behind * 5.0 / 48.0 * (near - far)
}
