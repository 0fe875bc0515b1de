//! What decides beside its value whether a voxel is visible, how opaque it is, and in which colour.

use crate::gradient_length::GradientLengths;
use crate::order::Ordered;
use crate::visible_labels::VisibleLabels;
use slabsplat_core::{
    IsoRange, Labels, PiecewiseLinear, Scaling, TransferFunction, TransferFunction2d, Volume,
    VoxelColors,
};

/// How a layer classifies its voxels: by value, by label (model §13), by gradient (§6), and by colours of
/// their own (§15).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelRules<'a> {
    /// What is seen of values.
    pub transfer: &'a TransferFunction,
    /// What is seen of values and gradients instead.
    pub transfer_2d: Option<&'a TransferFunction2d>,
    /// The colours of voxels, instead of those of transfer functions.
    pub colors: Option<&'a VoxelColors>,
    /// What changes either by label.
    pub labels: Option<&'a Labels>,
    /// What opacity is multiplied with, by the length of the gradient per `unit`.
    pub gradient_opacity: Option<&'a PiecewiseLinear<1>>,
}

impl<'a> VoxelRules<'a> {
    /// By value alone.
    pub fn by_value(transfer: &'a TransferFunction) -> Self {
        Self { transfer, transfer_2d: None, colors: None, labels: None, gradient_opacity: None }
    }

    /// Whether values alone decide which voxels are visible.
    pub fn are_by_value(&self) -> bool {
        self.transfer_2d.is_none() && self.labels.is_none() && self.gradient_opacity.is_none()
    }

    /// Whether values alone decide which voxels are visible and how these look.
    pub fn are_all_by_value(&self) -> bool {
        self.are_by_value() && self.colors.is_none()
    }

    /// Whether gradients have a say.
    pub(crate) fn are_by_gradient(&self) -> bool {
        self.transfer_2d.is_some() || self.gradient_opacity.is_some()
    }

    /// Values of which something is visible where no label says otherwise.
    fn iso_ranges(&self) -> Vec<IsoRange> {
        match self.transfer_2d {
            Some(transfer_2d) => transfer_2d.iso_ranges(),
            None => self.transfer.iso_ranges(),
        }
    }
}

/// The same rules, to be kept: what is cached was made by them.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnVoxelRules {
    transfer: TransferFunction,
    transfer_2d: Option<TransferFunction2d>,
    colors: Option<VoxelColors>,
    labels: Option<Labels>,
    gradient_opacity: Option<PiecewiseLinear<1>>,
}

impl OwnVoxelRules {
    /// A copy of rules; large things in it are shared.
    pub fn new(rules: &VoxelRules<'_>) -> Self {
        let VoxelRules { transfer, transfer_2d, colors, labels, gradient_opacity } = *rules;
        Self {
            transfer: transfer.clone(),
            transfer_2d: transfer_2d.cloned(),
            colors: colors.cloned(),
            labels: labels.cloned(),
            gradient_opacity: gradient_opacity.cloned(),
        }
    }

    /// The rules.
    pub fn rules(&self) -> VoxelRules<'_> {
        let Self { transfer, transfer_2d, colors, labels, gradient_opacity } = self;
        VoxelRules {
            transfer,
            transfer_2d: transfer_2d.as_ref(),
            colors: colors.as_ref(),
            labels: labels.as_ref(),
            gradient_opacity: gradient_opacity.as_ref(),
        }
    }
}

/// Which voxels that have visible values are visible.
pub(crate) struct VisibleVoxels<'a, T> {
    rules: VoxelRules<'a>,
    labels: Option<VisibleLabels<'a, T>>,
    gradients: Option<GradientLengths<'a, T>>,
    scaling: Scaling,
}

impl<'a, T: Ordered> VisibleVoxels<'a, T> {
    /// `samples` are those of `volume`, and `in_samples` those with values in iso-ranges.
    pub(crate) fn new(
        rules: &VoxelRules<'a>,
        volume: &Volume,
        samples: &'a [T],
        in_samples: impl Fn(&[IsoRange]) -> Vec<[T; 2]>,
    ) -> Self {
        let labels = |labels| {
            let of_layer = in_samples(&rules.iso_ranges());
            VisibleLabels::new(labels, rules.transfer, of_layer, in_samples)
        };
        Self {
            rules: *rules,
            labels: rules.labels.map(labels),
            gradients: rules.are_by_gradient().then(|| GradientLengths::new(volume, samples)),
            scaling: volume.scaling(),
        }
    }

    /// Those of `bits` that are visible, a bit each for up to eight voxels of a row, the first of which has
    /// these coordinates and that index in memory.
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
        if let Some(gradients) = &self.gradients {
            for (bit, &sample) in samples.iter().enumerate() {
                let is_open = visible >> bit & 1 == 1;
                if is_open
                    && !self.has_visible(gradients.at([x + bit, y, z]), voxel_idx + bit, sample)
                {
                    visible &= !(1 << bit);
                }
            }
        }
        visible
    }

    /// Whether a voxel is visible by its gradient.
    fn has_visible(&self, gradient: f64, voxel_idx: usize, sample: T) -> bool {
        let VoxelRules { transfer_2d, gradient_opacity, .. } = self.rules;
        let is_of_layer =
            || self.labels.as_ref().is_none_or(|labels| labels.is_of_layer(voxel_idx));
        if let Some(transfer_2d) = transfer_2d
            && is_of_layer()
            && transfer_2d.opacity(self.scaling.apply(sample.to_f64()), gradient) <= 0.0
        {
            return false;
        }
        gradient_opacity.is_none_or(|factor| 0.0 < factor.at(gradient)[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voxel_rules_say_what_decides() {
        let transfer = TransferFunction::new(vec![(0.0, [0.5])], vec![(0.0, [1.0; 3])]).unwrap();
        let by_both = TransferFunction2d::Boxes(Vec::new());
        let by_gradient = PiecewiseLinear::new("opacity", [(0.0, [1.0])]).unwrap();
        let rules = VoxelRules::by_value(&transfer);
        let decide = |rules: VoxelRules<'_>| [rules.are_by_value(), rules.are_by_gradient()];
        assert_eq!(decide(rules), [true, false]);
        assert!(rules.are_all_by_value());
        for rules in [
            VoxelRules { transfer_2d: Some(&by_both), ..rules },
            VoxelRules { gradient_opacity: Some(&by_gradient), ..rules },
        ] {
            assert_eq!(decide(rules), [false, true]);
            assert!(!rules.are_all_by_value());
        }
    }
}
