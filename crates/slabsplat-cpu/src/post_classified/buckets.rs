//! The voxels of one tile by the slab in which each begins.

/// Made to be reused, so that a tile allocates nothing once its thread has met the fullest one.
#[derive(Debug, Default)]
pub(super) struct SlabBuckets {
    first_slab: usize,
    /// Where in `voxels` the slabs begin, and the end.
    starts: Vec<u32>,
    voxels: Vec<u32>,
}

impl SlabBuckets {
    /// Sorts `voxels` by `slab_of`, keeping the order within a slab.
    pub(super) fn fill(&mut self, voxels: &[u32], slab_of: impl Fn(u32) -> usize) {
        let slabs = || voxels.iter().map(|&voxel| slab_of(voxel));
        self.starts.clear();
        self.voxels.clear();
        let Some((first, last)) = slabs().min().zip(slabs().max()) else { return };
        self.first_slab = first;
        // One entry more than needed: while voxels are placed, `starts[slab + 1]` is where the next one goes.
        self.starts.resize(last - first + 3, 0);
        slabs().for_each(|slab| self.starts[slab - first + 2] += 1);
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.voxels.resize(voxels.len(), 0);
        for (&voxel, slab) in voxels.iter().zip(slabs()) {
            let next = &mut self.starts[slab - first + 1];
            self.voxels[*next as usize] = voxel;
            *next += 1;
        }
    }

    pub(super) fn resident_bytes(&self) -> usize {
        (self.starts.capacity() + self.voxels.capacity()) * size_of::<u32>()
    }

    /// The first and the last slab in which a voxel begins; `None` if there is no voxel.
    pub(super) fn slab_range(&self) -> Option<[usize; 2]> {
        let n_slabs = self.starts.len().checked_sub(2)?;
        Some([self.first_slab, self.first_slab + n_slabs - 1])
    }

    /// The voxels that begin in the slabs `first ..= last`.
    pub(super) fn beginning_in(&self, first: usize, last: usize) -> &[u32] {
        let Some([first_slab, last_slab]) = self.slab_range() else { return &[] };
        let place = |slab: usize| {
            let slab = slab.clamp(first_slab, last_slab + 1) - first_slab;
            self.starts[slab] as usize
        };
        &self.voxels[place(first)..place(last + 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_seeds::for_each_seed;

    #[test]
    fn buckets_are_a_stable_sort() {
        for_each_seed(1, |mut rng| {
            let mut buckets = SlabBuckets::default();
            for n_voxels in [0, 1, 300, 20] {
                let slabs: Vec<usize> = (0..n_voxels).map(|_| rng.usize(5..25)).collect();
                let voxels: Vec<u32> = (0..n_voxels as u32).collect();
                buckets.fill(&voxels, |voxel| slabs[voxel as usize]);
                let ends = slabs.iter().min().zip(slabs.iter().max()).map(|(&a, &b)| [a, b]);
                assert_eq!(buckets.slab_range(), ends);
                for (first, last) in (0..30).flat_map(|a| (a..30).map(move |b| (a, b))) {
                    let begins = |&voxel: &u32| (first..=last).contains(&slabs[voxel as usize]);
                    let mut expected: Vec<u32> = voxels.iter().copied().filter(begins).collect();
                    expected.sort_by_key(|&voxel| slabs[voxel as usize]);
                    assert_eq!(buckets.beginning_in(first, last), expected, "{first}..={last}");
                }
            }
        });
    }
}
