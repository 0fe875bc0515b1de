//! All that is decided of a frame before its first voxel is looked at.

use super::classes::Classes;
use super::slab_shapes::SlabShapes;
use super::slab_view::SlabView;
use super::span_finder::SpanFinder;
use crate::footprints::polynomials::SectionPolynomials;
use crate::methods::Stage;
use crate::sections::shared::{Fitted, Sections};
use crate::separable::sections::{AsSeparable, SeparableTables, most_extinction};
use crate::separable::slab::SeparableSlab;
use slabsplat_backend::SectionSplats;
use slabsplat_kernel::{SeparableSections, SeparableShapes};

/// What is cached from frame to frame.
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
    separable: Option<(&'a SeparableSections, SeparableShapes)>,
}

impl<'a> Setup<'a> {
    pub(super) fn new(
        stage: &'a Stage<'_>,
        SectionSplats { slabs, table, merged, tilted }: &'a SectionSplats,
        prepared: &'a mut Prepared,
    ) -> Self {
        let (raster, plan) = (&stage.raster, stage.plan);
        let (merged, tilted) = (merged.as_ref(), tilted.as_deref());
        let budget = merged.map(|merged| merged.budget);
        let fitted_merged = merged.map(|merged| Fitted {
            table: &merged.table,
            polynomials: prepared.merged.of(&merged.table, budget),
        });
        // Tilted sections need no polynomials of a table, which on a grid that turns are new every frame.
        let fitted = fitted_merged
            .filter(|_| tilted.is_some())
            .unwrap_or_else(|| Fitted { table, polynomials: prepared.sections.of(table, budget) });
        let n_sections = slabs.n_before + 1;
        let sections =
            Sections::new(raster, plan.compositing, fitted, fitted_merged, tilted, n_sections);
        let separable = merged.and_then(|merged| prepared.separable.of([table, &merged.table]));
        let thickness = slabs.grid.thickness();
        let separable = separable.map(|sections| {
            (sections, SeparableShapes::new(sections, table, &raster.shape, thickness))
        });
        let with_shapes = separable.as_ref().map(|(sections, shapes)| (*sections, shapes));
        prepared.shapes.update(raster, &plan.view, &slabs.grid, with_shapes);
        let slabs = SlabView::new(slabs, raster, &prepared.shapes, plan.volume.grid().unit());
        Self {
            spans: SpanFinder::new(&slabs, merged.map(|merged| &merged.levels)),
            classes: Classes {
                most_of_separable: with_shapes
                    .zip(budget)
                    .map_or(f32::NEG_INFINITY, |((sections, shapes), budget)| {
                        most_extinction(sections, shapes, budget)
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

    /// How sections in a slab are drawn by separable footprints, if they are: whole ones, and what it cuts.
    #[inline(always)]
    pub(super) fn as_separable<'s>(&'s self, slab: usize) -> [Option<AsSeparable<'s>>; 2] {
        let Some((sections, shapes)) = &self.separable else { return [None; 2] };
        let [whole, cut] = self.slabs.shapes.separable(slab);
        let drawn = |slab: &'s SeparableSlab| {
            let [right, up] = shapes.drift.map(|drift| drift as f32 * slab.pixels_per_world());
            AsSeparable { sections, slab, drift: [right, -up] }
        };
        let cut = if shapes.cut == shapes.whole { whole } else { cut };
        [whole.map(drawn), cut.map(drawn)]
    }
}
