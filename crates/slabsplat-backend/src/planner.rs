//! Makes frame plans, and keeps the tables that the next frame can use again.

use crate::{
    Cached, ColorSplats, DensitySplats, FramePlan, MergedSections, SectionSplats,
    SeparableDensities, Slabs, SmoothSections, Splats,
};
use slabsplat_core::{
    BlinnPhong, ImageError, Lookup, Method, Normalization, RenderSettings, Scene, SettingsError,
    Shading, ShadingError, SliceOrder, TooManySlabs, View, ViewError, Volume,
};
use slabsplat_kernel::{
    CubicSectionTable, ErrorBudget, FootprintShape, FootprintTable, Kernel, SectionDesc,
    SectionTable, SplitLevels, SplitView, TableDesc, TiltedSections, UnknownKernel, kernel_named,
};
use std::sync::Arc;
use thiserror::Error;

/// Why a scene cannot be drawn.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// There is no such kernel.
    #[error(transparent)]
    UnknownKernel(#[from] UnknownKernel),
    /// A width, count or cut-off cannot be used.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// There is no such picture.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// Voxels would be too large or too small.
    #[error(transparent)]
    View(#[from] ViewError),
    /// A coefficient of the shading cannot be used.
    #[error(transparent)]
    Shading(#[from] ShadingError),
    /// The slabs are too thin for the volume.
    #[error(transparent)]
    TooManySlabs(#[from] TooManySlabs),
}

/// Makes frame plans. Tables of sections cost a millisecond or more, and seldom change
/// from one frame to the next, so the last ones are cached.
#[derive(Debug, Default)]
pub struct Planner {
    sections: Cached<TableKey, Arc<SectionTable>>,
    whole: Cached<TableKey, Arc<SectionTable>>,
    footprint: Cached<TableKey, Arc<FootprintTable>>,
    cubic: Cached<TableKey, Arc<CubicSectionTable>>,
    tilted: Cached<TableKey, Option<Arc<TiltedSections>>>,
}

/// Everything that the tables are made from.
#[derive(Clone, Debug, PartialEq)]
struct TableKey {
    kappa: f64,
    settings: RenderSettings,
}

impl TableKey {
    /// The sections by slabs of that width.
    fn sections_of(&self, kernel: &dyn Kernel, width: f64) -> SectionTable {
        let Self { kappa, ref settings } = *self;
        let desc = SectionDesc {
            kernel,
            width,
            kappa,
            normalization: settings.normalization,
            base_width: settings.base_slab_width,
        };
        let table = TableDesc {
            sections: settings.sections,
            radial_samples: settings.radial_samples,
            lookup: settings.lookup,
        };
        SectionTable::new(&desc, table)
    }
}

impl Planner {
    /// Plans a frame of `scene` that draws the voxels of `volume` whose opacity is above 0.
    ///
    /// # Errors
    /// If the settings name no kernel, or their numbers cannot be used with this volume.
    pub fn plan<'a>(
        &mut self,
        volume: &'a Arc<Volume>,
        scene: &'a Scene,
    ) -> Result<FramePlan<'a>, PlanError> {
        let settings = scene.settings.clone().checked()?;
        scene.image.checked()?;
        if let Shading::Phong(phong) = scene.shading {
            phong.checked()?;
        }
        let kernel = kernel_named(&settings.kernel.0)?;
        let view = View::new(volume.grid(), &scene.camera, &scene.image)?;
        let shape = FootprintShape::new(volume.grid(), view.axes());
        settings.check_hierarchy(shape.kappa)?;
        let half_depth = kernel.radius() * shape.half_depth;
        let key = TableKey { kappa: rounded(shape.kappa), settings };
        let splats = match key.settings.method {
            Method::ImageAligned => {
                Splats::Colors(ColorSplats::Sections(Box::new(SectionSplats {
                    slabs: Slabs::new(volume.grid(), &view, half_depth, key.settings.slab_width)?,
                    merged: self.merged_sections(
                        &*kernel,
                        &key,
                        &view,
                        &shape,
                        volume.grid().unit(),
                    ),
                    tilted: self.tilted_sections(&*kernel, &key, &shape),
                    table: self.section_table(&*kernel, key),
                })))
            }
            Method::AxisAligned => Splats::Colors(ColorSplats::Slices {
                order: SliceOrder::new(volume.grid(), view.axes().forward),
                table: self.footprint_table(&*kernel, key),
            }),
            Method::EverySample => {
                Splats::Colors(ColorSplats::Voxels { table: self.footprint_table(&*kernel, key) })
            }
            Method::PostClassified => {
                let width = DensitySplats::SHEETS_PER_SLAB.recip() * key.settings.slab_width;
                let slabs = Slabs::new(volume.grid(), &view, half_depth, width)?;
                Splats::Densities(Box::new(self.densities(&*kernel, key, slabs)))
            }
        };
        Ok(FramePlan {
            volume,
            relevant: scene.transfer.iso_ranges(),
            transfer: &scene.transfer,
            light: match scene.shading {
                Shading::None => None,
                Shading::Phong(phong) => Some(BlinnPhong::new(phong, view.axes().forward)),
            },
            view,
            image: scene.image,
            radius: kernel.radius(),
            shape,
            half_depth,
            compositing: scene.settings.compositing,
            opacity_cutoff: scene.settings.opacity_cutoff as f32,
            splats,
        })
    }

    fn merged_sections(
        &mut self,
        kernel: &dyn Kernel,
        key: &TableKey,
        view: &View,
        shape: &FootprintShape,
        unit: f64,
    ) -> Option<MergedSections> {
        let layer_depth = shape.half_depth / unit;
        let view = SplitView { layer_depth, steepest_ray: view.steepest_ray() };
        let levels = SplitLevels::new(&key.settings, kernel, view);
        if levels.are_all_last() {
            return None;
        }
        let table = self.whole_table(kernel, key);
        Some(MergedSections { levels, table, budget: ErrorBudget::new(&key.settings) })
    }

    /// Sections with all that lies before or behind a face.
    fn whole_table(&mut self, kernel: &dyn Kernel, key: &TableKey) -> Arc<SectionTable> {
        let table = self.whole.made_of(key.clone(), |key| {
            Arc::new(key.sections_of(kernel, 2.0 * kernel.radius() / key.kappa))
        });
        table.clone()
    }

    /// Of what the definition leaves to a table, only that is without one which no setting of tables changes.
    fn tilted_sections(
        &mut self,
        kernel: &dyn Kernel,
        key: &TableKey,
        shape: &FootprintShape,
    ) -> Option<Arc<TiltedSections>> {
        let settings = &key.settings;
        let reads_table = settings.lookup == Lookup::Nearest
            || settings.normalization != Normalization::None
            || !shape.is_tilted(kernel.radius());
        if reads_table {
            return None;
        }
        self.product_sections(kernel, key)
    }

    /// `None` if the kernel is no product.
    fn product_sections(
        &mut self,
        kernel: &dyn Kernel,
        key: &TableKey,
    ) -> Option<Arc<TiltedSections>> {
        let made = |key: &TableKey| TiltedSections::new(kernel, key.kappa).map(Arc::new);
        self.tilted.made_of(key.clone(), made).clone()
    }

    fn section_table(&mut self, kernel: &dyn Kernel, key: TableKey) -> Arc<SectionTable> {
        let table = |key: &TableKey| Arc::new(key.sections_of(kernel, key.settings.slab_width));
        self.sections.made_of(key, table).clone()
    }

    /// Sections that were normalised would no longer measure lengths, so these never are.
    fn densities(
        &mut self,
        kernel: &dyn Kernel,
        TableKey { kappa, settings }: TableKey,
        slabs: Slabs,
    ) -> DensitySplats {
        let width = DensitySplats::SHEETS_PER_SLAB.recip() * settings.slab_width;
        let settings =
            settings.normalization(Normalization::None).lookup(Lookup::Linear).slab_width(width);
        let budget = ErrorBudget::of_densities(&settings);
        let key = TableKey { kappa, settings };
        let product = self.product_sections(kernel, &key);
        let separable = product
            .as_ref()
            .filter(|_| 0.0 < budget.separable())
            .map(|_| SeparableDensities { whole: self.whole_table(kernel, &key), budget });
        DensitySplats {
            slabs,
            smooth: match product {
                Some(sections) => SmoothSections::Product(sections),
                None => SmoothSections::Table(self.cubic_table(kernel, key.clone())),
            },
            separable,
            table: self.section_table(kernel, key),
        }
    }

    fn cubic_table(&mut self, kernel: &dyn Kernel, key: TableKey) -> Arc<CubicSectionTable> {
        let table = |TableKey { kappa, settings }: &TableKey| {
            Arc::new(CubicSectionTable::new(&SectionDesc {
                kernel,
                width: settings.slab_width,
                kappa: *kappa,
                normalization: Normalization::None,
                base_width: settings.base_slab_width,
            }))
        };
        self.cubic.made_of(key, table).clone()
    }

    fn footprint_table(&mut self, kernel: &dyn Kernel, key: TableKey) -> Arc<FootprintTable> {
        let table = |TableKey { kappa, settings }: &TableKey| {
            Arc::new(FootprintTable::new(kernel, *kappa, settings.radial_samples))
        };
        self.footprint.made_of(key, table).clone()
    }
}

/// A cubic grid has κ = 1 in every view, up to rounding errors, which must not cost a new table.
fn rounded(kappa: f64) -> f64 {
    let dropped_bits = 22;
    let up = kappa.to_bits() + (1 << (dropped_bits - 1));
    f64::from_bits(up & !((1 << dropped_bits) - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{
        Camera, Grid, ImageDesc, KernelName, Projection, Scaling, TransferFunction,
    };

    fn volume() -> Arc<Volume> {
        let grid = Grid::with_spacing([4, 4, 4], [1.0; 3]).unwrap();
        Arc::new(Volume::new(grid, vec![1_u8; 64].into(), Scaling::IDENTITY).unwrap())
    }

    fn scene(settings: RenderSettings) -> Scene {
        let projection = Projection::Orthographic { view_height: 8.0 };
        let camera = Camera::new(DVec3::Z * 20.0, DVec3::ZERO, DVec3::Y, projection).unwrap();
        let transfer = TransferFunction::new(vec![(0.0, [1.0])], vec![(0.0, [1.0; 3])]).unwrap();
        Scene::new(transfer, camera)
            .shading(Shading::None)
            .image(ImageDesc { width: 8, height: 8, background: [0.0; 4] })
            .settings(settings)
    }

    fn table(planner: &mut Planner, scene: &Scene) -> Arc<SectionTable> {
        match planner.plan(&volume(), scene).unwrap().splats {
            Splats::Colors(ColorSplats::Sections(sections)) => sections.table,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn planner_keeps_tables_that_did_not_change() {
        let mut planner = Planner::default();
        let mut scene = scene(RenderSettings::default());
        let first = table(&mut planner, &scene);
        scene.camera = scene.camera.orbited(0.3);
        let turned = table(&mut planner, &scene);
        assert!(Arc::ptr_eq(&first, &turned), "the grid is cubic");
        scene.settings.slab_width = 2.0;
        assert!(!Arc::ptr_eq(&first, &table(&mut planner, &scene)));
    }

    /// A kernel of a cubic grid is four slabs thick from everywhere. A rounding error must not make it five:
    /// each slab would look back at one bucket more.
    #[test]
    fn planner_rounds_what_a_kernel_is_thick() {
        let mut planner = Planner::default();
        let volume = volume();
        for step in 0..300 {
            let mut scene = scene(RenderSettings::default());
            scene.camera = scene.camera.orbited(0.02 * f64::from(step));
            match planner.plan(&volume, &scene).unwrap().splats {
                Splats::Colors(ColorSplats::Sections(sections)) => {
                    assert_eq!(sections.slabs.n_before, 4, "{step}");
                }
                other => panic!("{other:?}"),
            }
        }
    }

    /// Slabs as wide as the kernel cut nothing off, however the grid is stretched, and how deep a layer is
    /// counts in steps of the grid.
    #[test]
    fn planner_merges_sections_of_slabs_as_wide_as_the_kernel() {
        for spacing in [[1.0; 3], [3.0; 3], [2.0, 2.0, 1.0], [1.0, 1.0, 1.5]] {
            let grid = Grid::with_spacing([4, 4, 4], spacing).unwrap();
            let layer_depth = spacing[2] / grid.unit();
            let volume = Volume::new(grid, vec![1_u8; 64].into(), Scaling::IDENTITY).unwrap();
            let volume = Arc::new(volume);
            let scene = scene(RenderSettings::default());
            let mut planner = Planner::default();
            let plan = planner.plan(&volume, &scene).unwrap();
            assert!((plan.half_depth / spacing[2] - 2.0).abs() < 1e-12, "{}", plan.half_depth);
            let Splats::Colors(ColorSplats::Sections(sections)) = plan.splats else {
                panic!("{:?}", plan.splats);
            };
            let merged = sections.merged.expect("faint voxels are whole");
            let kernel = kernel_named("gaussian").unwrap();
            let split_view = SplitView { layer_depth, steepest_ray: 0.0 };
            let levels = SplitLevels::new(&scene.settings, &*kernel, split_view);
            assert_eq!(merged.levels, levels, "{spacing:?}");
            let radius = kernel.radius() as f32;
            let [whole, half] = [-radius, 0.0].map(|front| merged.table.sample(0.5, front, radius));
            assert!((whole - 2.0 * half).abs() < 1e-3 * whole, "{spacing:?}: {whole} {half}");
        }
    }

    /// Only where slabs are tilted, and only where no setting of tables shows in the picture.
    #[test]
    fn planner_draws_tilted_sections_without_a_table() {
        let check = |spacing: [f64; 3], settings: RenderSettings, expected: bool| {
            let grid = Grid::with_spacing([4, 4, 4], spacing).unwrap();
            let volume = Volume::new(grid, vec![1_u8; 64].into(), Scaling::IDENTITY).unwrap();
            let mut scene = scene(settings);
            scene.camera = scene.camera.orbited(0.5);
            let (volume, mut planner) = (Arc::new(volume), Planner::default());
            match planner.plan(&volume, &scene).unwrap().splats {
                Splats::Colors(ColorSplats::Sections(sections)) => {
                    assert_eq!(
                        sections.tilted.is_some(),
                        expected,
                        "{spacing:?} {:?}",
                        scene.settings
                    );
                }
                other => panic!("{other:?}"),
            }
        };
        let (cubic, stretched) = ([1.0; 3], [1.0, 1.0, 2.0]);
        let settings = RenderSettings::default();
        check(stretched, settings.clone(), true);
        check(cubic, settings.clone(), false);
        check(stretched, settings.clone().lookup(Lookup::Nearest), false);
        check(stretched, settings.clone().normalization(Normalization::Product), false);
        check(stretched, settings.kernel(KernelName("crawfis-max".into())), false);
    }

    #[test]
    fn planner_rounds_kappa_by_its_size() {
        for kappa in [1.0, 1.0_f64.next_down(), 1.0_f64.next_up()] {
            assert_eq!(rounded(kappa), 1.0);
        }
        for kappa in [1e-10, 0.3, 7.7e6] {
            assert!((rounded(kappa) / kappa - 1.0).abs() < 1e-9, "{kappa}");
        }
    }

    #[test]
    fn planner_refuses_what_cannot_be_drawn() {
        let check = |settings, expected: &str| {
            let err = Planner::default().plan(&volume(), &scene(settings)).unwrap_err();
            assert!(err.to_string().contains(expected), "{err}");
        };
        let good = RenderSettings::default();
        let kernel = KernelName("box".into());
        check(good.clone().kernel(kernel), "no kernel \"box\"");
        let mut huge = scene(good.clone());
        (huge.image.width, huge.image.height) = (u32::MAX, u32::MAX);
        let err = Planner::default().plan(&volume(), &huge).unwrap_err();
        assert!(matches!(err, PlanError::Image(_)), "{err}");
        check(good.clone().slab_width(-1.0), "slab_width");
        check(good.slab_width(1e-9), "sheets");
    }
}
