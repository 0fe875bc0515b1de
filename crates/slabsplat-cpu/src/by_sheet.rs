//! The second level of the toss (paper §7): a tile's voxels by the sheet that each goes to first.

use crate::voxel::Voxel;
use std::ops::Range;

/// Voxels sorted by sheet; equals keep their order. The voxels themselves are sorted, not their places: they are then
/// read front to back, once for every sheet that they meet.
#[derive(Debug, Default)]
pub(crate) struct BySheet {
    first_sheet: usize,
    /// Where each sheet's voxels start, and where the last one's end.
    starts: Vec<u32>,
    sheets: Vec<u32>,
    voxels: Vec<Voxel>,
}

impl BySheet {
    /// Sorts `voxels` by `sheet_of`.
    pub(crate) fn sort<'a>(
        &mut self,
        voxels: impl Iterator<Item = &'a Voxel> + Clone,
        sheet_of: impl Fn(&Voxel) -> usize,
    ) {
        self.sheets.clear();
        self.sheets.extend(voxels.clone().map(|voxel| sheet_of(voxel) as u32));
        let first = self.sheets.iter().copied().min().unwrap_or(0);
        let last = self.sheets.iter().copied().max().unwrap_or(0);
        self.first_sheet = first as usize;
        self.starts.clear();
        // One entry more than counts need: while voxels are placed, `starts[sheet + 1]` is where the next one
        // of a sheet goes, and ends up as where the sheet after it starts.
        self.starts.resize((last - first) as usize + 3, 0);
        for sheet in &self.sheets {
            self.starts[(sheet - first) as usize + 2] += 1;
        }
        let mut sum = 0;
        for count in &mut self.starts {
            sum += *count;
            *count = sum;
        }
        if self.voxels.len() < self.sheets.len() {
            self.voxels.resize(self.sheets.len(), Voxel::default());
        }
        for (sheet, voxel) in self.sheets.iter().zip(voxels) {
            let next = &mut self.starts[(sheet - first) as usize + 1];
            self.voxels[*next as usize] = *voxel;
            *next += 1;
        }
    }

    /// The sheets in which voxels start.
    pub(crate) fn sheets(&self) -> Range<usize> {
        if self.sheets.is_empty() {
            return 0..0;
        }
        self.first_sheet..self.first_sheet + self.starts.len() - 2
    }

    pub(crate) fn resident_bytes(&self) -> usize {
        self.voxels.capacity() * size_of::<Voxel>() + 4 * (self.sheets.capacity() + self.starts.capacity())
    }

    /// The voxels that start in `sheets`, by sheet and then in the order in which they came.
    pub(crate) fn starting_in(&self, sheets: Range<usize>) -> &[Voxel] {
        let n_sheets = self.sheets().len();
        let place = |sheet: usize| sheet.saturating_sub(self.first_sheet).min(n_sheets);
        let [start, end] = [sheets.start, sheets.end].map(|sheet| self.starts[place(sheet)] as usize);
        &self.voxels[start..end.max(start)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_sheet_is_a_stable_sort() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut sorted = BySheet::default();
        for n_voxels in [0, 1, 7, 500, 20] {
            let voxel = |id: usize, sheet: usize| Voxel {
                point: [id as f32, 0.0, sheet as f32],
                ..Voxel::default()
            };
            let voxels: Vec<Voxel> = (0..n_voxels).map(|id| voxel(id, rng.usize(5..25))).collect();
            sorted.sort(voxels.iter(), |voxel| voxel.point[2] as usize);
            for first in 0..30 {
                for end in first..30 {
                    let mut expected: Vec<[f32; 3]> = voxels.iter().map(|v| v.point).collect();
                    expected.retain(|point| (first..end).contains(&(point[2] as usize)));
                    expected.sort_by_key(|point| point[2] as usize);
                    let actual = sorted.starting_in(first..end).iter().map(|v| v.point);
                    assert_eq!(actual.collect::<Vec<_>>(), expected, "{first}..{end}");
                }
            }
        }
    }
}
