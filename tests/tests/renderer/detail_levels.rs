//! Levels of detail (model §16): cells of voxels against the voxels, and the cells of all backends against
//! those of the reference.

use slabsplat::{Renderer, Sweep, measure_popping};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Camera, Compositing, Grid, Layer, Method, Normalization, Plane, Projection, Region,
    RenderSettings, Samples, Scaling, Scene, Shading, TransferFunction, Volume,
};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::random_scene::{SceneKind, layer_of_all_levels, random_scene};
use slabsplat_tests::reference::{render, render_within_tolerance};
use slabsplat_tests::render::{backends, open, render as by_backend};

/// What simpler footprints may add to 10⁻³: 0.15 of the tolerance.
const OF_FOOTPRINTS: f64 = 1e-3 + 0.15 * 0.05;

fn may_merge(kind: &SceneKind) -> bool {
    kind.method == Method::ImageAligned
        && kind.compositing == Compositing::Extinction
        && kind.normalization == Normalization::None
}

/// A random scene of more voxels, from so far away that a pixel covers some of them.
fn minified(rng: &mut fastrand::Rng, kind: &SceneKind) -> Scene {
    let mut scene = random_scene(rng, kind);
    (scene.image.width, scene.image.height) = (10, 9);
    scene.settings.slab_width = [0.77, 1.0, 2.0][rng.usize(..3)];
    scene.settings.tolerance = RenderSettings::default().tolerance;
    let affine = scene.layers[0].volume.grid().world_from_index();
    let dims = [0; 3].map(|_| rng.usize(16..=21));
    let grid = Grid::new(dims, affine).expect("its steps are those of another");
    let shading = if rng.bool() { Shading::None } else { scene.layers[0].shading };
    scene.layers[0] = faint(rng, grid).shading(shading);
    let (forward, up) = (scene.camera.axes().forward, scene.camera.axes().up);
    let pixel = grid.unit() * (2.08 + 4.0 * rng.f64());
    let (target, height) = (grid.center_in_world(), pixel * f64::from(scene.image.height));
    let eye = target - forward * 200.0 * grid.unit();
    let projection = match scene.camera.projection() {
        Projection::Orthographic { .. } => Projection::Orthographic { view_height: height },
        Projection::Perspective { .. } => {
            let half = 0.5 * height / eye.distance(target);
            Projection::Perspective { fov_y_radians: 2.0 * half.atan() }
        }
    };
    scene.camera = Camera::new(eye, target, up, projection).expect("up is not forward");
    scene
}

/// A ball of noise, or noise alone, about as opaque as it may be: black and white, or of less contrast.
fn faint(rng: &mut fastrand::Rng, grid: Grid) -> Layer {
    let (center, is_ball) = (grid.center_in_index(), rng.bool());
    let value = |idx: usize| {
        let at = grid.voxel_coords(idx).map(|at| at as f64);
        let from_center = center.distance(at.into());
        if is_ball && 6.5 < from_center { 0.0 } else { 1.0 + rng.f64() }
    };
    let samples = Samples::F64((0..grid.n_voxels()).map(value).collect());
    let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("a sample a voxel");
    let looks = [(0.01, 0.0), (0.02, 0.0), (0.036, 0.0), (0.039, 0.0), (0.07, 0.3), (0.1, 0.42)];
    let (opacity, darkest) = looks[rng.usize(..looks.len())];
    let transfer = TransferFunction::new(
        vec![(0.5, [0.0]), (1.0, [opacity])],
        vec![(1.5, [darkest; 3]), (1.5, [1.0; 3])],
    );
    Layer::new(volume, transfer.expect("the points rise"))
}

/// Cuts a corner off, or nearly all, by a plane that is lit.
fn cut_and_light(rng: &mut fastrand::Rng, scene: &mut Scene) {
    let grid = scene.layers[0].volume.grid();
    let (middle, half) = (grid.center_in_world(), 0.5 * grid.unit() * grid.dims()[0] as f64);
    let normal = DVec3::new(rng.f64() - 0.5, rng.f64() - 0.5, rng.f64() - 0.5).normalize();
    let distance = normal.dot(middle) + (1.6 * rng.f64() - 0.8) * half;
    let cut = Plane::new(normal, distance).expect("it has a direction");
    scene.layers[0].region = Region::new(vec![cut]).lit();
}

/// At most the tolerance from voxels; and all backends draw the cells of the definition.
#[test]
fn detail_levels_on_random_scenes() {
    let (mut worst, mut worst_of_backends, mut n_by_cells) = (0.0_f64, 0.0_f64, 0);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in SceneKind::share(seed).filter(may_merge) {
            let mut scene = minified(&mut rng, &kind);
            let is_cut = rng.u32(..4) == 0;
            if is_cut {
                cut_and_light(&mut rng, &mut scene);
            }
            let [exact, cells] = [render(&scene), render_within_tolerance(&scene)];
            let off = exact.compare_reference(&cells).max;
            assert!(off < scene.settings.tolerance, "{off} from voxels: {kind:?}");
            worst = worst.max(off);
            for name in backends() {
                let image = by_backend(name, &scene);
                let of_backend = cells.compare(&image).max;
                // More bricks may count as near a lit face than are, and these are drawn by voxels.
                if is_cut && OF_FOOTPRINTS <= of_backend && exact.compare(&image).max < off {
                    continue;
                }
                assert!(of_backend < OF_FOOTPRINTS, "{name} is off by {of_backend}: {kind:?}");
                worst_of_backends = worst_of_backends.max(of_backend);
            }
            n_by_cells += usize::from(1e-3 < off);
        }
    });
    println!("at most {worst:.4} from voxels, {worst_of_backends:.1e} from the reference");
    assert!(3 < n_by_cells, "hardly anything was drawn by cells: {n_by_cells}");
}

/// What a workgroup's memory holds before it is written is what frames of other scenes left there: splats
/// that are staged and not seen must not be told by it. On a driver that plays a device it depends on which
/// thread draws which tile, so that a mistake shows once in some tens of frames; these are many small ones.
#[test]
fn detail_levels_in_turn_with_others_do_not_change_a_bit() {
    for_each_seed(1, |mut rng| {
        let is_tabled = |kind: &SceneKind| may_merge(kind) && kind.kernel == "crawfis-max";
        let kinds: Vec<SceneKind> = SceneKind::all().into_iter().filter(is_tabled).collect();
        let scenes = [0; 4].map(|_| {
            let kind = rng.usize(..kinds.len());
            let mut scene = minified(&mut rng, &kinds[kind]);
            cut_and_light(&mut rng, &mut scene);
            scene
        });
        for &name in backends() {
            let mut renderer = Renderer::new(open(name));
            let mut turn = || {
                let frames = scenes.iter().map(|scene| renderer.render(scene));
                frames.map(|frame| frame.expect("the scene is valid").image).collect::<Vec<_>>()
            };
            let first = turn();
            for step in 0..20 {
                assert!(turn() == first, "{name}, turn {step}");
            }
        }
    });
}

/// A ball of two colours with a hard border between them, smooth in itself and as opaque as scans are, so
/// that some bricks are drawn by cells and others by voxels.
fn opaque_ball(rng: &mut fastrand::Rng, grid: Grid) -> Layer {
    let center = grid.center_in_index();
    let value = |idx: usize| {
        let at = DVec3::from_array(grid.voxel_coords(idx).map(|at| at as f64));
        let from_center = center.distance(at);
        let side = if at.x + 0.3 * at.y < 1.3 * center.x { 40.0 } else { 80.0 };
        side + 100.0 * ((15.0 - from_center) / 4.0).clamp(0.0, 1.0)
    };
    let samples = Samples::F32((0..grid.n_voxels()).map(|idx| value(idx) as f32).collect());
    let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("a sample a voxel");
    let opacity = [0.05, 0.2, 0.38, 0.9][rng.usize(..4)];
    let transfer = TransferFunction::new(
        vec![(80.0, [0.0]), (140.0, [opacity])],
        vec![(140.0, [1.0, 0.4, 0.2]), (180.0, [0.2, 0.5, 1.0])],
    );
    Layer::new(volume, transfer.expect("the points rise"))
}

/// What is opaque is drawn by cells where these are alike, and by voxels elsewhere, within the tolerance. So
/// it is where it is cut, and where the cut is lit, by light in a layer thinner than cells: cells there were
/// off by 0.098.
#[test]
fn detail_levels_of_opaque_layers() {
    let mut worst = 0.0_f64;
    for_each_numbered_seed(2, |seed, mut rng| {
        let grid = Grid::with_spacing([37, 33, 35], [1.0, 1.0, 1.0 + 0.4 * rng.f64()]);
        let layer = opaque_ball(&mut rng, grid.expect("its steps are positive"));
        let mut scene = minified(&mut rng, &SceneKind::share(seed).find(may_merge).expect("some"));
        let (grid, forward) = (*layer.volume.grid(), scene.camera.axes().forward);
        let up = scene.camera.axes().up;
        scene.layers[0] = layer;
        let target = grid.center_in_world();
        // With fewer voxels a pixel bricks at the ends of the grid are not drawn by cells.
        let voxels_a_pixel = [2.0, 2.2][seed as usize % 2];
        let height = voxels_a_pixel * f64::from(scene.image.height) * grid.unit();
        let projection = Projection::Orthographic { view_height: height };
        let camera = Camera::new(target - 200.0 * forward, target, up, projection);
        scene.camera = camera.expect("up is not forward");
        let cut = Plane::new(DVec3::new(0.3, -0.2, 1.0), 18.0).expect("it has a direction");
        let cut = Region::new(vec![cut]);
        for region in [scene.layers[0].region.clone(), cut.clone(), cut.lit()] {
            scene.layers[0].region = region;
            let (exact, by_cpu) = (render(&scene), by_backend("cpu", &scene));
            for name in backends() {
                let image = by_backend(name, &scene);
                let off = exact.compare(&image).max;
                assert!(off < scene.settings.tolerance, "{name} is {off} from voxels");
                worst = worst.max(off);
                let from_cpu = f64::from(image.max_difference(&by_cpu));
                assert!(from_cpu < OF_FOOTPRINTS, "{name} is {from_cpu} from the CPU");
            }
        }
    });
    println!("at most {worst:.4} from voxels");
    assert!(1e-3 < worst, "nothing was drawn by cells");
}

/// Bricks change their level one after the other as the camera zooms: where they did so in one frame, its
/// spike was 4.6.
#[test]
fn detail_levels_do_not_pop_in_a_zoom() {
    let mut rng = fastrand::Rng::with_seed(1);
    let grid = Grid::with_spacing([80; 3], [1.0; 3]).expect("its steps are positive");
    let layer = noise(&mut rng, grid, 0.005);
    let mut scene = Scene::new(layer, camera_on(&grid, DVec3::new(1.0, 2.0, -9.0), 40.0 * 1.92));
    (scene.image.width, scene.image.height) = (40, 40);
    let mut renderer = Renderer::open("cpu", |_| ()).expect("it is part of every build");
    let mut measure = |tolerance: f64| {
        scene.settings.tolerance = tolerance;
        let zoom = Sweep::zoom(1.04, 0.92).step(1.0 / 1.002);
        let report = measure_popping(&mut renderer, &scene, Method::ImageAligned, zoom, || ());
        report.expect("it is drawn").spike.expect("the picture changes")
    };
    let [exact, by_cells] = [0.0, 0.05].map(&mut measure);
    println!("spikes of {by_cells:.3}, without cells {exact:.3}");
    assert!(1e-3 < (by_cells - exact).abs(), "nothing was drawn by cells");
    assert!(by_cells < 1.5, "it pops: {by_cells}");
}

/// Black and white.
fn noise(rng: &mut fastrand::Rng, grid: Grid, opacity: f64) -> Layer {
    let samples = (0..grid.n_voxels()).map(|_| rng.u8(..2)).collect::<Vec<_>>();
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).expect("a sample a voxel");
    let colors = vec![(0.0, [0.0; 3]), (1.0, [1.0; 3])];
    let transfer = TransferFunction::new(vec![(0.0, [opacity])], colors);
    Layer::new(volume, transfer.expect("the points rise"))
}

fn camera_on(grid: &Grid, from: DVec3, view_height: f64) -> Camera {
    let target = grid.center_in_world();
    let projection = Projection::Orthographic { view_height };
    let camera = Camera::new(target + 99.0 * from, target, DVec3::Y, projection);
    camera.expect("up is not forward")
}

/// A solid box that is seen edge-on: all of a face is one line of pixels, which tells how wide footprints of
/// cells are together. Where they ended with the middles of cells, these were off by 0.10, 0.19 and 0.22.
#[test]
fn detail_levels_end_where_the_grid_ends() {
    let mut worst = [0.0_f32; 3];
    for (level, side, n) in [(0, 2.0, 32), (1, 4.0, 64), (2, 8.0, 72)] {
        for (opacity, voxels_a_pixel) in [(0.03, 1.08), (0.1, 1.12), (0.05, 1.3), (0.03, 1.45)] {
            let grid = Grid::with_spacing([n; 3], [1.0; 3]).expect("its steps are positive");
            let camera = camera_on(&grid, -DVec3::X, 25.0 * side * voxels_a_pixel);
            let mut scene = Scene::new(solid(grid, opacity), camera);
            (scene.image.width, scene.image.height) = (25, 25);
            let [exact, cells] = [0.0, RenderSettings::default().tolerance].map(|tolerance| {
                scene.settings.tolerance = tolerance;
                by_backend("cpu", &scene)
            });
            worst[level] = worst[level].max(exact.max_difference(&cells));
        }
    }
    println!("{worst:.3?}");
    assert!(worst.iter().all(|off| (0.01..0.075).contains(off)), "{worst:?}");
}

fn solid(grid: Grid, opacity: f64) -> Layer {
    let samples = Samples::U8(vec![1; grid.n_voxels()]);
    let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("a sample a voxel");
    let transfer = TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, [1.0; 3])]);
    Layer::new(volume, transfer.expect("points")).shading(Shading::None)
}

/// What a picture shows of a volume does not depend on what else it shows: voxels that are drawn instead of
/// cells beyond its border reach into it where those cells would not. They did not, and it was off by 4·10⁻⁵.
#[test]
fn detail_levels_are_the_same_in_a_wider_picture() {
    /// Pixels along a side, and as many more as a tile has on each.
    const SIDES: [u32; 2] = [2, 32 + 2 + 32];
    let mut worst = 0.0_f32;
    for_each_seed(40, |mut rng| {
        let layer = layer_of_all_levels(&mut rng);
        let grid = *layer.volume.grid();
        let from = DVec3::from_array([0; 3].map(|_| rng.f64() - 0.5));
        let pixel = 10.7 + 4.0 * rng.f64();
        let tolerance = [0.05, 0.2][rng.usize(..2)];
        let [narrow, wide] = SIDES.map(|side| {
            let camera = camera_on(&grid, from, f64::from(side) * pixel);
            let mut scene = Scene::new(layer.clone(), camera);
            (scene.image.width, scene.image.height) = (side, side);
            // Its footprints are the same wherever they are, those of the other are made of a lattice.
            scene.settings.kernel = "crawfis-max".into();
            (scene.settings.tolerance, scene.settings.opacity_cutoff) = (tolerance, 1.0);
            by_backend("cpu", &scene)
        });
        let border = (wide.width() - narrow.width()) / 2;
        let [of_narrow, of_wide] = [&narrow, &wide].map(|image| image.width() as usize);
        for (idx, pixel) in narrow.pixels().iter().enumerate() {
            let [x, y] = [idx % of_narrow, idx / of_narrow].map(|at| at + border as usize);
            let differences = pixel.iter().zip(wide.pixels()[y * of_wide + x]);
            worst = differences.fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
        }
    });
    println!("off by {worst} at most");
    assert!(worst < 1e-6, "off by {worst}");
}
