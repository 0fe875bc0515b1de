//! The surfaces that rays pass between two sheets: put into their order, and laid over each other.

use super::groups::Group;
use super::sheets::{Eight, LANES};
use crate::pixels::sheet::Sheet;
use std::mem;

/// Where eight rays pass a surface each, and what is seen of it.
#[derive(Clone, Debug)]
pub(super) struct Passed {
    pub(super) group: Group,
    /// How many others were found before.
    pub(super) n_before: usize,
    /// Which of the rays pass any surface of the layer, a bit each.
    pub(super) passing: u64,
    /// From 0 at the first sheet to 1 at the second.
    pub(super) positions: Eight,
    /// 0 where none is passed.
    pub(super) opacities: Eight,
    /// Lit.
    pub(super) colors: [Eight; 3],
}

/// Writes what pixels show of all surfaces onto an empty sheet. Those of one layer come in their order, and
/// group by group; of `several` layers that is to be made.
pub(super) fn write(passed: &mut [Passed], are_of_several: bool, sheet: &mut Sheet) {
    if are_of_several {
        passed.sort_unstable_by_key(|it| (it.group.position(), it.n_before));
    }
    for of_group in passed.chunk_by_mut(|a, b| a.group.position() == b.group.position()) {
        if are_of_several {
            sort_by_position(of_group);
        }
        let seen = of_group.iter().fold(0, |seen, it| seen | it.passing);
        of_group[0].group.write(&sums(of_group), seen, sheet);
    }
}

/// Premultiplied colours and opacities of eight rays.
fn sums(in_order: &[Passed]) -> [Eight; 4] {
    let mut sums = [[0.0; LANES]; 4];
    for Passed { opacities, colors, .. } in in_order {
        for lane in 0..LANES {
            let opacity = (1.0 - sums[3][lane]) * opacities[lane];
            for (sums, colors) in sums.iter_mut().zip(colors) {
                sums[lane] += opacity * colors[lane];
            }
            sums[3][lane] += opacity;
        }
    }
    sums
}

/// Sorts what each ray passes; what is at one position keeps its order.
fn sort_by_position(passed: &mut [Passed]) {
    for (end, lane) in (1..passed.len()).flat_map(|end| (0..LANES).map(move |lane| (end, lane))) {
        for idx in (1..=end).rev() {
            let [before, here] = &mut passed[idx - 1..=idx] else { break };
            if before.positions[lane] <= here.positions[lane] {
                break;
            }
            before.swap(here, lane);
        }
    }
}

impl Passed {
    fn swap(&mut self, other: &mut Self, lane: usize) {
        mem::swap(&mut self.positions[lane], &mut other.positions[lane]);
        mem::swap(&mut self.opacities[lane], &mut other.opacities[lane]);
        for (channel, others) in self.colors.iter_mut().zip(&mut other.colors) {
            mem::swap(&mut channel[lane], &mut others[lane]);
        }
    }
}
