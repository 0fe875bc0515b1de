//! Makes frame plans, and keeps the tables that the next frame can use again.

use crate::{FewerSections, FramePlan, Splats};
use slabsplat_core::{
    ImageError, Method, Normalization, RenderSettings, Scene, SettingsError, Shading, ShadingError,
    SlabGrid, SliceOrder, TooManySlabs, View, ViewError, Volume,
};
use slabsplat_kernel::{
    CubicSectionTable, FootprintShape, FootprintTable, Kernel, LevelView, SectionDesc,
    SectionLevels, SectionTable, TableDesc, UnknownKernel, kernel_named,
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
/// from one frame to the next, so the last ones are kept.
#[derive(Debug, Default)]
pub struct Planner {
    sections: Option<(TableKey, Arc<SectionTable>)>,
    folded: Option<(TableKey, Arc<SectionTable>)>,
    footprint: Option<(TableKey, Arc<FootprintTable>)>,
    cubic: Option<(TableKey, Arc<CubicSectionTable>)>,
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
        let key = TableKey { kappa: rounded(shape.kappa), settings };
        let splats = match key.settings.method {
            Method::ImageAligned => Splats::Sections {
                slabs: slabs_of(volume, &view, &shape, kernel.radius(), &key.settings)?,
                fewer: self.fewer_sections(&*kernel, &key, &view, &shape, volume.grid().unit()),
                table: self.section_table(&*kernel, key),
            },
            Method::AxisAligned => Splats::Slices {
                order: SliceOrder::new(volume.grid(), view.axes().forward),
                table: self.footprint_table(&*kernel, key),
            },
            Method::EverySample => Splats::Voxels { table: self.footprint_table(&*kernel, key) },
            Method::PostClassified => Splats::Densities {
                slabs: slabs_of(volume, &view, &shape, kernel.radius(), &key.settings)?,
                table: self.cubic_table(&*kernel, key),
            },
        };
        Ok(FramePlan {
            volume,
            relevant: scene.transfer.iso_ranges(),
            transfer: &scene.transfer,
            shading: scene.shading,
            view,
            image: scene.image,
            radius: kernel.radius(),
            shape,
            compositing: scene.settings.compositing,
            opacity_cutoff: scene.settings.opacity_cutoff as f32,
            splats,
        })
    }

    fn fewer_sections(
        &mut self,
        kernel: &dyn Kernel,
        key: &TableKey,
        view: &View,
        shape: &FootprintShape,
        unit: f64,
    ) -> Option<FewerSections> {
        let tolerance = key.settings.tolerance;
        let layer_depth = shape.half_depth / unit;
        let view = LevelView { layer_depth, steepest_ray: view.steepest_ray() };
        let levels = SectionLevels::new(&key.settings, kernel, view);
        if levels.are_all_last() {
            return None;
        }
        let table = keep(&mut self.folded, key.clone(), |key| {
            key.sections_of(kernel, 2.0 * kernel.radius() / key.kappa)
        });
        Some(FewerSections { levels, table, tolerance })
    }

    fn section_table(&mut self, kernel: &dyn Kernel, key: TableKey) -> Arc<SectionTable> {
        keep(&mut self.sections, key, |key| key.sections_of(kernel, key.settings.slab_width))
    }

    /// Sections that were normalised would no longer measure lengths, so these never are.
    fn cubic_table(&mut self, kernel: &dyn Kernel, key: TableKey) -> Arc<CubicSectionTable> {
        keep(&mut self.cubic, key, |TableKey { kappa, settings }| {
            CubicSectionTable::new(&SectionDesc {
                kernel,
                width: settings.slab_width,
                kappa: *kappa,
                normalization: Normalization::None,
                base_width: settings.base_slab_width,
            })
        })
    }

    fn footprint_table(&mut self, kernel: &dyn Kernel, key: TableKey) -> Arc<FootprintTable> {
        keep(&mut self.footprint, key, |TableKey { kappa, settings }| {
            FootprintTable::new(kernel, *kappa, settings.radial_samples)
        })
    }
}

/// A cubic grid has κ = 1 in every view, up to rounding errors, which must not cost a new table.
fn rounded(kappa: f64) -> f64 {
    let dropped_bits = 22;
    let up = kappa.to_bits() + (1 << (dropped_bits - 1));
    f64::from_bits(up & !((1 << dropped_bits) - 1))
}

/// What `kept` holds, if it was made from `key`; otherwise makes it anew.
fn keep<T>(
    kept: &mut Option<(TableKey, Arc<T>)>,
    key: TableKey,
    make: impl FnOnce(&TableKey) -> T,
) -> Arc<T> {
    match kept {
        Some((made_from, table)) if *made_from == key => table.clone(),
        _ => {
            let table = Arc::new(make(&key));
            *kept = Some((key, table.clone()));
            table
        }
    }
}

fn slabs_of(
    volume: &Volume,
    view: &View,
    shape: &FootprintShape,
    radius: f64,
    settings: &RenderSettings,
) -> Result<SlabGrid, TooManySlabs> {
    let grid = volume.grid();
    let [near, far] = view.from_index(grid).depth_range(grid);
    let reach = radius * shape.half_depth;
    SlabGrid::covering([near - reach, far + reach], settings.slab_width * grid.unit())
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
        Scene {
            transfer: TransferFunction::new(vec![(0.0, [1.0])], vec![(0.0, [1.0; 3])]).unwrap(),
            shading: Shading::None,
            camera,
            image: ImageDesc { width: 8, height: 8, background: [0.0; 4] },
            settings,
        }
    }

    fn table(planner: &mut Planner, scene: &Scene) -> Arc<SectionTable> {
        match planner.plan(&volume(), scene).unwrap().splats {
            Splats::Sections { table, .. } => table,
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
        check(RenderSettings { kernel, ..good.clone() }, "no kernel \"box\"");
        let mut huge = scene(good.clone());
        (huge.image.width, huge.image.height) = (u32::MAX, u32::MAX);
        let err = Planner::default().plan(&volume(), &huge).unwrap_err();
        assert!(matches!(err, PlanError::Image(_)), "{err}");
        check(RenderSettings { slab_width: -1.0, ..good.clone() }, "slab_width");
        check(RenderSettings { slab_width: 1e-9, ..good }, "sheets");
    }
}
