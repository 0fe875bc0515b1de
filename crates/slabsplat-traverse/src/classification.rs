//! Samples to colour and opacity, once a transfer function (model §6), and once a label's style (model §13).
//!
//! Samples of 8 and 16 bits have so few values that all of them are classified beforehand, in 64 bits;
//! a voxel then takes one look at a table of 4 KiB or 1 MiB. Others are classified when they are met, and so
//! are those of labels with transfer functions of their own, if there are many of these.

use crate::VoxelRules;
use crate::order::Ordered;
use slabsplat_core::{
    Cancelled, Compositing, FrameHandle, LabelStyle, Labels, SampleType, Scaling, TransferFunction,
    TransferFunction2d, Volume,
};

/// What is seen of every sample, and with a two-dimensional transfer function of every voxel: red, green and
/// blue, and the weight that is summed over a sheet, which is `α`, or `μ = −ln(1 − α)` for `extinction`.
///
/// To be cached while the transfer function, the labels, the compositing, and the volume's type and scaling
/// stay.
#[derive(Clone, Debug)]
pub struct Classification {
    compositing: Compositing,
    /// By the layer's transfer function, and then by those that labels have of their own.
    by_transfer: Vec<ByTransfer>,
    transfer_2d: Option<TransferFunction2d>,
    scaling: Scaling,
    labels: Option<ByLabel>,
}

/// The index of the layer's transfer function.
const OF_LAYER: usize = 0;

/// Transfer functions of labels that get a table.
const MAX_TABLES: usize = 16;

impl Classification {
    /// Classifies the samples of `volume` by value and label.
    pub fn new(rules: &VoxelRules<'_>, compositing: Compositing, volume: &Volume) -> Self {
        Self::for_frame(rules, compositing, volume, &FrameHandle::new())
            .expect("nobody cancels the frame")
    }

    /// The same for a frame: labels may have transfer functions of their own, and each takes some
    /// milliseconds.
    ///
    /// # Errors
    /// If that is cancelled.
    pub fn for_frame(
        rules: &VoxelRules<'_>,
        compositing: Compositing,
        volume: &Volume,
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        let VoxelRules { transfer, transfer_2d, labels, colors: _, gradient_opacity: _ } = *rules;
        let scaling = volume.scaling();
        let mut by_transfer = vec![ByTransfer::new(transfer, compositing, volume, frame)];
        let labels = labels.map(|labels| {
            ByLabel::new(labels, |transfer| {
                let mut of_label = ByTransfer::without_table(transfer, compositing, volume);
                if by_transfer.len() <= MAX_TABLES {
                    of_label.fill_table(volume.sample_type(), frame);
                }
                by_transfer.push(of_label);
                by_transfer.len() - 1
            })
        });
        let transfer_2d = transfer_2d.cloned();
        // Tables may have ended before they were full.
        frame.check()?;
        Ok(Self { compositing, by_transfer, transfer_2d, scaling, labels })
    }

    /// How sheets are summed.
    pub fn compositing(&self) -> Compositing {
        self.compositing
    }

    /// A classified colour with its opacity multiplied with a factor, 0 … 1.
    #[inline]
    pub(crate) fn thinned(&self, [r, g, b, weight]: [f32; 4], factor: f64) -> [f32; 4] {
        [r, g, b, thinned(weight, factor as f32, self.compositing)]
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        let of_tables: usize = self.by_transfer.iter().map(ByTransfer::resident_bytes).sum();
        of_tables + self.labels.as_ref().map_or(0, ByLabel::resident_bytes)
    }

    /// Whether the label of a voxel has a colour, which comes before that of the voxel.
    #[inline]
    pub(crate) fn has_label_color(&self, label_idx: Option<u16>) -> bool {
        self.look(label_idx).is_some_and(|look| look.color.is_some())
    }

    /// Red, green, blue and weight of a sample of the volume's type, by the label of its voxel, which is one
    /// of [`LabelMap::indices`](slabsplat_core::LabelMap::indices).
    #[inline]
    pub(crate) fn of<T: Ordered>(&self, sample: T, label_idx: Option<u16>) -> [f32; 4] {
        match self.look(label_idx) {
            Some(look) => {
                let classified = self.by_transfer[look.by_transfer_idx].of(sample);
                look.laid_over(classified, self.compositing)
            }
            None => self.by_transfer[OF_LAYER].of(sample),
        }
    }

    /// The same of a voxel with that gradient, per `unit`.
    #[inline]
    pub(crate) fn of_gradient<T: Ordered>(
        &self,
        sample: T,
        gradient: f64,
        label_idx: Option<u16>,
    ) -> [f32; 4] {
        let look = self.look(label_idx);
        match (&self.transfer_2d, look) {
            (Some(transfer_2d), None) => self.by_2d(transfer_2d, sample, gradient),
            (Some(transfer_2d), Some(look)) if look.by_transfer_idx == OF_LAYER => {
                look.laid_over(self.by_2d(transfer_2d, sample, gradient), self.compositing)
            }
            _ => self.of(sample, label_idx),
        }
    }

    fn by_2d<T: Ordered>(
        &self,
        transfer_2d: &TransferFunction2d,
        sample: T,
        gradient: f64,
    ) -> [f32; 4] {
        let value = self.scaling.apply(sample.to_f64());
        let (opacity, [r, g, b]) = transfer_2d.at(value, gradient);
        [r, g, b, self.compositing.weight(opacity)].map(|channel| channel as f32)
    }

    fn look(&self, label_idx: Option<u16>) -> Option<&LabelLook> {
        let labels = self.labels.as_ref()?;
        Some(&labels.looks[usize::from(label_idx?)])
    }
}

/// What one transfer function makes of samples.
#[derive(Clone, Debug)]
struct ByTransfer {
    transfer: TransferFunction,
    compositing: Compositing,
    scaling: Scaling,
    /// By rank of the sample; empty for wide types.
    table: Vec<[f32; 4]>,
}

impl ByTransfer {
    fn new(
        transfer: &TransferFunction,
        compositing: Compositing,
        volume: &Volume,
        frame: &FrameHandle,
    ) -> Self {
        let mut by_transfer = Self::without_table(transfer, compositing, volume);
        by_transfer.fill_table(volume.sample_type(), frame);
        by_transfer
    }

    fn without_table(
        transfer: &TransferFunction,
        compositing: Compositing,
        volume: &Volume,
    ) -> Self {
        let scaling = volume.scaling();
        Self { transfer: transfer.clone(), compositing, scaling, table: Vec::new() }
    }

    /// Of a frame that is cancelled the table ends anywhere.
    fn fill_table(&mut self, sample_type: SampleType, frame: &FrameHandle) {
        self.table = match sample_type {
            SampleType::U8 => self.of_all::<u8>(frame),
            SampleType::I8 => self.of_all::<i8>(frame),
            SampleType::U16 => self.of_all::<u16>(frame),
            SampleType::I16 => self.of_all::<i16>(frame),
            SampleType::U32 | SampleType::I32 | SampleType::F32 | SampleType::F64 => Vec::new(),
        };
    }

    fn resident_bytes(&self) -> usize {
        self.table.capacity() * size_of::<[f32; 4]>()
    }

    #[inline]
    fn of<T: Ordered>(&self, sample: T) -> [f32; 4] {
        if size_of::<T>() <= 2
            && let Some(&classified) = self.table.get(sample.rank() as usize)
        {
            return classified;
        }
        self.of_value(self.scaling.apply(sample.to_f64()))
    }

    fn of_all<T: Ordered>(&self, frame: &FrameHandle) -> Vec<[f32; 4]> {
        let of_rank = |rank| self.of_value(self.scaling.apply(T::from_rank(rank).to_f64()));
        let n_ranks = T::MOST.rank() + 1;
        let mut table = Vec::with_capacity(n_ranks as usize);
        table.extend((0..n_ranks).take_while(|_| !frame.is_cancelled()).map(of_rank));
        table
    }

    fn of_value(&self, value: f64) -> [f32; 4] {
        let opacity = self.transfer.opacity(value);
        let weight = self.compositing.weight(opacity);
        let [r, g, b] = self.transfer.color(value);
        [r, g, b, weight].map(|channel| channel as f32)
    }
}

/// How voxels of each label look.
#[derive(Clone, Debug)]
struct ByLabel {
    /// In the order of [`LabelMap::labels`](slabsplat_core::LabelMap::labels).
    looks: Vec<LabelLook>,
}

#[derive(Clone, Debug)]
struct LabelLook {
    /// Index into [`Classification::by_transfer`].
    by_transfer_idx: usize,
    color: Option<[f32; 3]>,
    opacity: f32,
}

impl ByLabel {
    /// `add` classifies by a transfer function of a label's own, and returns the index of that.
    fn new(labels: &Labels, mut add: impl FnMut(&TransferFunction) -> usize) -> Self {
        let mut look = |&label: &i64| {
            let LabelStyle { transfer, color, opacity, .. } = labels.style(label);
            LabelLook {
                by_transfer_idx: transfer.as_ref().map_or(OF_LAYER, &mut add),
                color: color.map(|color| color.map(|channel| channel as f32)),
                opacity: *opacity as f32,
            }
        };
        Self { looks: labels.map().labels().iter().map(&mut look).collect() }
    }

    fn resident_bytes(&self) -> usize {
        self.looks.capacity() * size_of::<LabelLook>()
    }
}

impl LabelLook {
    #[inline]
    fn laid_over(&self, [r, g, b, weight]: [f32; 4], compositing: Compositing) -> [f32; 4] {
        let [r, g, b] = self.color.unwrap_or([r, g, b]);
        [r, g, b, thinned(weight, self.opacity, compositing)]
    }
}

/// The weight of an opacity that is multiplied with a factor, 0 … 1.
#[inline]
fn thinned(weight: f32, factor: f32, compositing: Compositing) -> f32 {
    if 1.0 <= factor {
        weight
    } else if compositing.sums_extinction() {
        // The opacity is 1 − e^(−μ).
        -(-(factor * -(-weight).exp_m1())).ln_1p()
    } else {
        factor * weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, LabelMap, Samples, TransferBox};

    #[test]
    fn classification_stops_when_cancelled() {
        let transfer = TransferFunction::new(vec![(0.0, [0.5])], vec![(0.0, [1.0; 3])]).unwrap();
        let grid = Grid::with_spacing([1; 3], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, vec![1_u16].into(), Scaling::IDENTITY).unwrap();
        let frame = FrameHandle::new();
        frame.cancel();
        let by_transfer = ByTransfer::new(&transfer, Compositing::Separate, &volume, &frame);
        assert!(by_transfer.table.is_empty(), "nothing is classified for nobody");
        let rules = VoxelRules::by_value(&transfer);
        let made = Classification::for_frame(&rules, Compositing::Separate, &volume, &frame);
        assert_eq!(made.map(drop), Err(Cancelled));
    }

    #[test]
    fn classification_holds_a_table_of_narrow_samples() {
        let transfer = TransferFunction::new(vec![(0.0, [0.5])], vec![(0.0, [1.0; 3])]).unwrap();
        let check = |samples: Samples, n_entries: usize| {
            let grid = Grid::with_spacing([1; 3], [1.0; 3]).unwrap();
            let volume = Volume::new(grid, samples, Scaling::IDENTITY).unwrap();
            let classification = Classification::new(
                &VoxelRules::by_value(&transfer),
                Compositing::Separate,
                &volume,
            );
            let least = n_entries * size_of::<[f32; 4]>();
            let bytes = classification.resident_bytes();
            assert!((least..=2 * least).contains(&bytes), "{bytes} bytes of {n_entries} entries");
        };
        check(vec![1_u8].into(), 1 << 8);
        check(vec![1_i8].into(), 1 << 8);
        check(vec![1_u16].into(), 1 << 16);
        check(vec![1_i16].into(), 1 << 16);
        check(vec![1_u32].into(), 0);
        check(vec![1.0_f32].into(), 0);
    }

    fn opaque(opacity: f64, gray: f64) -> TransferFunction {
        TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, [gray; 3])]).unwrap()
    }

    fn volume(samples: Vec<u8>) -> Volume {
        let grid = Grid::with_spacing([samples.len(), 1, 1], [1.0; 3]).unwrap();
        Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap()
    }

    fn assert_close(found: [f32; 4], expected: [f64; 4]) {
        let pairs = found.into_iter().map(f64::from).zip(expected);
        let off = pairs.fold(0.0_f64, |off, (found, expected)| off.max((found - expected).abs()));
        assert!(off < 1e-6, "{found:?}, not {expected:?}");
    }

    /// An opacity of 0.8 times 0.5 is one of 0.4, whatever sheets sum.
    #[test]
    fn classification_thins_opacity() {
        let transfer = opaque(0.8, 0.3);
        for compositing in [Compositing::Extinction, Compositing::Separate, Compositing::Associated]
        {
            let rules = VoxelRules::by_value(&transfer);
            let classification = Classification::new(&rules, compositing, &volume(vec![1]));
            let classified = classification.of(1_u8, None);
            let weight = compositing.weight(0.8);
            assert_close(classified, [0.3, 0.3, 0.3, weight]);
            let half = [0.3, 0.3, 0.3, compositing.weight(0.4)];
            assert_close(classification.thinned(classified, 0.5), half);
            assert_eq!(classification.thinned(classified, 1.0), classified);
        }
    }

    /// A label without a style, one with a colour, one half as opaque, and one with a transfer function.
    #[test]
    fn classification_by_labels() {
        let (transfer, own) = (opaque(0.8, 0.3), opaque(0.2, 0.9));
        let values = volume(vec![1; 4]);
        let map = LabelMap::new(&volume(vec![0, 1, 2, 3]), values.grid()).unwrap();
        let style = LabelStyle::default;
        let styles = [
            (1, style().color([1.0, 0.5, 0.0])),
            (2, style().opacity(0.5)),
            (3, style().transfer(own)),
        ];
        let labels = Labels::new(map, styles).unwrap();
        let skin = TransferBox::new([0.0, 2.0], [1.0, 9.0]).unwrap();
        let skin =
            TransferFunction2d::Boxes(vec![skin.color([0.1; 3]).unwrap().opacity(0.6).unwrap()]);
        let by_value = VoxelRules { labels: Some(&labels), ..VoxelRules::by_value(&transfer) };
        let by_both = VoxelRules { transfer_2d: Some(&skin), ..by_value };
        let check = |rules: &VoxelRules<'_>, gradient: f64, expected: [[f64; 4]; 4]| {
            let classification = Classification::new(rules, Compositing::Separate, &values);
            for (label, expected) in (0..).zip(expected) {
                let index = Some(labels.map().indices()[label]);
                assert_close(classification.of_gradient(1_u8, gradient, index), expected);
                assert_eq!(classification.has_label_color(index), label == 1);
            }
            assert!(!classification.has_label_color(None));
            classification
        };
        let of_own = [0.9, 0.9, 0.9, 0.2];
        let of_layer = [[0.3, 0.3, 0.3, 0.8], [1.0, 0.5, 0.0, 0.8], [0.3, 0.3, 0.3, 0.4], of_own];
        let classification = check(&by_value, 4.0, of_layer);
        assert!(2 * 256 * size_of::<[f32; 4]>() < classification.resident_bytes());
        let by_gradient =
            [[0.1, 0.1, 0.1, 0.6], [1.0, 0.5, 0.0, 0.6], [0.1, 0.1, 0.1, 0.3], of_own];
        check(&by_both, 4.0, by_gradient);
    }
}
