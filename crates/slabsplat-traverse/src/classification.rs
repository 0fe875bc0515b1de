//! Samples to colour and opacity, once a transfer function (model §6).
//!
//! Samples of 8 and 16 bits have so few values that all of them are classified beforehand, in 64 bits;
//! a voxel then takes one look at a table of 4 KiB or 1 MiB. Others are classified when they are met.

use crate::order::Ordered;
use slabsplat_core::{Compositing, SampleType, Scaling, TransferFunction, Volume};

/// What is seen of every sample: red, green and blue, and the weight that is summed over a sheet, which
/// is `α`, or `μ = −ln(1 − α)` for `extinction`.
///
/// To be cached while the transfer function, the compositing, and the volume's type and scaling stay.
#[derive(Clone, Debug)]
pub struct Classification {
    transfer: TransferFunction,
    compositing: Compositing,
    scaling: Scaling,
    /// By rank of the sample; empty for wide types.
    table: Vec<[f32; 4]>,
}

impl Classification {
    /// Classifies the samples of `volume`.
    pub fn new(transfer: &TransferFunction, compositing: Compositing, volume: &Volume) -> Self {
        let mut classification = Self {
            transfer: transfer.clone(),
            compositing,
            scaling: volume.scaling(),
            table: Vec::new(),
        };
        classification.table = match volume.sample_type() {
            SampleType::U8 => classification.of_all::<u8>(),
            SampleType::I8 => classification.of_all::<i8>(),
            SampleType::U16 => classification.of_all::<u16>(),
            SampleType::I16 => classification.of_all::<i16>(),
            SampleType::U32 | SampleType::I32 | SampleType::F32 | SampleType::F64 => Vec::new(),
        };
        classification
    }

    /// How sheets are summed.
    pub fn compositing(&self) -> Compositing {
        self.compositing
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        self.table.capacity() * size_of::<[f32; 4]>()
    }

    /// Red, green, blue and weight of a sample of the volume's type.
    #[inline]
    pub(crate) fn of<T: Ordered>(&self, sample: T) -> [f32; 4] {
        if size_of::<T>() <= 2 {
            self.table[sample.rank() as usize]
        } else {
            self.of_value(self.scaling.apply(sample.to_f64()))
        }
    }

    fn of_all<T: Ordered>(&self) -> Vec<[f32; 4]> {
        let of_rank = |rank| self.of_value(self.scaling.apply(T::from_rank(rank).to_f64()));
        (0..=T::MOST.rank()).map(of_rank).collect()
    }

    fn of_value(&self, value: f64) -> [f32; 4] {
        let opacity = self.transfer.opacity(value);
        let weight = self.compositing.weight(opacity);
        let [r, g, b] = self.transfer.color(value);
        [r, g, b, weight].map(|channel| channel as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Samples};

    #[test]
    fn classification_holds_a_table_of_narrow_samples() {
        let transfer = TransferFunction::new(vec![(0.0, [0.5])], vec![(0.0, [1.0; 3])]).unwrap();
        let check = |samples: Samples, n_entries: usize| {
            let grid = Grid::with_spacing([1; 3], [1.0; 3]).unwrap();
            let volume = Volume::new(grid, samples, Scaling::IDENTITY).unwrap();
            let classification = Classification::new(&transfer, Compositing::Separate, &volume);
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
}
