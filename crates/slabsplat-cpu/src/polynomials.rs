//! What was fitted to the last plan's tables, kept for the next one.

use slabsplat_backend::FewerSections;
use slabsplat_core::Compositing;
use slabsplat_kernel::{FootprintTable, Powers, RadialPolynomials, SectionProducts, SectionTable};
use std::sync::Arc;

/// What is kept between frames; nothing before the first.
#[derive(Debug, Default)]
pub(crate) struct Polynomials {
    sections: Kept<(Same<SectionTable>, f64), Fits>,
    folded: Kept<(Same<SectionTable>, f64), Fits>,
    products: Kept<[Same<SectionTable>; 2], SectionProducts>,
    footprint: Kept<Same<FootprintTable>, RadialPolynomials>,
}

/// What stands for a plan's sections.
pub(crate) struct OfSections<'a> {
    pub(crate) all: &'a Fits,
    pub(crate) fewer: Option<OfFewer<'a>>,
}

/// What stands for them where there may be fewer.
pub(crate) struct OfFewer<'a> {
    pub(crate) folded: &'a Fits,
    /// If there are any.
    pub(crate) products: Option<&'a SectionProducts>,
}

/// The same rows by few and by many powers.
#[derive(Debug)]
pub(crate) struct Fits {
    few: RadialPolynomials,
    /// Unless few powers do.
    many: Option<RadialPolynomials>,
}

/// What something was made of, and what was made.
type Kept<K, V> = Option<(K, V)>;

/// A table, the same only as itself.
#[derive(Debug)]
struct Same<T>(Arc<T>);

impl<T> PartialEq for Same<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// The part of a tolerance that polynomials may use up for the most opaque voxels.
const SHARE_OF_TOLERANCE: f64 = 0.01;

/// How many such parts a pixel may be off for one voxel, whatever its extinction: a twentieth of the tolerance.
const MOST_PIXEL_SHARES: f64 = 5.0;

/// What a voxel's sections by few powers may be off together, times its extinction, whatever the tolerance: a seventh of
/// what a pixel may be (SPEC §9).
const ERROR_OF_FEW: f64 = 1.5e-4;

/// What a pixel may be off for one voxel's section by many powers, where nothing else may be: half of what it
/// may be for all voxels (SPEC §9). Sections of a Gaussian stay below a third of that, those of
/// `crawfis-max`, which is in two pieces, just below it; normalised ones, products or a root of others, may
/// be beyond.
const MOST_ERROR: f64 = 5e-4;

/// A kernel whose sections miss products by more is none; a Gaussian that ends at R = 2 misses by 1.5·10⁻³.
const MOST_ERROR_OF_PRODUCTS: f64 = 5e-3;

impl Polynomials {
    /// Those of a plan's sections, and of its folded ones; products only if footprints are upright, and
    /// the kernel is one.
    pub(crate) fn of_sections(
        &mut self,
        table: &Arc<SectionTable>,
        fewer: Option<&FewerSections>,
        is_upright: bool,
    ) -> OfSections<'_> {
        let max_error = fewer.map_or(0.0, |fewer| SHARE_OF_TOLERANCE * fewer.tolerance);
        let key = |table: &Arc<SectionTable>| (Same(table.clone()), max_error);
        let make = |(table, max_error): &(Same<SectionTable>, f64)| {
            let few = RadialPolynomials::of_sections(&table.0, Powers::Few);
            let is_enough =
                few.error() <= *max_error && few.pixel_error() <= MOST_PIXEL_SHARES * max_error;
            let many = || RadialPolynomials::of_sections(&table.0, Powers::Many);
            Fits { few, many: (!is_enough).then(many) }
        };
        let all = keep(&mut self.sections, key(table), make);
        let fewer = fewer.map(|fewer| OfFewer {
            folded: keep(&mut self.folded, key(&fewer.table), make),
            products: is_upright
                .then(|| {
                    let tables = [table, &fewer.table].map(|table| Same(table.clone()));
                    keep(&mut self.products, tables, |[sections, folded]| {
                        SectionProducts::new(&sections.0, &folded.0)
                    })
                })
                .filter(|products| products.error() < MOST_ERROR_OF_PRODUCTS),
        });
        OfSections { all, fewer }
    }

    pub(crate) fn of_footprint(&mut self, table: &Arc<FootprintTable>) -> &RadialPolynomials {
        let make = |table: &Same<_>| RadialPolynomials::of_footprint(&table.0, Powers::Many);
        keep(&mut self.footprint, Same(table.clone()), make)
    }
}

impl Fits {
    /// Those for voxels of whatever extinction, or for those of no more than [`most_of_few`](Self::most_of_few).
    #[inline(always)]
    pub(crate) fn of(&self, by_few: bool) -> &RadialPolynomials {
        match &self.many {
            Some(many) if !by_few => many,
            _ => &self.few,
        }
    }

    /// Whether they are good enough where pixels shall be exact; if not, sections are read from the table.
    pub(crate) fn are_exact(&self, compositing: Compositing) -> bool {
        let polynomials = self.of(false);
        let error = match compositing {
            Compositing::Extinction => polynomials.pixel_error(),
            // A voxel counts for no more than its opacity.
            Compositing::Separate | Compositing::Associated => polynomials.error(),
        };
        error < MOST_ERROR
    }

    /// The most extinction of a voxel of that many sections for which few powers are always enough.
    pub(crate) fn most_of_few(&self, n_sections: usize) -> f32 {
        (ERROR_OF_FEW / (n_sections as f64 * self.few.error())) as f32
    }
}

/// What `kept` holds, if it was made of that; otherwise makes it anew.
fn keep<K: PartialEq, V>(kept: &mut Kept<K, V>, of: K, make: impl FnOnce(&K) -> V) -> &V {
    if !kept.as_ref().is_some_and(|(same, _)| *same == of) {
        *kept = None;
    }
    let made = || {
        let value = make(&of);
        (of, value)
    };
    &kept.get_or_insert_with(made).1
}
