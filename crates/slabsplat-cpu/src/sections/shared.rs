//! What all sections of a frame share.

use crate::footprints::raster::Raster;
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use slabsplat_backend::PolynomialPair;
use slabsplat_core::{Compositing, Lookup};
use slabsplat_kernel::{CubicSectionTable, SectionTable, TiltedSections, chord_units_per_index};

/// A table of sections, and what was fitted to it.
#[derive(Clone, Copy)]
pub(crate) struct Fitted<'a> {
    pub(crate) table: &'a SectionTable,
    pub(crate) polynomials: &'a PolynomialPair,
}

/// What voxels are like that are prepared together.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// They are drawn whole.
    Whole,
    /// Slabs cut them at one depth for all of a footprint.
    Upright,
    /// Slabs cut them at a depth that differs from pixel to pixel.
    Tilted,
    /// Their sections are read from the table, pixel by pixel.
    ByTable,
    /// The same from a table without kinks.
    ByCubicTable,
}

/// The sections of a frame.
pub(crate) struct Sections<'a> {
    pub(crate) raster: &'a Raster,
    /// What lies between a slab's two faces.
    slabs: Fitted<'a>,
    /// With all that lies before or behind a face, if sections may be merged.
    merged: Option<Fitted<'a>>,
    /// Half the thickness of a kernel along a ray, in index units: its radius, or more if slabs are tilted.
    pub(crate) half_depth_in_index: f32,
    /// `2/R²`.
    pub(crate) edge_per_disc: f32,
    /// Units of chords in an index unit.
    pub(crate) chord_units_per_index: f32,
    /// Sections by slabs that cut footprints at an offset that differs from pixel to pixel.
    pub(crate) tilted: Option<&'a TiltedSections>,
    /// A table to be read instead of the others, if there is one.
    pub(crate) cubic: Option<&'a CubicSectionTable>,
    /// How the voxels that slabs cut are drawn: from the table, if no polynomial is good enough.
    pub(crate) kind: Kind,
    /// Sections of voxels of no more extinction are drawn by polynomials of low degree.
    pub(crate) most_of_low_degree: f32,
}

impl<'a> Sections<'a> {
    /// Those of kernels that are cut into up to `n_sections`.
    pub(crate) fn new(
        raster: &'a Raster,
        compositing: Compositing,
        (slabs, merged): (Fitted<'a>, Option<Fitted<'a>>),
        (tilted, cubic): (Option<&'a TiltedSections>, Option<&'a CubicSectionTable>),
        n_sections: usize,
    ) -> Self {
        let is_exact = merged.is_some() || slabs.polynomials.are_exact(compositing);
        let most = |fitted: &Fitted<'_>| fitted.polynomials.most_of_low_degree(n_sections);
        Self {
            raster,
            slabs,
            merged,
            half_depth_in_index: raster.half_depth * raster.index_per_depth,
            edge_per_disc: 2.0 / (raster.radius * raster.radius),
            chord_units_per_index: chord_units_per_index(raster.radius.into()) as f32,
            tilted,
            cubic,
            kind: match (tilted, cubic) {
                (Some(_), _) => Kind::Tilted,
                (_, Some(_)) => Kind::ByCubicTable,
                _ if is_exact && !raster.is_tilted => Kind::Upright,
                _ => Kind::ByTable,
            },
            // Only where colours are weighted with it do errors shrink with the extinction.
            most_of_low_degree: if compositing.weights_colors() {
                most(&slabs).min(merged.as_ref().map_or(f32::INFINITY, most))
            } else {
                f32::NEG_INFINITY
            },
        }
    }

    /// Those of slabs, or of all that lies before or behind a face.
    #[inline(always)]
    pub(crate) fn fitted(&self, is_merged: bool) -> Fitted<'a> {
        match self.merged {
            Some(merged) if is_merged => merged,
            _ => self.slabs,
        }
    }

    /// Where sections are in their tables, in rows.
    #[inline(always)]
    pub(crate) fn rows_of<S: Simd>(
        &self,
        simd: S,
        [front, back]: [f32x8<S>; 2],
        is_merged: mask32x8<S>,
    ) -> f32x8<S> {
        let table = self.slabs.table;
        let (rows, merged) = (table.rows(), self.fitted(true).table.rows());
        let from_front = back + rows.radius;
        let from_nearer = if rows.mirrored {
            from_front.min(f32x8::splat(simd, rows.radius) - front)
        } else {
            from_front
        };
        let per_index = is_merged.select(
            f32x8::splat(simd, merged.rows_per_index),
            f32x8::splat(simd, rows.rows_per_index),
        );
        let last = is_merged
            .select(f32x8::splat(simd, merged.last_row), f32x8::splat(simd, rows.last_row));
        let row = (from_nearer * per_index).max(f32x8::splat(simd, 0.0)).min(last);
        match table.lookup() {
            Lookup::Nearest => (row + 0.5).floor(),
            Lookup::Linear => row,
        }
    }
}
