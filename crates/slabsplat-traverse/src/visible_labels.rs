//! Which samples are visible, by the label of their voxel (model §13).

use crate::order::Ordered;
use slabsplat_core::{IsoRange, Labels, TransferFunction};

/// The samples of each label that are visible.
pub(crate) struct VisibleLabels<'a, T> {
    of_voxels: &'a [u16],
    /// Index into `ranges` of each label.
    ranges_of: Vec<usize>,
    /// None for what is invisible, those of the layer, and those of labels with a transfer function of their
    /// own.
    ranges: Vec<Vec<[T; 2]>>,
}

const INVISIBLE: usize = 0;
const OF_LAYER: usize = 1;

impl<'a, T: Ordered> VisibleLabels<'a, T> {
    /// Of labels without a transfer function of their own samples `of_layer` are visible; `in_samples` are
    /// the samples with values in iso-ranges.
    pub(crate) fn new(
        labels: &'a Labels,
        transfer: &TransferFunction,
        of_layer: Vec<[T; 2]>,
        in_samples: impl Fn(&[IsoRange]) -> Vec<[T; 2]>,
    ) -> Self {
        let mut ranges = vec![Vec::new(), of_layer];
        let mut ranges_of_label = |&label: &i64| match labels.style(label).transfer_in(transfer) {
            None => INVISIBLE,
            Some(own) if std::ptr::eq(own, transfer) => OF_LAYER,
            Some(own) => {
                ranges.push(in_samples(&own.iso_ranges()));
                ranges.len() - 1
            }
        };
        let map = labels.map();
        let ranges_of = map.labels().iter().map(&mut ranges_of_label).collect();
        Self { of_voxels: map.indices(), ranges_of, ranges }
    }

    /// Whether a voxel's label shows what the layer shows.
    pub(crate) fn is_of_layer(&self, voxel_idx: usize) -> bool {
        self.ranges_of[usize::from(self.of_voxels[voxel_idx])] == OF_LAYER
    }

    /// A bit for each of up to eight voxels from that one on, the first in the lowest.
    pub(crate) fn of_row(&self, voxel_idx: usize, samples: &[T]) -> u8 {
        let labels = &self.of_voxels[voxel_idx..][..samples.len()];
        labels.iter().zip(samples).rev().fold(0, |bits, (&label_idx, &sample)| {
            let ranges = &self.ranges[self.ranges_of[usize::from(label_idx)]];
            let is_visible = ranges.iter().any(|&[a, b]| a <= sample && sample <= b);
            bits << 1 | u8::from(is_visible)
        })
    }
}
