//! The polynomials of the last plan's tables, kept for the next one.

use slabsplat_kernel::{FootprintTable, RadialPolynomials, SectionTable};
use std::sync::Arc;

/// What is kept between frames; nothing before the first.
#[derive(Debug, Default)]
pub(crate) struct Polynomials {
    sections: Option<(Arc<SectionTable>, RadialPolynomials)>,
    footprint: Option<(Arc<FootprintTable>, RadialPolynomials)>,
}

impl Polynomials {
    pub(crate) fn of_sections(&mut self, table: &Arc<SectionTable>) -> &RadialPolynomials {
        keep(&mut self.sections, table, RadialPolynomials::of_sections)
    }

    pub(crate) fn of_footprint(&mut self, table: &Arc<FootprintTable>) -> &RadialPolynomials {
        keep(&mut self.footprint, table, RadialPolynomials::of_footprint)
    }
}

/// What `kept` holds, if it was made of that table; otherwise makes it anew.
fn keep<'a, T>(
    kept: &'a mut Option<(Arc<T>, RadialPolynomials)>,
    table: &Arc<T>,
    make: impl FnOnce(&T) -> RadialPolynomials,
) -> &'a RadialPolynomials {
    if !kept.as_ref().is_some_and(|(of, _)| Arc::ptr_eq(of, table)) {
        *kept = None;
    }
    &kept.get_or_insert_with(|| (table.clone(), make(table))).1
}
