//! Parts of a scene (model §17): pictures of boxes, each drawn of its own voxels and those around it, laid
//! over each other as the eye has them, are the picture of the undivided scene, on scenes at random.

#![expect(clippy::unwrap_used, reason = "functions of tests are tests, too")]

use fastrand::Rng;
use slabsplat::backend::{Backend, FramePlan, Planner, SceneInParts};
use slabsplat::{
    Camera, Compositing, FrameHandle, Grid, Image, ImageDesc, Layer, Method, PartTree, Projection,
    RenderSettings, Scene, TransferFunction, Volume,
};
use slabsplat_core::glam::{DAffine3, DVec3};
use slabsplat_core::{over, with_samples};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::random_scene::{
    SceneKind, add_gradient_opacity, layer_of_all_levels, random_layers,
};
use slabsplat_tests::render::{backends_in_turn, open};
use std::ops::Range;

/// What a picture may differ by of which each part is rounded on its own.
const ROUNDED_TWICE: f32 = 1e-5;

/// By every kernel, compositing, normalisation, projection and grid, with regions, lit ones among them, and
/// up to three layers.
#[test]
fn parts_are_the_whole() {
    check_parts(|rng, scene| {
        if rng.bool() {
            add_gradient_opacity(rng, scene);
        }
        scene.settings.opacity_cutoff = 1.0;
    });
}

/// Merged sections, separable footprints and voxels that are drawn in other slabs are the same in a part.
#[test]
fn parts_with_a_tolerance_are_the_whole() {
    check_parts(|rng, scene| {
        scene.settings.tolerance = [0.01, 0.05, 0.2][rng.usize(..3)];
        scene.settings.opacity_cutoff = 1.0;
        let [width, height] = [0; 2].map(|_| rng.u32(20..=70));
        (scene.image.width, scene.image.height) = (width, height);
    });
}

/// Cells of a part are those of the whole: where some voxels are in a pixel, brick by brick, of one layer or
/// two, by all backends in turn.
#[test]
fn parts_by_cells_are_the_whole() {
    let (mut worst, mut n_by_cells) = (0.0_f32, 0);
    for_each_numbered_seed(4, |seed, mut rng| {
        // The CPU for every other seed.
        let mut backends = backends_in_turn(Method::ImageAligned, seed as usize / 2);
        let name = if seed % 2 == 0 { backends.next() } else { backends.last() };
        let name = name.unwrap();
        let mut backend = open(name);
        let scene = minified(&mut rng, name != "cpu");
        let tree = random_tree(&mut rng, &scene);
        let [whole, laid_over, one_by_one] = pictures(&mut *backend, &scene, &tree);
        let mut planner = Planner::default();
        n_by_cells += planner.plan(&scene).unwrap().layers[0].cells().count();
        planner.plan_cells(false);
        let by_voxels = drawn(&mut *backend, &planner.plan(&scene).unwrap());
        let off = whole.max_difference(&laid_over).max(whole.max_difference(&one_by_one));
        println!("{name}: {off}; cells {}", whole.max_difference(&by_voxels));
        worst = worst.max(off);
        assert!(off < ROUNDED_TWICE, "{name}: {off}");
    });
    println!("off by {worst} at most");
    assert!(0 < n_by_cells, "there were cells");
}

/// The only part is the whole, and is drawn in thinner ranges of depth. Voxels that are drawn instead of
/// cells begin before them, mostly in one range, sometimes in the one before: where they were missed, it was
/// off by 0.004.
#[test]
fn parts_by_all_levels_are_the_whole() {
    let mut worst = 0.0_f32;
    for_each_seed(16, |mut rng| {
        let mut scene = minified(&mut rng, false);
        scene.layers = vec![layer_of_all_levels(&mut rng)];
        (scene.image.width, scene.image.height) = (rng.u32(6..16), rng.u32(6..16));
        let grid = *scene.layers[0].volume.grid();
        let tree = PartTree::new(&grid, Grid::center_of_all([&grid]), |_| None);
        let [whole, part, _] = pictures(&mut *open("cpu"), &scene, &tree);
        worst = worst.max(whole.max_difference(&part));
    });
    println!("off by {worst} at most");
    assert!(worst < ROUNDED_TWICE, "off by {worst}");
}

/// Blobs of noise of which a pixel covers two to ten voxels.
fn minified(rng: &mut Rng, is_small: bool) -> Scene {
    let side = if is_small { 40..70 } else { 64..150 };
    let layers = (0..rng.usize(1..3)).map(|_| {
        let dims = [0; 3].map(|_| rng.usize(side.clone()));
        let steps = [0; 3].map(|_| 0.8 + 0.5 * rng.f64());
        let grid = Grid::centered(dims, steps).unwrap();
        let middle = dims.map(|n| rng.f64() * n as f64);
        let radius = 0.5 * dims[0] as f64;
        let volume = Volume::from_fn(grid, |at| {
            let from = [0, 1, 2].map(|axis| at[axis] as f64 - middle[axis]);
            let distance = DVec3::from_array(from).length();
            if distance < radius { 100 + rng.u8(..20) } else { 0 }
        });
        let opacity = [0.02, 0.1, 0.4][rng.usize(..3)];
        let opacity = vec![(90.0, [0.0]), (100.0, [opacity]), (120.0, [1.2 * opacity])];
        let color = vec![(100.0, [0.9, 0.4, 0.2]), (120.0, [0.8, 0.5, 0.3])];
        Layer::new(volume, TransferFunction::new(opacity, color).unwrap())
    });
    let mut layers = layers.collect::<Vec<_>>().into_iter();
    let eye = DVec3::from_array([0; 3].map(|_| rng.f64() - 0.5)).normalize() * 300.0;
    let projection = if rng.bool() {
        Projection::Perspective { fov_y_radians: 40.0_f64.to_radians() }
    } else {
        Projection::Orthographic { view_height: 180.0 }
    };
    let camera = Camera::new(eye, DVec3::ZERO, DVec3::new(0.1, 0.2, 1.0), projection).unwrap();
    let mut scene = Scene::new(layers.next().unwrap(), camera);
    scene.layers.extend(layers);
    (scene.image.width, scene.image.height) = (rng.u32(18..80), rng.u32(18..80));
    scene.settings.tolerance = [0.05, 0.2][rng.usize(..2)];
    scene.settings.opacity_cutoff = 1.0;
    scene
}

/// By one GPU backend or another, against its own picture of the whole.
#[test]
fn parts_on_gpus_are_the_whole() {
    let gpus = |number| backends_in_turn(Method::ImageAligned, number).filter(|it| *it != "cpu");
    let change = |rng: &mut Rng, scene: &mut Scene| {
        if rng.bool() {
            add_gradient_opacity(rng, scene);
        }
        scene.settings.opacity_cutoff = 1.0;
    };
    check_parts_by(|number| gpus(number).next(), change);
}

fn check_parts(change: impl FnMut(&mut Rng, &mut Scene)) {
    check_parts_by(|_| Some("cpu"), change);
}

/// On the backend that is named for a seed, if any is.
fn check_parts_by(
    backend_of: impl Fn(usize) -> Option<&'static str>,
    mut change: impl FnMut(&mut Rng, &mut Scene),
) {
    let mut worst = 0.0_f32;
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let Some(name) = backend_of(seed as usize) else { return };
        let mut backend = open(name);
        let kinds = SceneKind::share(seed).filter(|kind| kind.method == Method::ImageAligned);
        // Drivers that only play a device take long.
        let every = if name == "cpu" { 3 } else { 8 };
        for kind in kinds.step_by(every) {
            let mut scene = random_layers(&mut rng, &kind);
            change(&mut rng, &mut scene);
            if rng.bool() {
                // Mesa's software driver ends the loops of tiles with more splats.
                let n_times = if name == "cpu" { 4 } else { 2 };
                scene.layers.iter_mut().for_each(|layer| grow(layer, n_times));
            }
            let tree = random_tree(&mut rng, &scene);
            let [whole, laid_over, one_by_one] = pictures(&mut *backend, &scene, &tree);
            for (how, picture) in [("laid over", &laid_over), ("one by one", &one_by_one)] {
                let off = whole.max_difference(picture);
                worst = worst.max(off);
                let n_boxes = tree.seen_by(&scene.camera).len();
                let RenderSettings { slab_width, .. } = scene.settings;
                assert!(
                    off < ROUNDED_TWICE,
                    "{name}, {how}, {n_boxes} boxes, w {slab_width}: {off}, {kind:?}"
                );
            }
        }
    });
    println!("off by {worst} at most");
}

/// Makes a volume one of some times as many voxels along each axis where it is, so that boxes of it have
/// neighbours that they need not know.
fn grow(layer: &mut Layer, n_times: usize) {
    let (grid, scaling) = (*layer.volume.grid(), layer.volume.scaling());
    let finer = DAffine3::from_scale(DVec3::splat(1.0 / n_times as f64));
    let larger =
        Grid::new(grid.dims().map(|n| n_times * n), grid.world_from_index() * finer).unwrap();
    let [nx, ny, nz] = grid.dims();
    let sources = (0..larger.n_voxels()).map(|voxel_idx| {
        let [i, j, k] = larger.voxel_coords(voxel_idx);
        grid.voxel_idx([i % nx, j % ny, k % nz])
    });
    let samples = with_samples!(layer.volume.samples(), |s| {
        sources.map(|idx| s[idx]).collect::<Vec<_>>().into()
    });
    layer.volume = Volume::new(larger, samples, scaling).unwrap().into();
}

/// Up to twelve boxes of one of the layers' grids, cut anywhere.
fn random_tree(rng: &mut Rng, scene: &Scene) -> PartTree {
    let grids = grids(scene);
    let grid = grids[rng.usize(..grids.len())];
    let mut n_more = rng.usize(1..12);
    PartTree::new(&grid, Grid::center_of_all(&grids), |voxels: &[Range<usize>; 3]| {
        let longer: Vec<usize> = (0..3).filter(|axis| 1 < voxels[*axis].len()).collect();
        if n_more == 0 || longer.is_empty() {
            return None;
        }
        n_more -= 1;
        let axis = longer[rng.usize(..longer.len())];
        Some((axis, rng.usize(voxels[axis].start + 1..voxels[axis].end)))
    })
}

fn grids(scene: &Scene) -> Vec<Grid> {
    scene.layers.iter().map(|layer| *layer.volume.grid()).collect()
}

/// The undivided picture, that of parts which know nothing of each other, and that of parts of which each
/// begins with those in front of it.
fn pictures(backend: &mut dyn Backend, scene: &Scene, tree: &PartTree) -> [Image; 3] {
    let mut planner = Planner::default();
    let frame = FrameHandle::new();
    let whole = drawn(backend, &planner.plan_for_frame(scene, &frame).unwrap());
    let background = scene.image.premultiplied_background();
    let ImageDesc { width, height, .. } = scene.image;
    let mut laid_over = Image::filled(width, height, [0.0; 4]);
    let mut one_by_one = laid_over.clone();
    let grids = grids(scene);
    let in_parts = SceneInParts {
        grids: &grids,
        camera: &scene.camera,
        image: &scene.image,
        settings: &scene.settings,
    };
    for of in tree.seen_by(&scene.camera) {
        let mut part = scene.clone();
        part.image.background = [0.0; 4];
        for layer in &mut part.layers {
            let grid = layer.volume.grid();
            let support = planner.support_of_parts(&in_parts, grid).unwrap();
            let volume = layer.volume.cropped(&tree.voxels_near(of, grid, &support));
            let grid = volume.grid().with_cells_of_whole();
            layer.volume = volume.with_grid(grid).unwrap().into();
        }
        let mut plan = planner.plan_part(&part, &of.part, u32::MAX, &frame).unwrap();
        let alone = drawn(backend, &plan);
        lay_behind(&mut laid_over, &alone);
        plan.in_front = Some(&one_by_one);
        one_by_one = drawn(backend, &plan);
    }
    let behind = Image::filled(width, height, background);
    lay_behind(&mut laid_over, &behind);
    lay_behind(&mut one_by_one, &behind);
    [whole, laid_over, one_by_one]
}

fn lay_behind(front: &mut Image, behind: &Image) {
    for (front, behind) in front.pixels_mut().iter_mut().zip(behind.pixels()) {
        *front = over(*front, *behind);
    }
}

fn drawn(backend: &mut dyn Backend, plan: &FramePlan<'_>) -> Image {
    let frame = FrameHandle::new();
    backend.submit(plan, &frame).unwrap();
    backend.wait_image(&frame).unwrap().image
}

/// What cannot be drawn in parts says so.
#[test]
fn parts_are_refused_where_they_would_not_be_the_whole() {
    let kind = SceneKind::all().swap_remove(0);
    let mut rng = Rng::with_seed(7);
    let scene = random_layers(&mut rng, &kind);
    let tree = random_tree(&mut rng, &scene);
    let part = &tree.seen_by(&scene.camera)[0].part;
    for method in Method::ALL.iter().filter(|method| **method != Method::ImageAligned) {
        let mut scene = scene.clone();
        scene.settings.method = *method;
        let error = Planner::default().plan_part(&scene, part, 0, &FrameHandle::new()).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("in parts") && text.contains(method.name()), "{text}");
    }
    assert!(Compositing::ALL.iter().all(|compositing| {
        let mut scene = scene.clone();
        scene.settings.mode = (*compositing).into();
        Planner::default().plan_part(&scene, part, 0, &FrameHandle::new()).is_ok()
    }));
}
