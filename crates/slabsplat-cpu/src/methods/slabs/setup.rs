//! All that is decided of a frame before its first voxel is looked at.

use super::beyond::Beyond;
use super::classes::Classes;
use super::slab_shapes::SlabShapes;
use super::slab_view::SlabView;
use super::span_finder::{SpanFinder, Splits};
use super::stage::Stage;
use crate::footprints::polynomials::SectionPolynomials;
use crate::sections::cut::SlabCut;
use crate::sections::shared::{Fitted, Sections};
use crate::separable::sections::{AsSeparable, SeparableTables, most_extinction};
use crate::separable::slab::SeparableSlab;
use slabsplat_backend::{DensitySplats, SectionSplats, Slabs, SmoothSections};
use slabsplat_core::{Cancelled, FrameHandle, SlabGrid};
use slabsplat_kernel::{
    CubicSectionTable, ErrorBudget, SectionTable, SeparableSections, SeparableShapes,
    TiltedSections,
};
use std::sync::Arc;

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
    pub(super) frame: &'a FrameHandle,
    /// Where slabs are, and what they cover.
    pub(super) slabs: SlabView<'a>,
    /// Which slabs voxels are drawn in.
    pub(super) spans: SpanFinder<'a>,
    /// How many slabs before all that kernels meet anything of a brick may be drawn.
    pub(super) most_slabs_before: usize,
    /// Which voxels wait for how many slabs, and how they are drawn.
    pub(super) classes: Classes,
    /// What they are drawn by.
    pub(super) sections: Sections<'a>,
    /// Which of them the region hides, if there is one.
    pub(super) beyond: Option<Beyond<'a>>,
    separable: Option<(&'a SeparableSections, SeparableShapes)>,
}

/// What a frame's sections are made of.
#[derive(Clone, Copy)]
pub(in crate::methods) struct SectionsInSlabs<'a> {
    slabs: &'a Slabs,
    table: &'a Arc<SectionTable>,
    tilted: Option<&'a TiltedSections>,
    /// Read for what there are no tilted sections for, instead of the table.
    cubic: Option<&'a CubicSectionTable>,
    /// All that lies before or behind a face, and what may be off for that it is drawn otherwise.
    whole: Option<(&'a Arc<SectionTable>, ErrorBudget)>,
    splits: Splits<'a>,
    /// Whether means are taken of what sections sum, so that it counts what part of a voxel they are off.
    are_of_means: bool,
}

impl<'a> SectionsInSlabs<'a> {
    /// Of voxels that are shaded.
    pub(in crate::methods) fn of_colors(splats: &'a SectionSplats) -> Self {
        let SectionSplats { slabs, table, tilted, merged, .. } = splats;
        Self {
            slabs,
            table,
            tilted: tilted.as_deref(),
            cubic: None,
            whole: merged.as_ref().map(|merged| (&merged.table, merged.budget)),
            splits: merged
                .as_ref()
                .map_or(Splits::All, |merged| Splits::ByExtinction(&merged.levels)),
            are_of_means: false,
        }
    }

    /// Where they are.
    pub(in crate::methods) fn slabs(&self) -> &'a SlabGrid {
        &self.slabs.grid
    }

    /// Of voxels that have values.
    pub(in crate::methods) fn of_densities(splats: &'a DensitySplats) -> Self {
        let DensitySplats { slabs, table, smooth, separable, .. } = splats;
        let (tilted, cubic) = match smooth {
            SmoothSections::Product(sections) => (Some(&**sections), None),
            SmoothSections::Table(table) => (None, Some(&**table)),
        };
        let whole = separable.as_ref().map(|separable| (&separable.whole, separable.budget));
        Self { slabs, table, tilted, cubic, whole, splits: Splits::All, are_of_means: true }
    }

    /// The same as whole footprints, each in one of the slabs that it meets; `None` if there are none but of
    /// slabs, or if not all slabs are drawn.
    pub(in crate::methods) fn of_whole_densities(splats: &'a DensitySplats) -> Option<Self> {
        let all = Self::of_densities(splats);
        let are_there = all.tilted.is_some() && all.slabs.first_drawn == 0;
        are_there.then_some(Self { splits: Splits::Never, ..all })
    }
}

impl<'a> Setup<'a> {
    pub(super) fn new(
        stage: &Stage<'a>,
        sections: &SectionsInSlabs<'a>,
        prepared: &'a mut Prepared,
        at_once: usize,
    ) -> Result<Self, Cancelled> {
        let SectionsInSlabs { slabs, table, tilted, cubic, whole, splits, are_of_means } =
            *sections;
        let (raster, layer) = (stage.raster, stage.layer);
        let budget = whole.map(|(_, budget)| budget);
        let fit = |polynomials: &'a mut SectionPolynomials, table| {
            let polynomials = polynomials.of(table, budget, stage.frame)?;
            Ok(Fitted { table, polynomials })
        };
        let fitted_whole = whole.map(|(table, _)| fit(&mut prepared.merged, table)).transpose()?;
        // Tilted sections need no polynomials of a table, which on a grid that turns are new every frame.
        let fitted = match fitted_whole.filter(|_| tilted.is_some()) {
            Some(fitted) => fitted,
            None => fit(&mut prepared.sections, table)?,
        };
        let n_sections = slabs.n_before + 1;
        let smooth = (tilted, cubic);
        let fitted = (fitted, fitted_whole);
        let sections = Sections::new(raster, stage.plan.compositing, fitted, smooth, n_sections);
        let separable = match whole {
            Some((whole, _)) => prepared.separable.of([table, whole], stage.frame)?,
            None => None,
        };
        let thickness = slabs.grid.thickness();
        let separable = separable.map(|sections| {
            (sections, SeparableShapes::new(sections, table, &raster.shape, thickness))
        });
        let with_shapes = separable.as_ref().map(|(sections, shapes)| (*sections, shapes));
        prepared.shapes.update(raster, &layer.view, &slabs.grid, with_shapes);
        let slabs = SlabView::new(slabs, stage, &prepared.shapes, at_once);
        let spans = SpanFinder::new(&slabs, splits);
        Ok(Self {
            frame: stage.frame,
            most_slabs_before: spans.most_slabs_before(stage.has_finer()),
            spans,
            beyond: Beyond::new(stage, slabs.grid),
            classes: Classes {
                most_of_separable: with_shapes.zip(budget).map_or(
                    f32::NEG_INFINITY,
                    |((sections, shapes), budget)| {
                        let most = most_extinction(sections, shapes, budget);
                        if are_of_means { most * sections.whole() } else { most }
                    },
                ),
                is_merged: whole.is_some() && !matches!(splits, Splits::All),
                kind: sections.kind,
                n_before: slabs.n_before,
            },
            slabs,
            sections,
            separable,
        })
    }

    /// A slab that is about to be splatted, onto those channels of a sheet.
    #[inline(always)]
    pub(super) fn cut(&self, slab: usize, channels: [f32; 4]) -> SlabCut<'_> {
        let shape = self.slabs.shape(slab);
        let faces = self.slabs.grid.faces(slab).map(|face| face as f32);
        SlabCut { sections: &self.sections, slab, shape, channels, faces }
    }

    /// How the sections of two slabs that follow each other are drawn by separable footprints at once, if
    /// they are: wherever a slab is, they have one shape, and their middles one position.
    #[inline(always)]
    pub(super) fn pair_as_separable(&self, first: usize) -> Option<AsSeparable<'_>> {
        let is_drawn = self.slabs.first_drawn <= first && first + 1 < self.slabs.grid.n_slabs();
        let are_alike = is_drawn && self.slabs.shapes.only().is_some();
        let [_, cut] = self.as_separable(first);
        cut.filter(|cut| are_alike && cut.drift == [0.0; 2])
    }

    /// How sections in a slab are drawn by separable footprints, if they are: whole ones, and what it cuts.
    #[inline(always)]
    pub(super) fn as_separable<'s>(&'s self, slab: usize) -> [Option<AsSeparable<'s>>; 2] {
        let Some((sections, shapes)) = &self.separable else { return [None; 2] };
        let [whole, cut] = self.slabs.shapes.separable(slab);
        let drawn = |slab: &'s SeparableSlab| {
            let [right, up] = shapes.drift.map(|drift| drift as f32 * slab.pixels_per_world);
            AsSeparable { sections, slab, drift: [right, -up] }
        };
        let cut = if shapes.cut == shapes.whole { whole } else { cut };
        [whole.map(drawn), cut.map(drawn)]
    }
}
