//! What sheets of densities are shown by (model §§8, 12), as the shaders read it.

use crate::density_elements::{self, ELEMENTS_OF_CELL, ELEMENTS_OF_SURFACE, Element};
use crate::frame_params::SplatLayer;
use crate::job::JobLayer;
use crate::known_volume::KnownVolume;
use crate::params::{Densities, flag};
use slabsplat_backend::densities::{FAINT_GRADIENT, ValueScale};
use slabsplat_backend::{
    DensitySplats, FramePlan, LayerPlan, ShownDensities, SmoothSections, Splats,
};
use slabsplat_core::Statistic;
use slabsplat_shaders::{
    SPLAT_ISOSURFACES, SPLAT_JOINED_ISOSURFACES, SPLAT_JOINED_PARTS, SPLAT_JOINED_STATISTICS,
    SPLAT_PARTS, SPLAT_STATISTIC, Shader,
};

/// What a frame of densities needs beside its layers.
#[derive(Clone, Debug)]
pub(crate) struct DensityJob {
    /// Of each layer.
    pub(crate) params: Vec<Densities>,
    /// What the shaders' `table` ends with: of each layer, cells of its transfer function or its surfaces.
    pub(crate) shown: Vec<Element>,
    pub(crate) stage: DensityStage,
}

/// What splats densities.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DensityStage {
    pub(crate) shader: &'static Shader,
    /// Elements that a pixel holds from sheet to sheet.
    pub(crate) n_held: u64,
}

impl DensityJob {
    /// Of a plan whose layers are these and listed so, if they are of densities. Their `table` has so many
    /// elements before what densities are shown by.
    pub(crate) fn new(
        plan: &FramePlan<'_>,
        layers: &[SplatLayer<'_, '_>],
        job_layers: &[JobLayer],
        n_before: u32,
    ) -> Option<Self> {
        let (mut params, mut shown) = (Vec::new(), Vec::new());
        let mut stage = None;
        for ((layer, splats), job_layer) in layers.iter().zip(job_layers) {
            let Splats::Densities(splats) = splats else { return None };
            let known = job_layer.listing.samples().expect("densities are listed by value");
            let first_shown = n_before + shown.len() as u32;
            let (of_layer, elements) = of_layer(plan, layer, splats, known);
            params.push(Densities { first_shown, ..of_layer });
            shown.extend(elements);
            stage = Some(DensityStage::of(splats.shown, layers.len(), plan.meshes.is_some()));
        }
        stage.map(|stage| Self { params, shown, stage })
    }
}

impl DensityStage {
    /// A layer that is alone, without meshes, has stages of its own, which take fewer registers.
    fn of(shown: ShownDensities, n_layers: usize, has_meshes: bool) -> Self {
        let is_alone = n_layers == 1 && !has_meshes;
        let shader = match (shown, is_alone) {
            (ShownDensities::Composited, true) => &SPLAT_PARTS,
            (ShownDensities::Composited, false) => &SPLAT_JOINED_PARTS,
            (ShownDensities::Statistic(_), true) => &SPLAT_STATISTIC,
            (ShownDensities::Statistic(_), false) => &SPLAT_JOINED_STATISTICS,
            (ShownDensities::Isosurfaces, true) => &SPLAT_ISOSURFACES,
            (ShownDensities::Isosurfaces, false) => &SPLAT_JOINED_ISOSURFACES,
        };
        let n_held = match shown {
            ShownDensities::Statistic(_) => n_layers as u64,
            ShownDensities::Composited | ShownDensities::Isosurfaces => 1,
        };
        Self { shader, n_held }
    }
}

/// What shaders read of a layer, but for where the elements are that it is shown by; and these.
fn of_layer(
    plan: &FramePlan<'_>,
    layer: &LayerPlan<'_>,
    splats: &DensitySplats,
    known: &KnownVolume,
) -> (Densities, Vec<Element>) {
    let finite = known.finite_range();
    let scale = ValueScale::of(layer, splats.shown, finite);
    let extent = finite.map_or(0.0, |range| scale.extent(range));
    let (shown, n_elements) = match splats.shown {
        ShownDensities::Composited => {
            let weight = |opacity| plan.compositing.weight(opacity);
            (density_elements::cells(layer.transfer, weight, &scale), ELEMENTS_OF_CELL)
        }
        ShownDensities::Statistic(_) => {
            let weight = |opacity| opacity;
            (density_elements::cells(layer.transfer, weight, &scale), ELEMENTS_OF_CELL)
        }
        ShownDensities::Isosurfaces => {
            (density_elements::surfaces(layer, &scale), ELEMENTS_OF_SURFACE)
        }
    };
    let mut params = Densities {
        mode: mode_code(splats.shown),
        n_shown: shown.len() as u32 / n_elements,
        values: scale.ends(),
        worst: match splats.shown {
            ShownDensities::Statistic(statistic) => scale.worst(statistic, &layer.relevant),
            ShownDensities::Composited | ShownDensities::Isosurfaces => 0.0,
        },
        per_rise: (1.0 / scale.rise()) as f32,
        // Never 0, which a gradient of 0 would be divided by.
        faint: ((FAINT_GRADIENT * extent) as f32).max(f32::MIN_POSITIVE),
        ..bytemuck::Zeroable::zeroed()
    };
    put_sections(&splats.smooth, &mut params);
    (params, shown)
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
