//! What lies between sheets: densities in the middle of each, and slopes there (model §8), of eight pixels at
//! once.
//!
//! ```text
//! r(here, other) = min(1, L_other/L_here),   Δ(here → other) = r·(a_other − a_here)
//! P(a) = a − (Δ(→ before) + Δ(→ behind))/24,   of the density and of its slopes across the ray
//! ```
//!
//! A sheet's density is a mean over its thickness, and `P` is what a smooth function is in the middle that
//! has such means. Slopes along the ray are differences of densities, of the fourth order too. Between nodes
//! densities are linear, as integrals want them; slopes follow a parabola through what they are half way, or
//! light would be another in the middle of sheets than between them.

use super::sheets::{DensitySheet, N_SHEETS};
use fearless_simd::{Simd, f32x8, prelude::*};

/// The middles of the two sheets between which a part of the ray lies.
pub(super) const N_NODES: usize = 2;

/// Something of eight pixels at each node.
pub(super) type AtNodes<S> = [f32x8<S>; N_NODES];

/// Something of eight pixels on a part: linear between its ends, and a parabola.
#[derive(Clone, Copy)]
pub(super) struct OnPart<S: Simd> {
    pub(super) ends: AtNodes<S>,
    /// How much more it is half way than in the mean of the ends.
    pub(super) bulge: f32x8<S>,
}

/// What a part of a ray goes from and to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ends {
    /// The node of the sheet that holds more, and as far from it as the other one holds of it (model §8).
    AsHeld,
    /// Both nodes (model §12): parts on end leave nothing out between them.
    Nodes,
}

/// What lies between the nodes on the rays of eight pixels.
pub(super) struct Parts<S: Simd> {
    /// How much of the ray it is, in `unit`s.
    pub(super) lengths: f32x8<S>,
    /// The scaled densities where they begin and where they end.
    pub(super) densities: AtNodes<S>,
    /// Slopes to the right and upwards, per world unit, and along the ray, per sheet; of no meaning where
    /// there is no light.
    pub(super) slopes: [OnPart<S>; 3],
    /// Which of them may be seen, a bit each.
    pub(super) seen: u64,
}

/// The rays of eight pixels in six sheets.
#[derive(Clone, Copy)]
pub(super) struct Rays8<S: Simd> {
    /// `L`.
    lengths: [f32x8<S>; N_SHEETS],
    /// `d`.
    densities: [f32x8<S>; N_SHEETS],
    /// `r`, seen from the second sheet to the first, from the third to the second and so on.
    shares_before: [f32x8<S>; N_SHEETS - 1],
    /// Seen from the first sheet to the second, from the second to the third and so on.
    shares_behind: [f32x8<S>; N_SHEETS - 1],
}

/// So that nothing is divided by 0.
const TINY: f32 = 1e-30;

/// The sheet of the first node.
const FIRST: usize = N_SHEETS / 2 - 1;

impl<S: Simd> Rays8<S> {
    /// Those of pixels of a row from `column` on.
    #[inline(always)]
    pub(super) fn of(
        simd: S,
        sheets: &[&DensitySheet; N_SHEETS],
        row: usize,
        column: usize,
    ) -> Self {
        let mut lengths = [f32x8::splat(simd, 0.0); N_SHEETS];
        let (mut densities, mut inverse) = (lengths, lengths);
        for (idx, sheet) in sheets.iter().enumerate() {
            let [length, weighted] = sheet.eight(simd, row, column, 0);
            lengths[idx] = length;
            inverse[idx] = 1.0 / length.max(f32x8::splat(simd, TINY));
            densities[idx] = weighted * inverse[idx];
        }
        let one = f32x8::splat(simd, 1.0);
        let (mut shares_before, mut shares_behind) = ([one; N_SHEETS - 1], [one; N_SHEETS - 1]);
        for idx in 0..N_SHEETS - 1 {
            shares_before[idx] = (lengths[idx] * inverse[idx + 1]).min(one);
            shares_behind[idx] = (lengths[idx + 1] * inverse[idx]).min(one);
        }
        Self { lengths, densities, shares_before, shares_behind }
    }

    /// How much of the ray lies between the nodes.
    #[inline(always)]
    pub(super) fn length(&self) -> f32x8<S> {
        (self.lengths[FIRST] + self.lengths[FIRST + 1]) * 0.5
    }

    /// How much of the ray the sheets of both nodes hold.
    #[inline(always)]
    pub(super) fn lengths(&self) -> AtNodes<S> {
        [self.lengths[FIRST], self.lengths[FIRST + 1]]
    }

    /// How much of the ray the sheet of the first node holds.
    #[inline(always)]
    pub(super) fn first_length(&self) -> f32x8<S> {
        self.lengths[FIRST]
    }

    /// The most that the parabola through the first node and those beside it comes to within half a sheet;
    /// the least, if `up` is −1 instead of 1 (model §12).
    #[inline(always)]
    pub(super) fn peak(&self, simd: S, up: f32) -> f32x8<S> {
        let here = self.at_node(FIRST, &self.densities);
        let before = self.at_node(FIRST - 1, &self.densities) - here;
        let before = self.shares_before[FIRST - 1] * before;
        let behind = self.at_node(FIRST + 1, &self.densities) - here;
        let behind = self.shares_behind[FIRST] * behind;
        let (bend, slope) = ((before + behind) * (0.5 * up), (behind - before) * (0.5 * up));
        let depth = -bend;
        let has_peak = depth.simd_gt(f32x8::splat(simd, 0.0)) & slope.abs().simd_le(depth);
        let at_peak = slope * slope * 0.25 / depth.max(f32x8::splat(simd, TINY));
        let at_face = slope.abs() * 0.5 + bend * 0.25;
        here + has_peak.select(at_peak, at_face) * up
    }

    /// Densities at the ends of the part between the nodes.
    #[inline(always)]
    pub(super) fn densities(&self, ends: Ends) -> AtNodes<S> {
        self.part_ends(ends, self.at_nodes(&self.densities))
    }

    /// What is the mean of each sheet, at the nodes.
    #[inline(always)]
    fn at_nodes(&self, means: &[f32x8<S>; N_SHEETS]) -> AtNodes<S> {
        [self.at_node(FIRST, means), self.at_node(FIRST + 1, means)]
    }

    #[inline(always)]
    fn at_node(&self, here: usize, means: &[f32x8<S>; N_SHEETS]) -> f32x8<S> {
        let before = self.shares_before[here - 1] * (means[here - 1] - means[here]);
        let behind = self.shares_behind[here] * (means[here + 1] - means[here]);
        means[here] - (before + behind) * (1.0 / 24.0)
    }

    /// What a part begins and ends with.
    #[inline(always)]
    fn part_ends(&self, ends: Ends, [first, last]: AtNodes<S>) -> AtNodes<S> {
        match ends {
            Ends::AsHeld => {
                let change = last - first;
                [
                    last - self.shares_before[FIRST] * change,
                    self.shares_behind[FIRST].mul_add(change, first),
                ]
            }
            Ends::Nodes => [first, last],
        }
    }

    /// Slopes to the right and upwards, per world unit, and along the ray, per sheet. `pixels` are the world
    /// units between pixels in each sheet.
    ///
    /// A function of its own, as few groups of pixels need it, and with the rest it takes long to compile.
    #[inline(never)]
    pub(super) fn slopes(
        &self,
        simd: S,
        sheets: &[&DensitySheet; N_SHEETS],
        position: [usize; 2],
        pixels: &[f32; N_SHEETS],
        ends: Ends,
    ) -> [OnPart<S>; 3] {
        simd.vectorize(
            #[inline(always)]
            || {
                let [right, up] = self.across(simd, sheets, position, pixels, ends);
                [right, up, self.along(simd, ends)]
            },
        )
    }

    /// Slopes to the right and upwards.
    #[inline(always)]
    fn across(
        &self,
        simd: S,
        sheets: &[&DensitySheet; N_SHEETS],
        [row, column]: [usize; 2],
        pixels: &[f32; N_SHEETS],
        ends: Ends,
    ) -> [OnPart<S>; 2] {
        let zero = f32x8::splat(simd, 0.0);
        let (mut right, mut up) = ([zero; N_SHEETS], [zero; N_SHEETS]);
        for idx in FIRST - 1..FIRST + 3 {
            let here = [self.lengths[idx], self.densities[idx]];
            let sheet = sheets[idx];
            let after = sheet.eight(simd, row, column, 1);
            let before = sheet.eight(simd, row, column, -1);
            let above = sheet.eight(simd, row - 1, column, 0);
            let below = sheet.eight(simd, row + 1, column, 0);
            let per_pixel = f32x8::splat(simd, 1.0 / pixels[idx]);
            right[idx] = per_pixel * difference(simd, here, after, before);
            up[idx] = per_pixel * difference(simd, here, above, below);
        }
        [self.across_part(ends, &right), self.across_part(ends, &up)]
    }

    /// A slope on the part of which that are the means in sheets.
    #[inline(always)]
    fn across_part(&self, ends: Ends, means: &[f32x8<S>; N_SHEETS]) -> OnPart<S> {
        let outer = self.shares_before[FIRST - 1] * (means[FIRST - 1] - means[FIRST])
            + self.shares_behind[FIRST + 1] * (means[FIRST + 2] - means[FIRST + 1]);
        let bulge = self.evenness() * outer * (-1.0 / 16.0);
        OnPart { ends: self.part_ends(ends, self.at_nodes(means)), bulge }
    }

    /// `λ`: 1 between sheets that hold as much of the ray, 0 where one holds nothing.
    #[inline(always)]
    fn evenness(&self) -> f32x8<S> {
        self.shares_before[FIRST] * self.shares_behind[FIRST]
    }

    /// Slopes along the ray: from both sides, or from the one that there is; where there are two sheets on
    /// either side, of the fourth order.
    #[inline(never)]
    fn along(&self, simd: S, ends: Ends) -> OnPart<S> {
        simd.vectorize(
            #[inline(always)]
            || self.along_inlined(simd, ends),
        )
    }

    #[inline(always)]
    fn along_inlined(&self, simd: S, ends: Ends) -> OnPart<S> {
        let d = &self.densities;
        let outer = self.backward(FIRST - 1) + self.forward(FIRST + 1);
        let half_way = (d[FIRST + 1] - d[FIRST]) * (7.0 / 6.0) - outer * (1.0 / 12.0);
        let nodes = [self.slope_at_node(simd, FIRST), self.slope_at_node(simd, FIRST + 1)];
        let ends = self.part_ends(ends, nodes);
        OnPart { ends, bulge: self.evenness() * (half_way - (ends[0] + ends[1]) * 0.5) }
    }

    #[inline(always)]
    fn slope_at_node(&self, simd: S, here: usize) -> f32x8<S> {
        let (r_behind, r_before) = (self.shares_behind[here], self.shares_before[here - 1]);
        let near = self.forward(here) + self.backward(here - 1);
        let far = r_behind * self.forward(here + 1) + r_before * self.backward(here - 2);
        let simple = near / (r_behind + r_before).max(f32x8::splat(simd, 1.0));
        (r_behind * r_before * (5.0 / 48.0)).mul_add(near - far, simple)
    }

    /// The change to the next sheet, seen from the one before.
    #[inline(always)]
    fn forward(&self, idx: usize) -> f32x8<S> {
        self.shares_behind[idx] * (self.densities[idx + 1] - self.densities[idx])
    }

    /// The change to the next sheet, seen from there.
    #[inline(always)]
    fn backward(&self, idx: usize) -> f32x8<S> {
        self.shares_before[idx] * (self.densities[idx + 1] - self.densities[idx])
    }
}

/// The change of the density from one neighbour to here and from here to the other one, weighted by how much
/// of each there is: a central difference within the grid, a one-sided one at its border, and next to nothing
/// where there is next to nothing on both sides.
///
/// It is taken from sums: densities would be rounded once more, and neighbours are nearly alike.
#[inline(always)]
fn difference<S: Simd>(
    simd: S,
    [length, density]: [f32x8<S>; 2],
    [length_after, after]: [f32x8<S>; 2],
    [length_before, before]: [f32x8<S>; 2],
) -> f32x8<S> {
    let forward = (-length_after).mul_add(density, after);
    let backward = (-length_before).mul_add(density, before);
    let both = (length_after + length_before).max(length);
    (forward - backward) / both.max(f32x8::splat(simd, TINY))
}
