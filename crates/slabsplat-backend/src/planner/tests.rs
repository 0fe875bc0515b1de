//! What planners decide, and what they keep.

use super::*;
use crate::{ColorSplats, Splats};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Camera, Grid, ImageDesc, Isosurface, KernelName, Lookup, Normalization, Plane, Projection,
    Region, RenderSettings, Scaling, Shading, TransferFunction, Volume,
};
use slabsplat_kernel::{KernelTails, SectionTable, SplitLevels, SplitView};
use std::sync::Arc;

fn volume() -> Arc<Volume> {
    let grid = Grid::with_spacing([4, 4, 4], [1.0; 3]).unwrap();
    Arc::new(Volume::new(grid, vec![1_u8; 64].into(), Scaling::IDENTITY).unwrap())
}

fn scene(settings: RenderSettings) -> Scene {
    scene_of(volume(), settings)
}

fn scene_of(volume: impl Into<Arc<Volume>>, settings: RenderSettings) -> Scene {
    let projection = Projection::Orthographic { view_height: 8.0 };
    let camera = Camera::new(DVec3::Z * 20.0, DVec3::ZERO, DVec3::Y, projection).unwrap();
    let transfer = TransferFunction::new(vec![(0.0, [1.0])], vec![(0.0, [1.0; 3])]).unwrap();
    Scene::new(Layer::new(volume, transfer).shading(Shading::None), camera)
        .image(ImageDesc::new(8, 8))
        .settings(settings)
}

fn table(planner: &mut Planner, scene: &Scene) -> Arc<SectionTable> {
    match &planner.plan(scene).unwrap().layers[0].splats {
        Splats::Colors(ColorSplats::Sections(sections)) => sections.table.clone(),
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
    for step in 0..300 {
        let mut scene = scene(RenderSettings::default());
        scene.camera = scene.camera.orbited(0.02 * f64::from(step));
        match &planner.plan(&scene).unwrap().layers[0].splats {
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
        let scene = scene_of(volume, RenderSettings::default());
        let plan = &Planner::default().plan(&scene).unwrap().layers[0];
        assert!((plan.half_depth / spacing[2] - 2.0).abs() < 1e-12, "{}", plan.half_depth);
        let Splats::Colors(ColorSplats::Sections(sections)) = &plan.splats else {
            panic!("{:?}", plan.splats);
        };
        let merged = sections.merged.as_ref().expect("faint voxels are whole");
        let kernel = Kernels::default().named("gaussian").unwrap();
        let split_view = SplitView { layer_depth, steepest_ray: 0.0, is_cut: false, level: 0 };
        let levels = SplitLevels::new(&scene.settings, &KernelTails::of(&*kernel), split_view);
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
        let mut scene = scene_of(volume, settings);
        scene.camera = scene.camera.orbited(0.5);
        match &Planner::default().plan(&scene).unwrap().layers[0].splats {
            Splats::Colors(ColorSplats::Sections(sections)) => {
                assert_eq!(sections.tilted.is_some(), expected, "{spacing:?} {:?}", scene.settings);
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
fn planner_refuses_what_cannot_be_drawn() {
    let check = |settings, expected: &str| {
        let err = Planner::default().plan(&scene(settings)).unwrap_err();
        assert!(err.to_string().contains(expected), "{err}");
    };
    let good = RenderSettings::default();
    let kernel = KernelName("box".into());
    check(good.clone().kernel(kernel), "no kernel \"box\"");
    let mut huge = scene(good.clone());
    (huge.image.width, huge.image.height) = (u32::MAX, u32::MAX);
    let err = Planner::default().plan(&huge).unwrap_err();
    assert!(matches!(err, PlanError::Image(_)), "{err}");
    check(good.clone().slab_width(-1.0), "slab_width");
    check(good.clone().slab_width(1e-5), "slabs deep");
    check(good.clone().mode(Mode::Isosurfaces), "needs a value: add --isosurface");
    let both = good.mode(Mode::Isosurfaces).method(Method::EverySample);
    check(both, "which every-sample has none of");
}

/// Work per voxel is bounded, whatever the camera sees, and the error says what helps.
#[test]
fn planner_bounds_sections_of_a_kernel() {
    let refused = |settings: &RenderSettings, eye: DVec3| {
        let grid = Grid::with_spacing([2, 2, 2], [1.0, 1.0, 12800.0]).unwrap();
        let volume = Volume::new(grid, vec![1_u8; 8].into(), Scaling::IDENTITY).unwrap();
        let mut scene = scene_of(volume, settings.clone());
        let up = DVec3::new(0.1, 0.2, 0.3);
        scene.camera = Camera::new(eye, DVec3::ZERO, up, scene.camera.projection()).unwrap();
        Planner::default().plan(&scene).err()
    };
    let settings = RenderSettings::default();
    for eye in [DVec3::X, DVec3::Z, DVec3::ONE] {
        let Some(PlanError::TooManySections { n_slabs, wide_enough, .. }) = refused(&settings, eye)
        else {
            panic!("drawn from {eye}");
        };
        assert_eq!((n_slabs, wide_enough), (51200.0, 6.25), "{eye}");
        assert_eq!(refused(&settings.clone().slab_width(wide_enough), eye), None, "{eye}");
        // Samples and sheets of voxels are whole.
        for method in [Method::EverySample, Method::AxisAligned] {
            assert_eq!(refused(&settings.clone().method(method), eye), None, "{method} {eye}");
        }
    }
    // A sheet of densities is half a slab thick.
    let densities = settings.method(Method::PostClassified).slab_width(6.25);
    assert!(refused(&densities, DVec3::X).is_some());
    assert_eq!(refused(&densities.slab_width(12.5), DVec3::X), None);
}

/// A few thousand needles that took minutes. What has no slabs draws them, and so do wider slabs.
#[test]
fn planner_bounds_work_of_a_frame() {
    let drawn = |settings: RenderSettings| {
        let grid = Grid::with_spacing([16, 16, 30], [1.0, 1.0, 1600.0]).unwrap();
        let volume = Volume::new(grid, vec![1_u8; 7680].into(), Scaling::IDENTITY).unwrap();
        Planner::default().plan(&scene_of(volume, settings)).map(|_| ())
    };
    let refused = |settings: RenderSettings| drawn(settings).unwrap_err().to_string();
    let settings = RenderSettings::default();
    assert_eq!(
        refused(settings.clone()),
        "a frame of 4.9e7 sections of kernels takes too long: the volume with spacing 1 x 1 x 1600 is cut \
         into too many slabs, as its longest voxel step is 1600 times its shortest; correct the spacing, set \
         slab_width to 1.47 or more, or draw every-sample, which has no slabs"
    );
    assert_eq!(drawn(settings.clone().slab_width(1.47)), Ok(()));
    for method in [Method::EverySample, Method::AxisAligned] {
        assert_eq!(drawn(settings.clone().method(method)), Ok(()), "{method}");
    }
    for mode in [Mode::Maximum, Mode::Minimum, Mode::Average] {
        let refused = refused(settings.clone().mode(mode).slab_width(2.0));
        assert!(refused.contains("takes too long"), "{mode}: {refused}");
    }
}

/// What every-sample does not draw, or would draw as another picture, is not sent there.
#[test]
fn planner_bounds_work_and_names_only_what_helps() {
    let needles = || {
        let grid = Grid::with_spacing([16, 16, 30], [1.0, 1.0, 1600.0]).unwrap();
        Volume::new(grid, vec![1_u8; 7680].into(), Scaling::IDENTITY).unwrap()
    };
    let refused = |scene: &Scene| {
        let error = Planner::default().plan(scene).unwrap_err().to_string();
        assert!(error.contains("takes too long"), "{error}");
        let (_, hint) = error.split_once("; ").unwrap();
        hint.to_owned()
    };
    let settings = RenderSettings::default();
    let alone = scene_of(needles(), settings.clone());
    assert!(refused(&alone).ends_with("or draw every-sample, which has no slabs"));
    let mut two = alone.clone();
    two.layers.push(two.layers[0].clone());
    let mut cut = alone.clone();
    cut.layers[0].region = Region::new(vec![Plane::new(DVec3::X, 0.0).unwrap()]);
    // Sheets of densities are half a slab thick, and a kernel has its own bound.
    let wide = settings.slab_width(2.0);
    let densities = wide.clone().method(Method::PostClassified);
    let maximum = wide.mode(Mode::Maximum);
    let [densities, maximum] = [densities, maximum].map(|it| scene_of(needles(), it));
    for other in [two, cut, densities, maximum] {
        let hint = refused(&other);
        assert!(hint.starts_with("correct the spacing, or set slab_width to "), "{hint}");
        assert!(!hint.contains("every-sample"), "{hint}");
        let mut drawn = other.clone();
        drawn.settings.method = Method::EverySample;
        let draws = Planner::default().plan(&drawn).is_ok();
        assert_eq!(draws, other.settings.method == Method::PostClassified, "{hint}");
    }
}

/// What decides about a surface is its own value; of two that are one, neither would be in front.
#[test]
fn planner_takes_isosurfaces_in_any_order() {
    let mut scene = scene(RenderSettings::default().mode(Mode::Isosurfaces));
    let surfaces =
        [5.0, -1.0, 3.0].map(|value| Isosurface::new(value, 0.5, None).expect("it is finite"));
    scene.layers[0].isosurfaces = surfaces.to_vec();
    let plan = Planner::default().plan(&scene).unwrap();
    let ranges: Vec<_> = plan.layers[0].relevant.iter().map(|range| (range.lo, range.hi)).collect();
    assert_eq!(ranges, [(-1.0, -1.0), (3.0, 3.0), (5.0, 5.0)]);
    scene.layers[0].isosurfaces.push(surfaces[1]);
    let error = Planner::default().plan(&scene).unwrap_err().to_string();
    assert_eq!(error, "there are two isosurfaces of the value -1: leave one out");
}

/// From afar there are cells, unless nobody draws them or the picture is exact.
#[test]
fn planner_plans_cells_for_those_who_draw_them() {
    let grid = Grid::with_spacing([64; 3], [1.0; 3]).unwrap();
    let volume = Volume::new(grid, vec![1_u8; 1 << 18].into(), Scaling::IDENTITY).unwrap();
    let mut scene = scene_of(volume, RenderSettings::default());
    let projection = Projection::Orthographic { view_height: 40.0 };
    scene.camera = Camera::new(DVec3::Z * 99.0, DVec3::ZERO, DVec3::Y, projection).unwrap();
    let levels = |planner: &mut Planner, scene: &Scene| {
        let plan = planner.plan(scene).unwrap();
        let levels: Vec<_> = plan.layers[0].cells().map(|cells| cells.plan.level).collect();
        assert_eq!(plan.layers[0].levels().count(), levels.len() + 1);
        levels
    };
    let mut planner = Planner::default();
    assert_eq!(levels(&mut planner, &scene), [1, 2], "a pixel covers five voxels");
    planner.plan_cells(false);
    assert_eq!(levels(&mut planner, &scene), []);
    planner.plan_cells(true);
    scene.settings.tolerance = 0.0;
    assert_eq!(levels(&mut planner, &scene), []);
}
