//! What a tolerance may change: the reference with sections merged against the reference with all of them
//! (model §7).

use slabsplat::Renderer;
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{
    Camera, Compositing, Grid, Image, ImageDesc, Layer, Method, Normalization, Projection,
    RenderSettings, Samples, Scaling, Scene, Shading, TransferFunction, Volume,
};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::parity::WithinTolerance;
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::reference::{ReferenceImage, render, render_within_tolerance};
use slabsplat_tests::render::{backends, backends_in_turn, open, render as by_backend};
use std::sync::Arc;

/// The part of a tolerance that the CPU backend may use up with simpler footprints: shorter polynomials, and
/// products.
const SHARE_OF_FOOTPRINTS: f64 = 0.15;

const TOLERANCES: [f64; 4] = [1e-4, 1e-3, 1e-2, 5e-2];

/// The largest difference over all tolerances, as a share of the tolerance.
fn worst_share(scene: &Scene) -> f64 {
    let exact = render(scene);
    let share = |tolerance: f64| {
        let settings = scene.settings.clone().tolerance(tolerance);
        let scene = scene.clone().settings(settings);
        exact.compare_reference(&render_within_tolerance(&scene)).max / tolerance
    };
    TOLERANCES.into_iter().map(share).fold(0.0, f64::max)
}

fn black_to_white(alpha: f64) -> TransferFunction {
    TransferFunction::new(vec![(0.0, [alpha])], vec![(0.0, [0.0; 3]), (1.0, [1.0; 3])])
        .expect("the points rise")
}

#[test]
fn tolerance_on_random_scenes() {
    let mut worst = 0.0_f64;
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in SceneKind::share(seed).filter(merges) {
            let mut scene = random_scene(&mut rng, &kind);
            (scene.image.width, scene.image.height) = (14, 14);
            scene.settings.slab_width = [0.3, 0.77, 1.0, 2.0, 3.3][rng.usize(..5)];
            if rng.bool() {
                // A haze of colours as far apart as can be.
                scene.layers[0].shading = Shading::None;
                scene.layers[0].transfer = black_to_white(0.01 + 0.1 * rng.f64());
            }
            let share = worst_share(&scene);
            assert!(share <= 1.0, "{share} of the tolerance: {kind:?} {:?}", scene.settings);
            worst = worst.max(share);
        }
    });
    println!("at most {worst:.2} of the tolerance");
    assert!(0.01 < worst, "nothing was merged");
}

/// Every backend merges what the definition says: as far from the reference that merges as it may be without
/// a tolerance, and from the exact one as far more as the tolerance.
#[test]
fn tolerance_on_every_backend() {
    let (mut worst, mut worst_share, mut worst_from_exact) = (0.0_f64, 0.0_f64, 0.0_f64);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let kinds = SceneKind::share(seed).filter(merges);
        let kinds = kinds.flat_map(|kind| TOLERANCES.map(|t| (kind, t)));
        for (number, (kind, tolerance)) in kinds.enumerate() {
            let mut scene = random_scene(&mut rng, &kind);
            (scene.image.width, scene.image.height) = (16, 16);
            scene.settings.slab_width = [0.3, 0.77, 1.0, 2.0, 3.3][rng.usize(..5)];
            scene.settings.tolerance = tolerance;
            if rng.bool() {
                scene.layers[0].transfer = black_to_white(0.1 * rng.f64());
            }
            let within = WithinTolerance::new(&scene);
            for backend in backends_in_turn(Method::ImageAligned, number) {
                let drawn = (backend, &by_backend(backend, &scene));
                let [merged, exact] = within.check(drawn, &[], SHARE_OF_FOOTPRINTS, &kind);
                let share = (merged - 1e-3) / tolerance;
                worst_share = worst_share.max(share);
                worst = worst.max(merged);
                worst_from_exact = worst_from_exact.max(exact / tolerance);
            }
        }
    });
    println!(
        "at most {worst:.1e} from what merges, {worst_share:.2} tolerances beyond 1e-3; {worst_from_exact:.2} tolerances from exact"
    );
}

/// A block seen on one tile, whose pixels are so many voxels wide.
fn block_on_a_tile(alpha: f64, voxels_per_pixel: f64) -> Scene {
    let grid = Grid::with_spacing([24; 3], [1.0; 3]).expect("no axis is empty");
    let samples = Samples::U8(vec![1; grid.n_voxels()]);
    let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
    let layer = Layer::new(volume, black_to_white(alpha)).shading(Shading::None);
    let (target, view_height) = (grid.center_in_world(), 8.0 * voxels_per_pixel);
    let eye = target + DVec3::new(13.0, 21.0, 100.0);
    let camera = Camera::new(eye, target, DVec3::Y, Projection::Orthographic { view_height });
    Scene::new(layer, camera.expect("up is not forward")).image(ImageDesc::new(8, 8))
}

/// Faint voxels are one splat each, and so are cells however opaque they are.
#[test]
fn tolerance_saves_sections_on_every_backend() {
    let n_splats = |backend: &str, scene: &Scene| {
        let frame = Renderer::new(open(backend)).render(scene).expect("the scene is valid");
        frame.stats.n_splats
    };
    for &backend in backends() {
        let faint = block_on_a_tile(0.005, 1.9);
        let [merged, all] = [&faint, &exact(&faint)].map(|scene| n_splats(backend, scene));
        assert!(3 * merged < all, "{backend}: {merged} of {all}");
        let by_cells = block_on_a_tile(0.1, 3.0);
        assert_eq!(n_splats(backend, &by_cells), 12 * 12 * 12, "{backend}");
    }
}

fn exact(scene: &Scene) -> Scene {
    scene.clone().settings(scene.settings.clone().tolerance(0.0))
}

fn merges(kind: &SceneKind) -> bool {
    kind.method == Method::ImageAligned
        && kind.compositing == Compositing::Extinction
        && kind.normalization == Normalization::None
}

/// Black and white layers across the view, in step with the slabs: errors of all faces add up.
#[test]
fn tolerance_on_alternating_layers() {
    let mut worst = 0.0_f64;
    for (spacing, period) in [(1.0, 1), (1.0, 2), (2.0, 1)] {
        let grid = Grid::with_spacing([3, 3, 24], [1.0, 1.0, spacing]).expect("no axis is empty");
        let value = |i: usize| (grid.voxel_coords(i)[2] / period % 2) as f64;
        let samples = Samples::F64((0..grid.n_voxels()).map(value).collect());
        let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
        let volume = Arc::new(volume);
        for (slab_width, alpha) in
            [0.5, 1.0, 2.0].iter().flat_map(|&w| [0.02, 0.1, 0.7].map(|alpha| (w, alpha)))
        {
            let target = grid.center_in_world();
            let projection = Projection::Orthographic { view_height: 1.0 };
            let camera = Camera::new(target - 90.0 * DVec3::Z, target, DVec3::Y, projection);
            let layer = Layer::new(volume.clone(), black_to_white(alpha)).shading(Shading::None);
            let scene = Scene::new(layer, camera.expect("up is not forward"))
                .image(ImageDesc::new(2, 2))
                .settings(RenderSettings::default().slab_width(slab_width));
            worst = worst.max(worst_share(&scene));
        }
    }
    println!("at most {worst:.2} of the tolerance");
    assert!(0.1 < worst && worst <= 1.0, "{worst} of the tolerance");
}

/// A block in perspective, seen along its edges by slabs out of step with it: what is merged moves
/// sideways.
#[test]
fn tolerance_on_edges_in_perspective() {
    let mut worst = 0.0_f64;
    for (slab_width, alpha) in
        [0.6, 1.3, 2.0].iter().flat_map(|&w| [0.02, 0.2, 0.9].map(|alpha| (w, alpha)))
    {
        let grid = Grid::with_spacing([6, 6, 16], [1.0; 3]).expect("no axis is empty");
        let samples = Samples::F64(vec![1.0; grid.n_voxels()]);
        let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
        let target = grid.center_in_world() + 2.0 * DVec3::X;
        let projection = Projection::Perspective { fov_y_radians: 0.9 };
        let camera = Camera::new(target - 16.0 * DVec3::Z, target, DVec3::Y, projection);
        let layer = Layer::new(volume, black_to_white(alpha)).shading(Shading::None);
        let scene = Scene::new(layer, camera.expect("up is not forward"))
            .image(ImageDesc::new(18, 18))
            .settings(RenderSettings::default().slab_width(slab_width));
        worst = worst.max(worst_share(&scene));
    }
    println!("at most {worst:.2} of the tolerance");
    assert!(worst <= 1.0, "{worst} of the tolerance");
}

/// Walls as thin as a voxel or two, seen along them: what products are off by adds up over their depth. Along
/// planes of the grid, where their edges may lie a third of a voxel further out, and along others.
#[test]
fn tolerance_on_walls_seen_along() {
    for_each_seed(1, |mut rng| {
        let mut worst = 0.0_f64;
        let grid = Grid::with_spacing([30; 3], [1.0; 3]).expect("no axis is empty");
        let center = grid.center_in_world();
        let mut direction = || DVec3::from_array([0; 3].map(|_| rng.f64() - 0.5)).normalize();
        let generic = (0..6).map(|_| (direction(), direction()));
        let aligned = [(DVec3::X, DVec3::Y), (DVec3::X, DVec3::new(0.0, 1.0, 1.0))];
        for (normal, other) in aligned.into_iter().chain(generic.collect::<Vec<_>>()) {
            for alpha in [0.05, 0.5, 0.8, 1.0] {
                let in_wall = |i: usize| {
                    let from_center =
                        DVec3::from_array(grid.voxel_coords(i).map(|c| c as f64)) - 14.5;
                    f64::from(u8::from(normal.dot(from_center).abs() < 0.8))
                };
                let samples = Samples::F64((0..grid.n_voxels()).map(in_wall).collect());
                let volume =
                    Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
                let forward = normal.cross(other).normalize();
                let projection = Projection::Orthographic { view_height: 14.0 };
                let eye = center - 90.0 * forward;
                let camera =
                    Camera::new(eye, center, forward.cross(DVec3::new(0.3, 0.2, 0.9)), projection);
                let opacity = vec![(0.0, [0.0]), (0.5, [0.0]), (1.0, [alpha])];
                let transfer = TransferFunction::new(opacity, vec![(0.0, [1.0; 3])]);
                let layer = Layer::new(volume, transfer.expect("rising")).shading(Shading::None);
                let scene = Scene::new(layer, camera.expect("up is not forward"))
                    .image(ImageDesc::new(40, 40));
                let (exact, image) = (render(&scene), by_backend("cpu", &scene));
                let difference = exact.compare(&image).max;
                let nearby = outside_of_neighbours(&exact, &image);
                println!("{normal:.2} along {forward:.2}, {alpha}: {difference:.1e}, {nearby:.1e}");
                worst = worst.max(nearby / scene.settings.tolerance);
            }
        }
        println!("at most {worst:.2} of the tolerance");
        assert!(worst <= 1.0, "{worst} of the tolerance");
    });
}

/// Grids of unequal steps, sheared ones too, seen from anywhere: short cuts for tilted slabs and sheared
/// footprints, against the CPU's own exact picture, which parity holds against the reference.
#[test]
fn tolerance_on_stretched_grids() {
    for_each_seed(2, |mut rng| {
        let (mut worst, mut most_mean) = (0.0_f32, 0.0_f64);
        for _ in 0..60 {
            let mut columns = DMat3::from_diagonal(DVec3::from_array(
                [0; 3].map(|_| 1.0 + 2.5 * rng.f64() * rng.f64()),
            ));
            columns.y_axis.x = 0.4 * (rng.f64() - 0.5);
            let grid =
                Grid::new([10, 11, 12], DAffine3::from_mat3(columns)).expect("it is no plane");
            let samples = Samples::U8((0..grid.n_voxels()).map(|_| rng.u8(..)).collect());
            let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
            let alpha = rng.f64();
            let opacity = vec![(0.0, [0.0]), (255.0, [alpha])];
            let color = vec![(0.0, [1.0, 0.3, 0.0]), (255.0, [0.2, 1.0, 1.0])];
            let transfer = TransferFunction::new(opacity, color).expect("the points rise");
            let mut direction = || DVec3::from_array([0; 3].map(|_| rng.f64() - 0.5)).normalize();
            let (eye, up) = (grid.center_in_world() + 60.0 * direction(), direction());
            let projection = if rng.bool() {
                Projection::Orthographic { view_height: 4.0 + 30.0 * rng.f64() }
            } else {
                Projection::Perspective { fov_y_radians: 0.1 + 0.4 * rng.f64() }
            };
            let camera = Camera::new(eye, grid.center_in_world(), up, projection);
            let layer = Layer::new(volume, transfer);
            let scene =
                Scene::new(layer, camera.expect("up is not forward")).image(ImageDesc::new(70, 70));
            let settings = RenderSettings::default().slab_width([0.5, 1.0, 2.0][rng.usize(..3)]);
            let of_tolerance = |tolerance: f64| {
                let scene = scene.clone().settings(settings.clone().tolerance(tolerance));
                by_backend("cpu", &scene)
            };
            let [exact, image] = [0.0, 0.05].map(of_tolerance);
            worst = worst.max(image.max_difference(&exact));
            let (a, b) = (exact.pixels().as_flattened(), image.pixels().as_flattened());
            let sum: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).abs()).sum();
            most_mean = most_mean.max(sum / a.len() as f64);
        }
        println!("at most {worst:.1e}, in the mean of a picture {most_mean:.1e}");
        assert!(worst < 0.025, "{worst}");
        assert!(most_mean < 2e-3, "{most_mean}");
    });
}

/// By how much any pixel lies outside of what it and its eight neighbours are in the exact picture.
fn outside_of_neighbours(exact: &ReferenceImage, image: &Image) -> f64 {
    let mut worst = 0.0_f64;
    for (x, y) in (0..image.width()).flat_map(|x| (0..image.height()).map(move |y| (x, y))) {
        let pixel = image.pixel(x, y).map(f64::from);
        let columns = x.saturating_sub(1)..(x + 2).min(image.width());
        let rows = y.saturating_sub(1)..(y + 2).min(image.height());
        for (channel, value) in pixel.into_iter().enumerate() {
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for (column, row) in columns.clone().flat_map(|c| rows.clone().map(move |r| (c, r))) {
                let near = exact.pixel(column, row)[channel];
                (least, most) = (near.min(least), near.max(most));
            }
            worst = worst.max(least - value).max(value - most);
        }
    }
    worst
}

/// What shows the slab width by definition is left alone, to the last bit.
#[test]
fn tolerance_spares_other_compositing() {
    let mut rng = fastrand::Rng::with_seed(3);
    for kind in SceneKind::all() {
        if kind.compositing == Compositing::Extinction && kind.normalization == Normalization::None
        {
            continue;
        }
        let mut scene = random_scene(&mut rng, &kind);
        (scene.image.width, scene.image.height) = (4, 4);
        scene.settings.tolerance = 0.5;
        assert_eq!(render(&scene), render_within_tolerance(&scene), "{kind:?}");
    }
}
