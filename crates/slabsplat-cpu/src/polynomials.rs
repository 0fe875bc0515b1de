//! The polynomials of the last plan's tables, kept for the next one.

use slabsplat_backend::FewerSections;
use slabsplat_kernel::{FootprintTable, RadialPolynomials, SectionProducts, SectionTable};
use std::sync::Arc;

/// What is kept between frames; nothing before the first.
#[derive(Debug, Default)]
pub(crate) struct Polynomials {
    sections: Kept<SectionTable>,
    folded: Kept<SectionTable>,
    footprint: Kept<FootprintTable>,
    products: Option<([Arc<SectionTable>; 2], SectionProducts)>,
}

/// What stands for a plan's sections, and for the folded ones.
pub(crate) struct OfSections<'a> {
    pub(crate) all: &'a RadialPolynomials,
    pub(crate) fewer: Option<(&'a RadialPolynomials, &'a SectionProducts)>,
}

/// What polynomials were made of: a table, and the error that was allowed.
type Kept<T> = Option<(Arc<T>, f64, RadialPolynomials)>;

/// The part of a tolerance that polynomials may use up.
const SHARE_OF_TOLERANCE: f64 = 0.01;

impl Polynomials {
    /// Those of a plan's sections, and of its folded ones.
    pub(crate) fn of_sections(
        &mut self,
        table: &Arc<SectionTable>,
        fewer: Option<&FewerSections>,
    ) -> OfSections<'_> {
        let max_error = fewer.map_or(0.0, |fewer| SHARE_OF_TOLERANCE * fewer.tolerance);
        let make = RadialPolynomials::of_sections;
        let all = keep(&mut self.sections, table, max_error, make);
        let fewer = fewer.map(|fewer| {
            let folded = keep(&mut self.folded, &fewer.table, max_error, make);
            (folded, keep_products(&mut self.products, [table, &fewer.table]))
        });
        OfSections { all, fewer }
    }

    pub(crate) fn of_footprint(&mut self, table: &Arc<FootprintTable>) -> &RadialPolynomials {
        keep(&mut self.footprint, table, 0.0, RadialPolynomials::of_footprint)
    }
}

/// What `kept` holds, if it was made of that; otherwise makes it anew.
fn keep<'a, T>(
    kept: &'a mut Kept<T>,
    table: &Arc<T>,
    max_error: f64,
    make: impl FnOnce(&T, f64) -> RadialPolynomials,
) -> &'a RadialPolynomials {
    let same = |(of, error, _): &(Arc<T>, f64, _)| Arc::ptr_eq(of, table) && *error == max_error;
    if !kept.as_ref().is_some_and(same) {
        *kept = None;
    }
    &kept.get_or_insert_with(|| (table.clone(), max_error, make(table, max_error))).2
}

fn keep_products<'a>(
    kept: &'a mut Option<([Arc<SectionTable>; 2], SectionProducts)>,
    tables: [&Arc<SectionTable>; 2],
) -> &'a SectionProducts {
    let same = |of: &[Arc<SectionTable>; 2]| of.iter().zip(tables).all(|(a, b)| Arc::ptr_eq(a, b));
    if !kept.as_ref().is_some_and(|(of, _)| same(of)) {
        *kept = None;
    }
    let [sections, folded] = tables;
    &kept.get_or_insert_with(|| (tables.map(Arc::clone), SectionProducts::new(sections, folded))).1
}
