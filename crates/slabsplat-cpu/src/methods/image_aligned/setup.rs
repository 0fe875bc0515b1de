//! All that is decided of a frame before its first voxel is looked at.

use super::classes::Classes;
use super::slab_shapes::SlabShapes;
use super::slab_view::SlabView;
use super::span_finder::SpanFinder;
use crate::footprints::polynomials::SectionPolynomials;
use crate::methods::Stage;
use crate::sections::shared::{Fitted, Sections};
use crate::separable::sections::{AsSeparable, SeparableTables, most_extinction};
use slabsplat_backend::SectionSplats;
use slabsplat_kernel::SeparableSections;

/// What is kept from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Prepared {
    sections: SectionPolynomials,
    merged: SectionPolynomials,
    separable: SeparableTables,
    shapes: SlabShapes,
}

/// A frame that is about to be drawn.
pub(super) struct Setup<'a> {
    /// Where slabs are, and what they cover.
    pub(super) slabs: SlabView<'a>,
    /// Which slabs voxels are drawn in.
    pub(super) spans: SpanFinder<'a>,
    /// Which voxels wait for how many slabs, and how they are drawn.
    pub(super) classes: Classes,
    /// What they are drawn by.
    pub(super) sections: Sections<'a>,
    separable: Option<&'a SeparableSections>,
}

impl<'a> Setup<'a> {
    pub(super) fn new(
        stage: &'a Stage<'_>,
        SectionSplats { slabs, table, merged, tilted }: &'a SectionSplats,
        prepared: &'a mut Prepared,
    ) -> Self {
        let (raster, plan) = (&stage.raster, stage.plan);
        let (merged, tilted) = (merged.as_ref(), tilted.as_ref());
        let budget = merged.map(|merged| merged.budget);
        let fitted = Fitted { table, polynomials: prepared.sections.of(table, budget) };
        let fitted_merged = merged.map(|merged| Fitted {
            table: &merged.table,
            polynomials: prepared.merged.of(&merged.table, budget),
        });
        let n_sections = slabs.n_before + 1;
        let sections =
            Sections::new(raster, plan.compositing, fitted, fitted_merged, tilted, n_sections);
        let upright = merged.filter(|_| !raster.is_sheared && !raster.is_tilted);
        let separable = upright.and_then(|merged| prepared.separable.of([table, &merged.table]));
        prepared.shapes.update(raster, &plan.view, &slabs.grid, separable);
        let slabs = SlabView::new(slabs, raster, &prepared.shapes, plan.volume.grid().unit());
        Self {
            spans: SpanFinder::new(&slabs, merged.map(|merged| &merged.levels)),
            classes: Classes {
                most_of_separable: separable
                    .zip(budget)
                    .map_or(f32::NEG_INFINITY, |(separable, budget)| {
                        most_extinction(separable, budget)
                    }),
                is_merged: merged.is_some(),
                kind: sections.kind,
                n_before: slabs.n_before,
            },
            slabs,
            sections,
            separable,
        }
    }

    /// How sections in a slab are drawn by separable footprints, if they are.
    #[inline(always)]
    pub(super) fn as_separable(&self, slab: usize) -> Option<AsSeparable<'a>> {
        Some(AsSeparable { sections: self.separable?, spline: self.slabs.shapes.spline(slab)? })
    }
}
