//! The second level of the toss (paper §7): a tile's voxels by the sheet that each goes to first.

use slabsplat_core::FrameHandle;
use slabsplat_traverse::Buckets;
use std::ops::Range;

/// Voxels that are read at once.
pub(crate) const N_AT_ONCE: usize = Buckets::<u32>::N_AT_ONCE;

/// Voxels sorted by class and sheet; equals keep their order. The voxels themselves are sorted, not their
/// slots: they are then read front to back, once for every sheet that they meet.
#[derive(Debug)]
pub(crate) struct BySheet<V> {
    /// The sheets to which any voxel goes first.
    sheets: Range<usize>,
    /// The sheets that have buckets.
    with_buckets: Range<usize>,
    /// A bucket for each class and sheet.
    buckets: Buckets<V>,
}

/// Some of the voxels, one after the other.
#[derive(Debug)]
pub(crate) struct Run<'a, V> {
    voxels: &'a [V],
    start: usize,
    /// How many.
    pub(crate) len: usize,
}

impl<V> Default for BySheet<V> {
    fn default() -> Self {
        Self { sheets: 0..0, with_buckets: 0..0, buckets: Buckets::default() }
    }
}

impl<V: Copy + Default> BySheet<V> {
    /// Sorts the voxels of `runs`, of which `key_of` returns the class, below `n_classes`, and the sheet, one
    /// of `sheets`; forgets others. If the frame is cancelled they may be any of them, or none.
    pub(crate) fn sort<'a>(
        &mut self,
        n_classes: usize,
        sheets: Range<usize>,
        runs: impl Iterator<Item = &'a [V]> + Clone,
        key_of: impl Fn(&V) -> (usize, usize),
        frame: &FrameHandle,
    ) where
        V: 'a,
    {
        // Where slabs are thin and there is no voxel, even empty buckets would be felt.
        let is_empty = runs.clone().all(<[V]>::is_empty);
        let n_sheets = if is_empty { 0 } else { sheets.len() };
        let bucket_of = |voxel: &V| {
            let (class, sheet) = key_of(voxel);
            class * n_sheets + sheet - sheets.start
        };
        self.buckets.sort(n_classes * n_sheets, runs, bucket_of, |voxel| *voxel, frame);
        let ends_of = |class: usize| {
            let first = class * n_sheets;
            let ends = self.buckets.ends_held(first..first + n_sheets)?;
            Some(ends.map(|bucket| sheets.start + bucket - first))
        };
        let ends = (0..n_classes).filter_map(ends_of);
        let ends = ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        self.sheets = ends.map_or(0..0, |[first, last]| first..last + 1);
        self.with_buckets = sheets.start..sheets.start + n_sheets;
    }
}

impl<V> BySheet<V> {
    /// The sheets to which voxels go first.
    pub(crate) fn sheets(&self) -> Range<usize> {
        self.sheets.clone()
    }

    pub(crate) fn resident_bytes(&self) -> usize {
        self.buckets.resident_bytes()
    }

    /// The voxels of a class that go first to `sheets`, by sheet and then in the order in which they came.
    pub(crate) fn starting_in(&self, class: usize, sheets: Range<usize>) -> Run<'_, V> {
        let n_sheets = self.with_buckets.len();
        let bucket = |sheet: usize| {
            class * n_sheets + sheet.saturating_sub(self.with_buckets.start).min(n_sheets)
        };
        let slots = self.buckets.slots(bucket(sheets.start)..bucket(sheets.end));
        Run { voxels: self.buckets.items(), start: slots.start, len: slots.len() }
    }
}

impl<V> Clone for Run<'_, V> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<V> Copy for Run<'_, V> {}

impl<'a, V> Run<'a, V> {
    /// The voxels from `first` on. There may be fewer in the run; then the rest is of no meaning.
    #[inline(always)]
    pub(crate) fn at_once(&self, first: usize) -> &'a [V; N_AT_ONCE] {
        let voxels = self.voxels[self.start + first..].first_chunk();
        voxels.expect("there is room behind the last voxel")
    }

    #[inline(always)]
    pub(crate) fn voxel(&self, idx: usize) -> &'a V {
        &self.voxels[self.start + idx]
    }

    /// The same voxels in runs of up to so many.
    #[inline(always)]
    pub(crate) fn pieces(self, n_voxels: usize) -> impl Iterator<Item = Self> {
        (0..self.len).step_by(n_voxels).map(move |first| Self {
            start: self.start + first,
            len: n_voxels.min(self.len - first),
            ..self
        })
    }

    /// All of them.
    pub(crate) fn iter(self) -> std::slice::Iter<'a, V> {
        self.voxels[self.start..self.start + self.len].iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn by_sheet_is_a_stable_sort() {
        for_each_seed(1, |mut rng| {
            let mut sorted = BySheet::default();
            for n_voxels in [0, 1, 7, 500, 20] {
                let voxel = |id: usize| (id, rng.usize(0..3), rng.usize(5..25));
                let voxels: Vec<(usize, usize, usize)> = (0..n_voxels).map(voxel).collect();
                let key_of = |voxel: &(usize, usize, usize)| (voxel.1, voxel.2);
                sorted.sort(3, 4..25, voxels.chunks(9), key_of, &FrameHandle::new());
                let sheets = || voxels.iter().map(|voxel| key_of(voxel).1);
                if let (Some(first), Some(last)) = (sheets().min(), sheets().max()) {
                    assert_eq!(sorted.sheets(), first..last + 1);
                }
                assert_eq!(sorted.sheets().is_empty(), voxels.is_empty());
                for (first, end) in
                    (0..30).flat_map(|first| (first..30).map(move |end| (first, end)))
                {
                    for class in 0..3 {
                        let is_meant = |v: &&(usize, usize, usize)| {
                            key_of(v).0 == class && (first..end).contains(&key_of(v).1)
                        };
                        let mut expected: Vec<_> = voxels.iter().filter(is_meant).collect();
                        expected.sort_by_key(|voxel| key_of(voxel));
                        let run = sorted.starting_in(class, first..end);
                        assert_eq!(run.len, expected.len());
                        assert!(run.iter().eq(expected), "class {class}, {first}..{end}");
                    }
                }
            }
        });
    }
}
