//! What was fitted to the last plan's tables, cached for the next one.

use slabsplat_backend::{ByIdentity, Cached, PolynomialPair};
use slabsplat_core::{Cancelled, FrameHandle};
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

impl SectionPolynomials {
    /// Those of a table; of low degree alone if `budget` permits it.
    pub(crate) fn of(
        &mut self,
        table: &Arc<SectionTable>,
        budget: Option<ErrorBudget>,
        frame: &FrameHandle,
    ) -> Result<&PolynomialPair, Cancelled> {
        let key = (ByIdentity::of(table), budget);
        let made = self.0.try_made_of(key, |_| PolynomialPair::for_frame(table, budget, frame));
        made.map(|pair| &*pair)
    }
}

impl FootprintPolynomials {
    pub(crate) fn of(&mut self, table: &Arc<FootprintTable>) -> &RadialPolynomials {
        let key = ByIdentity::of(table);
        self.0.made_of(key, |_| RadialPolynomials::of_footprint(table, Degree::High))
    }
}
