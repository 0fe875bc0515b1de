//! What decides beside its value whether a voxel is visible, and how opaque it is.

use crate::gradient_opacity::GradientOpacity;
use crate::order::Ordered;
use crate::visible_labels::VisibleLabels;
use slabsplat_core::{IsoRange, Labels, PiecewiseLinear, TransferFunction, Volume};

/// How a layer classifies its voxels: by value, by label (model §13), and by gradient (§6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelRules<'a> {
    /// What is seen of values.
    pub transfer: &'a TransferFunction,
    /// What changes that by label.
    pub labels: Option<&'a Labels>,
    /// What opacity is multiplied with, by the length of the gradient per `unit`.
    pub gradient_opacity: Option<&'a PiecewiseLinear<1>>,
}

impl<'a> VoxelRules<'a> {
    /// By value alone.
    pub fn by_value(transfer: &'a TransferFunction) -> Self {
        Self { transfer, labels: None, gradient_opacity: None }
    }

    /// Whether values alone decide.
    pub fn are_by_value(&self) -> bool {
        self.labels.is_none() && self.gradient_opacity.is_none()
    }
}

/// Which voxels that have visible values are visible.
pub(crate) struct VisibleVoxels<'a, T> {
    labels: Option<VisibleLabels<'a, T>>,
    gradient_opacity: Option<GradientOpacity<'a, T>>,
}

impl<'a, T: Ordered> VisibleVoxels<'a, T> {
    /// `samples` are those of `volume`, and `in_samples` those with values in iso-ranges.
    pub(crate) fn new(
        rules: &VoxelRules<'a>,
        volume: &Volume,
        samples: &'a [T],
        in_samples: impl Fn(&[IsoRange]) -> Vec<[T; 2]>,
    ) -> Self {
        let VoxelRules { transfer, labels, gradient_opacity } = *rules;
        Self {
            labels: labels.map(|labels| VisibleLabels::new(labels, transfer, in_samples)),
            gradient_opacity: gradient_opacity
                .map(|factor| GradientOpacity::new(volume, samples, factor)),
        }
    }

    /// Those of `bits` that are visible, a bit each for up to eight voxels of a row, the first of which has
    /// these coordinates and that place in memory.
    #[inline]
    pub(crate) fn among(
        &self,
        bits: u8,
        [x, y, z]: [usize; 3],
        voxel_idx: usize,
        samples: &[T],
    ) -> u8 {
        let of_labels = self.labels.as_ref().map(|labels| labels.of_row(voxel_idx, samples));
        let mut visible = bits & of_labels.unwrap_or(u8::MAX);
        if let Some(factor) = &self.gradient_opacity {
            for bit in 0..samples.len() {
                let is_open = visible >> bit & 1 == 1;
                if is_open && factor.at([x + bit, y, z]) <= 0.0 {
                    visible &= !(1 << bit);
                }
            }
        }
        visible
    }
}
