//! The whole footprint `F(ρ)`, sampled: what the two traditional methods splat (paper §1).

use crate::Kernel;
use crate::section_table::{row_len, sample_row};
use std::convert::Infallible;

/// A kernel's line integrals over all depths, from the edge to the middle, at equal steps of the half
/// chord as in a [`SectionTable`](crate::SectionTable).
#[derive(Clone, Debug, PartialEq)]
pub struct FootprintTable {
    samples_per_index: f32,
    weights: Vec<f32>,
}

impl FootprintTable {
    /// Samples `F(ρ)/κ`, per `unit`, at `radial_samples` equal steps; `kappa` as in
    /// [`SectionDesc`](crate::SectionDesc).
    pub fn new(kernel: &dyn Kernel, kappa: f64, radial_samples: u32) -> Self {
        let radius = kernel.radius();
        let weight = |rho| Ok::<_, Infallible>(kernel.footprint(rho) / kappa);
        let Ok(weights) = sample_row(radial_samples, radius, weight);
        Self { samples_per_index: (f64::from(radial_samples) / radius) as f32, weights }
    }

    /// The samples, to be read by [`lerp_radial`](crate::lerp_radial); the last is a guard.
    pub fn row(&self) -> &[f32] {
        debug_assert_eq!(self.weights.len(), row_len(self.weights.len() as u32 - 2));
        &self.weights
    }

    /// Samples per index unit of half chord.
    pub fn samples_per_index(&self) -> f32 {
        self.samples_per_index
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::half_chord;
    use crate::{KERNEL_NAMES, kernel_named, lerp_radial};

    #[test]
    fn footprint_table_error_is_small() {
        for &name in KERNEL_NAMES {
            let kernel = kernel_named(name).unwrap();
            let table = FootprintTable::new(&*kernel, 0.8, 256);
            for i in 0..500 {
                let rho = (f64::from(i) + 0.3) / 500.0 * kernel.radius();
                let read = lerp_radial(
                    table.row(),
                    (half_chord(kernel.radius(), rho) as f32) * table.samples_per_index(),
                );
                let error = (f64::from(read) - kernel.footprint(rho) / 0.8).abs();
                assert!(error < 1.5e-4, "{name} {rho}: {error}");
            }
        }
    }
}
