//! What was fitted to the last plan's tables, cached for the next one.

use slabsplat_backend::{ByIdentity, Cached};
use slabsplat_core::Compositing;
use slabsplat_kernel::{Degree, ErrorBudget, FootprintTable, RadialPolynomials, SectionTable};
use std::sync::Arc;

/// Polynomials of sections, cached between frames.
#[derive(Debug, Default)]
pub(crate) struct SectionPolynomials(
    Cached<(ByIdentity<SectionTable>, Option<ErrorBudget>), PolynomialPair>,
);

/// Polynomials of whole footprints, cached between frames.
#[derive(Debug, Default)]
pub(crate) struct FootprintPolynomials(Cached<ByIdentity<FootprintTable>, RadialPolynomials>);

/// The same rows by polynomials of low and of high degree.
#[derive(Debug)]
pub(crate) struct PolynomialPair {
    low: RadialPolynomials,
    /// Unless a low degree is enough.
    high: Option<RadialPolynomials>,
}

impl SectionPolynomials {
    /// Those of a table; of low degree alone if `budget` permits it.
    pub(crate) fn of(
        &mut self,
        table: &Arc<SectionTable>,
        budget: Option<ErrorBudget>,
    ) -> &PolynomialPair {
        self.0.made_of((ByIdentity::of(table), budget), |_| {
            let low = RadialPolynomials::of_sections(table, Degree::Low);
            let is_enough = budget.is_some_and(|budget| {
                low.error() <= budget.polynomial() && low.pixel_error() <= budget.polynomial_pixel()
            });
            let high = || RadialPolynomials::of_sections(table, Degree::High);
            PolynomialPair { low, high: (!is_enough).then(high) }
        })
    }
}

impl FootprintPolynomials {
    pub(crate) fn of(&mut self, table: &Arc<FootprintTable>) -> &RadialPolynomials {
        let key = ByIdentity::of(table);
        self.0.made_of(key, |_| RadialPolynomials::of_footprint(table, Degree::High))
    }
}

impl PolynomialPair {
    /// Those for voxels of whatever extinction, or for those of no more than
    /// [`most_of_low_degree`](Self::most_of_low_degree).
    #[inline(always)]
    pub(crate) fn of(&self, is_low_degree: bool) -> &RadialPolynomials {
        match &self.high {
            Some(high) if !is_low_degree => high,
            _ => &self.low,
        }
    }

    /// Whether they are good enough where pixels shall be exact; if not, sections are read from the table.
    pub(crate) fn are_exact(&self, compositing: Compositing) -> bool {
        let polynomials = self.of(false);
        let error = if compositing.sums_extinction() {
            polynomials.pixel_error()
        } else {
            // A voxel counts for no more than its opacity.
            polynomials.error()
        };
        error < ErrorBudget::EXACT_SECTION
    }

    /// The most extinction of a voxel of that many sections for which a low degree is always enough.
    pub(crate) fn most_of_low_degree(&self, n_sections: usize) -> f32 {
        (ErrorBudget::LOW_DEGREE / (n_sections as f64 * self.low.error())) as f32
    }
}
