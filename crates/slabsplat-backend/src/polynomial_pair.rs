//! Sections by polynomials, and which of them are good enough for a picture.

use slabsplat_core::{Cancelled, Compositing, FrameHandle};
use slabsplat_kernel::{Degree, ErrorBudget, RadialPolynomials, SectionTable};
use std::sync::Arc;

/// The rows of a table by polynomials of low and of high degree.
#[derive(Clone, Debug)]
pub struct PolynomialPair {
    low: Arc<RadialPolynomials>,
    /// Unless a low degree is enough.
    high: Option<Arc<RadialPolynomials>>,
}

impl PolynomialPair {
    /// Those of a table; of low degree alone if `budget` permits it.
    pub fn new(table: &SectionTable, budget: Option<ErrorBudget>) -> Self {
        Self::for_frame(table, budget, &FrameHandle::new()).expect("nobody cancels the frame")
    }

    /// The same for a frame.
    ///
    /// # Errors
    /// If that is cancelled.
    pub fn for_frame(
        table: &SectionTable,
        budget: Option<ErrorBudget>,
        frame: &FrameHandle,
    ) -> Result<Self, Cancelled> {
        let of = |degree| RadialPolynomials::of_sections_for_frame(table, degree, frame);
        let low = of(Degree::Low)?;
        let is_enough = budget.is_some_and(|budget| {
            low.error() <= budget.polynomial() && low.pixel_error() <= budget.polynomial_pixel()
        });
        let high = if is_enough { None } else { Some(Arc::new(of(Degree::High)?)) };
        Ok(Self { low: Arc::new(low), high })
    }

    /// Those for voxels of whatever extinction, or for those of no more than
    /// [`most_of_low_degree`](Self::most_of_low_degree).
    #[inline(always)]
    pub fn of(&self, is_low_degree: bool) -> &Arc<RadialPolynomials> {
        match &self.high {
            Some(high) if !is_low_degree => high,
            _ => &self.low,
        }
    }

    /// Whether a low degree is enough for all voxels.
    pub fn is_low(&self) -> bool {
        self.high.is_none()
    }

    /// Whether they are good enough where pixels shall be exact; if not, sections are read from the table.
    pub fn are_exact(&self, compositing: Compositing) -> bool {
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
    pub fn most_of_low_degree(&self, n_sections: usize) -> f32 {
        (ErrorBudget::LOW_DEGREE / (n_sections as f64 * self.low.error())) as f32
    }
}
