//! What the footprints of a frame are drawn by: polynomials, or tables where no polynomial is good enough;
//! and the stage that does it. All layers are drawn alike.

use crate::frame_params::SplatLayer;
use crate::tables::{LayerTables, Table};
use slabsplat_backend::{
    ByIdentity, ColorSplats, FramePlan, PolynomialPair, SectionSplats, Splats,
};
use slabsplat_core::Compositing;
use slabsplat_kernel::{Degree, ErrorBudget, FootprintTable, RadialPolynomials, SectionTable};
use slabsplat_shaders::{
    SPLAT_EXACT_SECTIONS, SPLAT_SECTIONS, SPLAT_SLICES, SPLAT_TABLE_SECTIONS, SPLAT_VOXELS, Shader,
};
use std::sync::Arc;

/// The tables of all layers, and the stage that splats colours by them.
#[derive(Clone, Debug)]
pub(crate) struct DrawnBy {
    pub(crate) tables: Vec<LayerTables>,
    pub(crate) shader: &'static Shader,
}

/// What was fitted to the last plan's tables, cached for the next one.
#[derive(Debug, Default)]
pub(crate) struct LastFits {
    sections: Vec<(SectionsKey, PolynomialPair)>,
    footprints: Vec<(ByIdentity<FootprintTable>, Arc<RadialPolynomials>)>,
}

type SectionsKey = (ByIdentity<SectionTable>, Option<ErrorBudget>);

impl LastFits {
    /// What the layers of a plan are drawn by.
    pub(crate) fn of(&mut self, plan: &FramePlan<'_>, layers: &[SplatLayer<'_, '_>]) -> DrawnBy {
        // What this plan does not need is dropped.
        let last = std::mem::take(self);
        let is_tilted = layers.iter().any(|(layer, _)| layer.shape.is_tilted(layer.radius));
        // Nothing is fitted to tilted sections, whose tables are new in every frame of a camera that turns.
        let kind = if is_tilted { None } else { self.kind(&last, plan.compositing, layers) };
        let tables = layers.iter().map(|(_, splats)| match splats {
            Splats::Densities(densities) => Table::of_densities(densities).alone(),
            Splats::Colors(ColorSplats::Sections(sections)) => {
                let budget = budget_of(sections);
                let mut of = |table: &Arc<SectionTable>| match kind {
                    None => Table::Sections(table.clone()),
                    Some(_) => {
                        Table::Polynomials(self.pair(&last, table, budget).of(false).clone())
                    }
                };
                let merged = sections.merged.as_ref();
                LayerTables {
                    sections: of(&sections.table),
                    merged: merged.map_or(Table::None, |merged| of(&merged.table)),
                }
            }
            Splats::Colors(ColorSplats::Slices { table, .. } | ColorSplats::Voxels { table }) => {
                Table::Polynomials(self.footprint(&last, table)).alone()
            }
        });
        let tables = tables.collect();
        let shader = match layers.first().map(|(_, splats)| *splats) {
            Some(Splats::Colors(ColorSplats::Sections(_))) => match kind {
                None => &SPLAT_TABLE_SECTIONS,
                Some(Degree::Low) => &SPLAT_SECTIONS,
                Some(Degree::High) => &SPLAT_EXACT_SECTIONS,
            },
            Some(Splats::Colors(ColorSplats::Slices { .. })) => &SPLAT_SLICES,
            Some(Splats::Colors(ColorSplats::Voxels { .. })) => &SPLAT_VOXELS,
            // Densities have stages of their own, and where there is no layer any stage would do.
            Some(Splats::Densities(_)) | None => &SPLAT_SECTIONS,
        };
        DrawnBy { tables, shader }
    }

    /// The degree that is enough for the sections of all layers; `None` if no polynomial is.
    fn kind(
        &mut self,
        last: &Self,
        compositing: Compositing,
        layers: &[SplatLayer<'_, '_>],
    ) -> Option<Degree> {
        let mut degree = Degree::Low;
        for (_, splats) in layers {
            let Splats::Colors(ColorSplats::Sections(sections)) = splats else { continue };
            let budget = budget_of(sections);
            let pair = self.pair(last, &sections.table, budget);
            if budget.is_none() && !pair.are_exact(compositing) {
                return None;
            }
            let merged = sections.merged.as_ref();
            let merged = merged.map(|merged| self.pair(last, &merged.table, budget));
            if !pair.is_low() || merged.is_some_and(|merged| !merged.is_low()) {
                degree = Degree::High;
            }
        }
        Some(degree)
    }

    fn pair(
        &mut self,
        last: &Self,
        table: &Arc<SectionTable>,
        budget: Option<ErrorBudget>,
    ) -> PolynomialPair {
        let key = (ByIdentity::of(table), budget);
        found_or_added(&mut self.sections, &last.sections, key, || {
            PolynomialPair::new(table, budget)
        })
    }

    fn footprint(&mut self, last: &Self, table: &Arc<FootprintTable>) -> Arc<RadialPolynomials> {
        found_or_added(&mut self.footprints, &last.footprints, ByIdentity::of(table), || {
            Arc::new(RadialPolynomials::of_footprint(table, Degree::High))
        })
    }
}

/// What sections may be off, if they need not be exact.
fn budget_of(sections: &SectionSplats) -> Option<ErrorBudget> {
    sections.merged.as_ref().map(|merged| merged.budget)
}

/// The value of a key among those of this plan, or of the last; else a new one.
fn found_or_added<K: PartialEq, V: Clone>(
    all: &mut Vec<(K, V)>,
    last: &[(K, V)],
    key: K,
    make: impl FnOnce() -> V,
) -> V {
    if let Some((_, found)) = all.iter().find(|(other, _)| *other == key) {
        return found.clone();
    }
    let found = last.iter().find(|(other, _)| *other == key);
    let value = found.map_or_else(make, |(_, value)| value.clone());
    all.push((key, value.clone()));
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_backend::Planner;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{
        Camera, Grid, Layer, Method, Projection, RenderSettings, Scaling, Scene, TransferFunction,
        Volume,
    };

    fn scene(steps: [f64; 3]) -> Scene {
        let grid = Grid::with_spacing([3; 3], steps).unwrap();
        let volume = Volume::new(grid, vec![1_u8; 27].into(), Scaling::IDENTITY).unwrap();
        let transfer = TransferFunction::new(vec![(0.0, [0.9])], vec![(0.0, [1.0; 3])]).unwrap();
        let projection = Projection::Orthographic { view_height: 8.0 };
        let eye = DVec3::new(9.0, 7.0, 5.0);
        let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, projection).unwrap();
        Scene::new(Layer::new(volume, transfer), camera)
    }

    /// What draws a scene twice, the second time from what was cached.
    fn drawn_by(scene: &Scene) -> DrawnBy {
        let plan = Planner::default().plan(scene).unwrap();
        let layers: Vec<SplatLayer<'_, '_>> =
            plan.layers.iter().map(|layer| (layer, &layer.splats)).collect();
        let mut fits = LastFits::default();
        let [first, second] = [0, 1].map(|_| fits.of(&plan, &layers));
        assert!(first.tables[0].sections.is(&second.tables[0].sections), "it is fitted once");
        assert!(first.tables[0].merged.is(&second.tables[0].merged), "so is what is merged");
        assert_eq!(first.shader.name, second.shader.name);
        second
    }

    #[test]
    fn drawn_by_what_is_good_enough() {
        let cubic = scene([1.0; 3]);
        let check = |settings: RenderSettings, expected: &str| {
            let drawn_by = drawn_by(&cubic.clone().settings(settings));
            assert_eq!(drawn_by.shader.name, expected);
            let is_fitted = matches!(drawn_by.tables[0].sections, Table::Polynomials(_));
            assert_eq!(is_fitted, expected != "splat_table_sections");
        };
        let settings = RenderSettings::default();
        check(settings.clone(), "splat_sections");
        check(settings.clone().tolerance(0.0), "splat_exact_sections");
        check(settings.clone().tolerance(1e-3), "splat_exact_sections");
        check(settings.clone().method(Method::AxisAligned), "splat_slices");
        check(settings.clone().method(Method::EverySample), "splat_voxels");
        let coarse = settings.tolerance(0.0).radial_samples(16);
        check(coarse, "splat_table_sections");
    }

    #[test]
    fn drawn_by_tables_at_a_slant() {
        let drawn_by = drawn_by(&scene([1.0, 1.0, 1.5]));
        assert_eq!(drawn_by.shader.name, "splat_table_sections");
        assert!(matches!(drawn_by.tables[0].sections, Table::Sections(_)));
        assert!(matches!(drawn_by.tables[0].merged, Table::Sections(_)));
    }
}
