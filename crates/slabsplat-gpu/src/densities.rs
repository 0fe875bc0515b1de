//! What sheets of densities are shown by (model §§8, 12), as the shaders read it.

use crate::density_elements::{self, ELEMENTS_OF_CELL, ELEMENTS_OF_SURFACE, Element};
use crate::known_volume::KnownVolume;
use crate::params::{Densities, flag};
use slabsplat_backend::densities::{FAINT_GRADIENT, ValueScale};
use slabsplat_backend::{DensitySplats, FramePlan, LayerPlan, ShownDensities, SmoothSections};
use slabsplat_core::Statistic;
use slabsplat_shaders::{SPLAT_ISOSURFACES, SPLAT_PARTS, SPLAT_STATISTIC, Shader};

/// What a frame of densities needs beside its layer.
#[derive(Clone, Debug)]
pub(crate) struct DensityJob {
    pub(crate) params: Densities,
    /// What the shaders' `table` ends with: cells of the transfer function, or surfaces.
    pub(crate) shown: Vec<Element>,
    /// What splats them.
    pub(crate) shader: &'static Shader,
}

impl DensityJob {
    /// Of a plan with that layer alone, whose table has so many elements before what densities are shown by.
    pub(crate) fn new(
        plan: &FramePlan<'_>,
        layer: &LayerPlan<'_>,
        splats: &DensitySplats,
        known: &KnownVolume,
        first_shown: u32,
    ) -> Self {
        let finite = known.finite_range();
        let scale = ValueScale::of(layer, splats.shown, finite);
        let extent = finite.map_or(0.0, |range| scale.extent(range));
        let (shader, shown, n_elements) = match splats.shown {
            ShownDensities::Composited => {
                let weight = |opacity| plan.compositing.weight(opacity);
                let cells = density_elements::cells(layer.transfer, weight, &scale);
                (&SPLAT_PARTS, cells, ELEMENTS_OF_CELL)
            }
            ShownDensities::Statistic(_) => {
                let cells = density_elements::cells(layer.transfer, |opacity| opacity, &scale);
                (&SPLAT_STATISTIC, cells, ELEMENTS_OF_CELL)
            }
            ShownDensities::Isosurfaces => {
                let surfaces = density_elements::surfaces(layer, &scale);
                (&SPLAT_ISOSURFACES, surfaces, ELEMENTS_OF_SURFACE)
            }
        };
        let mut params = Densities {
            mode: mode_code(splats.shown),
            first_shown,
            n_shown: shown.len() as u32 / n_elements,
            values: scale.ends(),
            // Never 0, which a gradient of 0 would be divided by.
            faint: ((FAINT_GRADIENT * extent) as f32).max(f32::MIN_POSITIVE),
            ..bytemuck::Zeroable::zeroed()
        };
        put_sections(&splats.smooth, &mut params);
        Self { params, shown, shader }
    }
}

fn put_sections(sections: &SmoothSections, params: &mut Densities) {
    params.is_product = flag(matches!(sections, SmoothSections::Product(_)));
    match sections {
        SmoothSections::Product(sections) => {
            params.across = coefficients(sections.across());
            params.along = coefficients(sections.along());
        }
        SmoothSections::Table(table) => params.rim = table.rim(),
    }
}

/// The coefficients of a polynomial, and zeros behind them.
fn coefficients(of_powers: &[f32]) -> [[f32; 4]; 3] {
    let mut coefficients = [[0.0; 4]; 3];
    coefficients.as_flattened_mut()[..of_powers.len()].copy_from_slice(of_powers);
    coefficients
}

/// The number by which the shaders know what is shown.
pub(crate) fn mode_code(shown: ShownDensities) -> u32 {
    match shown {
        ShownDensities::Composited => 0,
        ShownDensities::Statistic(Statistic::Maximum) => 1,
        ShownDensities::Statistic(Statistic::Minimum) => 2,
        ShownDensities::Statistic(Statistic::Average) => 3,
        ShownDensities::Isosurfaces => 4,
    }
}
