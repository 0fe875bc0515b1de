//! Opaque meshes (model §14), on scenes at random: every backend that draws them against the float64
//! reference and against the CPU at the tolerances of model §9, and what must not change a picture.

use slabsplat::glam::{DAffine3, DMat3, DVec3};
use slabsplat::{
    Camera, Compositing, Grid, ImageDesc, Layer, Mesh, MeshLayer, MeshParts, Method, Mode,
    Normalization, Projection, RenderSettings, Samples, Scaling, Scene, Shading, TransferFunction,
    Volume,
};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::exact_settings;
use slabsplat_tests::parity::WithinTolerance;
use slabsplat_tests::random_scene::{SceneKind, random_meshes};
use slabsplat_tests::reference::{self, undecided_pixels};
use slabsplat_tests::render::{backends, backends_in_turn, backends_with, open, pictures, render};

/// The part of a tolerance that the CPU backend may use up with simpler footprints.
const SHARE_OF_FOOTPRINTS: f64 = 0.2;

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// Of so many scenes one is drawn by a GPU, too, and all by the CPU.
const ONE_IN: u64 = 3;

/// What a pixel may differ from that of the CPU backend.
const FROM_CPU: f32 = 1e-3;

#[test]
fn parity_of_meshes_in_layers() {
    check_parity(Method::ImageAligned);
}

#[test]
fn parity_of_meshes_in_densities() {
    check_parity(Method::PostClassified);
}

fn check_parity(method: Method) {
    let mut tallies: Vec<(&str, Tally)> =
        backends_with(method).map(|backend| (backend, Tally::default())).collect();
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let kinds = SceneKind::share(seed).filter(|kind| kind.method == method);
        for (number, kind) in kinds.step_by(3).enumerate() {
            let mut scene = random_meshes(&mut rng, &kind);
            // Meshes alone, now and then.
            if rng.u32(..8) == 0 && method == Method::ImageAligned {
                scene.layers.clear();
            }
            let expected = reference::render(&scene);
            let undecided = undecided_pixels(&scene);
            // Drivers that only play a device take longer than all else.
            let is_for_gpus = (number as u64 + seed).is_multiple_of(ONE_IN);
            let n_backends = if is_for_gpus { 2 } else { 1 };
            let backends = backends_in_turn(method, number / ONE_IN as usize).take(n_backends);
            let pictures = pictures(backends, &scene);
            let (_, by_cpu) = &pictures[0];
            for (backend, image) in &pictures {
                let off = expected.clone().leaving(&undecided, image).compare(image);
                // All find hits by the same code, so that nothing is undecided between them.
                let from_cpu = image.max_difference(by_cpu);
                let what = format!("{backend}, {kind:?}, w {}", scene.settings.slab_width);
                let Scene { meshes, .. } = &scene;
                assert!(off.max < MAX_DIFFERENCE, "{off:?}: {what}, {meshes:?}");
                assert!(off.mean < MEAN_DIFFERENCE, "{off:?}: {what}, {meshes:?}");
                assert!(from_cpu < FROM_CPU, "{from_cpu} off the CPU: {what}, {meshes:?}");
                let tally = tallies.iter_mut().find(|(name, _)| name == backend);
                let tally = &mut tally.expect("it has a tally").1;
                tally.n_scenes += 1;
                tally.n_undecided += undecided.iter().filter(|is_undecided| **is_undecided).count();
                tally.max = tally.max.max(off.max);
                tally.mean = tally.mean.max(off.mean);
                tally.from_cpu = tally.from_cpu.max(from_cpu);
            }
        }
    });
    for (backend, tally) in tallies {
        println!("{backend}: {tally:?}");
    }
}

/// The largest differences, each over all scenes.
#[derive(Debug, Default)]
struct Tally {
    n_scenes: usize,
    n_undecided: usize,
    max: f64,
    mean: f64,
    from_cpu: f32,
}

/// Pictures with meshes may be off by no more than their tolerance, and every backend merges what the
/// definition says.
#[test]
fn tolerance_beside_meshes() {
    let mut worst = 0.0_f64;
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        let merges = |kind: &SceneKind| {
            kind.method == Method::ImageAligned
                && kind.compositing == Compositing::Extinction
                && kind.normalization == Normalization::None
        };
        for (number, kind) in SceneKind::share(seed).filter(merges).enumerate() {
            let tolerance = [1e-3, 0.05][rng.usize(..2)];
            let mut scene = random_meshes(&mut rng, &kind);
            (scene.image.width, scene.image.height) = (16, 16);
            scene.settings.tolerance = tolerance;
            let (within, undecided) = (WithinTolerance::new(&scene), undecided_pixels(&scene));
            for backend in backends_in_turn(Method::ImageAligned, number) {
                let drawn = (backend, &render(backend, &scene));
                let [_, exact] = within.check(drawn, &undecided, SHARE_OF_FOOTPRINTS, &kind);
                worst = worst.max(exact / tolerance);
            }
        }
    });
    println!("at most {worst:.2} tolerances");
}

/// Nor does the order of triangles, lines and points, and of their corners' vertices, but for which corner is
/// the first.
#[test]
fn order_of_meshes_and_triangles_changes_no_bit() {
    for_each_seed(1, |mut rng| {
        let has_meshes =
            |kind: &SceneKind| matches!(kind.method, Method::ImageAligned | Method::PostClassified);
        for kind in SceneKind::all().into_iter().filter(has_meshes).step_by(5) {
            let mut scene = random_meshes(&mut rng, &kind);
            let expected = render("cpu", &scene);
            rng.shuffle(&mut scene.meshes);
            for layer in &mut scene.meshes {
                let mesh = &layer.mesh;
                let mut triangles = mesh.triangles().to_vec();
                rng.shuffle(&mut triangles);
                let (mut lines, mut points) = (mesh.lines().to_vec(), mesh.points().to_vec());
                rng.shuffle(&mut lines);
                rng.shuffle(&mut points);
                let n_vertices = mesh.positions().len();
                let normals = (0..n_vertices).filter_map(|vertex| mesh.vertex_normal(vertex));
                let colors = (0..n_vertices).filter_map(|vertex| mesh.vertex_color(vertex));
                let parts = MeshParts::new(mesh.positions().to_vec())
                    .triangles(triangles)
                    .lines(lines)
                    .points(points)
                    .normals(normals.collect())
                    .colors(colors.collect());
                layer.mesh = Mesh::new(parts).expect("nothing is lost").into();
            }
            assert!(render("cpu", &scene) == expected, "{kind:?}");
        }
    });
}

/// What was drawn before leaves no trace, be it with meshes or without.
#[test]
fn meshes_come_and_go() {
    let has_meshes =
        |kind: &SceneKind| matches!(kind.method, Method::ImageAligned | Method::PostClassified);
    let kinds = || SceneKind::all().into_iter().filter(has_meshes).step_by(37);
    for (number, &backend) in backends().iter().enumerate() {
        for_each_seed(1, |mut rng| {
            let mut renderer = slabsplat::Renderer::new(open(backend));
            let kinds = kinds().filter(|kind| backends_with(kind.method).any(|it| it == backend));
            // The CPU draws all; the others, which a driver may play, every other one.
            let (first, step) = if backend == "cpu" { (0, 1) } else { (number % 2, 2) };
            for kind in kinds.skip(first).step_by(step) {
                let scene = random_meshes(&mut rng, &kind);
                let without = scene.clone().meshes(Vec::new());
                let alone = scene.clone().layers(Vec::new());
                let mut moved = scene.clone();
                let mesh = &mut moved.meshes[0];
                let aside = DAffine3::from_translation(DVec3::new(0.3, -0.2, 0.1));
                *mesh = mesh.clone().placed(aside * mesh.world_from_mesh()).expect("it is moved");
                let turned = moved.clone().camera(moved.camera.orbited(0.4));
                let scenes = [scene, without, moved, turned, alone];
                let expected = scenes.each_ref().map(|scene| render(backend, scene));
                for (idx, of) in [0, 1, 0, 0, 2, 3, 4, 1].into_iter().enumerate() {
                    let image = renderer.render(&scenes[of]).expect("the scene is valid").image;
                    assert!(image == expected[of], "{backend}, frame {idx}: {kind:?}");
                }
            }
        });
    }
}

/// A medium that is the same everywhere in a cube about the world's origin, 24 world units a side, which
/// takes so much light per world unit.
fn medium(extinction: f64) -> Layer {
    let world_from_index = DAffine3::from_translation(DVec3::splat(-12.0));
    let grid = Grid::new([25; 3], world_from_index).expect("no step is 0");
    let samples = Samples::F64(vec![1.0; grid.n_voxels()]);
    let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
    let opacity = -(-extinction).exp_m1();
    let transfer = TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, [0.2, 0.4, 0.8])]);
    Layer::new(volume, transfer.expect("an opacity is from 0 to 1")).shading(Shading::None)
}

/// An opaque square across the view, 40 world units a side, of one colour.
fn wall(z: f64, color: [f64; 3]) -> MeshLayer {
    let corner = |x: f64, y: f64| DVec3::new(20.0 * x, 20.0 * y, z);
    let positions =
        vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let parts = MeshParts::new(positions).triangles(vec![[0, 1, 2], [0, 2, 3]]);
    let mesh = Mesh::new(parts).expect("it has neither normals nor colours");
    MeshLayer::new(mesh).shading(Shading::None).color(color)
}

/// Looks along −z at the origin, from 40.
fn scene(layers: Vec<Layer>, meshes: Vec<MeshLayer>, settings: RenderSettings) -> Scene {
    let projection = Projection::Orthographic { view_height: 12.0 };
    let camera = Camera::new(40.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, projection);
    Scene::of_meshes(meshes, camera.expect("up is not forward"))
        .layers(layers)
        .image(ImageDesc::new(40, 40).background([1.0; 4]))
        .settings(settings)
}

const RED: [f64; 3] = [1.0, 0.0, 0.0];

/// Each method with all backends that draw meshes by it.
fn with_backends<const N: usize>(
    methods: [Method; N],
) -> impl Iterator<Item = (&'static str, Method)> {
    methods.into_iter().flat_map(|method| backends_with(method).map(move |name| (name, method)))
}

/// Exactly as much of a haze lies before a wall as there is before it, however thick slabs are.
#[test]
fn wall_in_a_haze() {
    for (backend, method) in with_backends([Method::ImageAligned, Method::PostClassified]) {
        for (z, slab_width) in [(0.0, 1.0), (0.3, 1.0), (-5.7, 1.0), (7.25, 3.3), (2.0, 0.4)] {
            let settings = exact_settings().method(method).slab_width(slab_width);
            let mut scene = scene(vec![medium(0.05)], vec![wall(z, RED)], settings);
            // All pixels are alike.
            (scene.image.width, scene.image.height) = (16, 16);
            let image = render(backend, &scene);
            let through = (-0.05 * (12.5 - z)).exp();
            for pixel in image.pixels() {
                let [red, green, blue, alpha] = pixel.map(f64::from);
                let haze = 1.0 - through;
                let expected = [through + 0.2 * haze, 0.4 * haze, 0.8 * haze, 1.0];
                for (channel, expected) in [red, green, blue, alpha].into_iter().zip(expected) {
                    // Kernels sum up to nearly 1, and end not all at once.
                    assert!(
                        (channel - expected).abs() < 0.01,
                        "{backend} {method} {z} {slab_width}: {pixel:?} {expected}"
                    );
                }
            }
        }
    }
}

/// What lies behind a wall is not there, and never looked at.
#[test]
fn wall_hides_what_is_behind() {
    for method in [Method::ImageAligned, Method::PostClassified] {
        let settings = exact_settings().method(method);
        let of = |meshes| scene(vec![medium(0.3)], meshes, settings.clone());
        let mut renderer = slabsplat::Renderer::new(open("cpu"));
        let frame = renderer.render(&of(vec![wall(20.0, RED)])).expect("the scene is valid");
        assert!(frame.image.pixels().iter().all(|pixel| *pixel == [1.0, 0.0, 0.0, 1.0]));
        assert_eq!(frame.stats.n_splats, 0, "{method}");
        assert_eq!(frame.stats.n_occluded, frame.stats.n_voxels, "{method}");
        // Half way in, the other half is occluded.
        let half = renderer.render(&of(vec![wall(0.0, RED)])).expect("the scene is valid").stats;
        let all = renderer.render(&of(vec![])).expect("the scene is valid").stats;
        assert!(half.n_splats < all.n_splats * 7 / 10, "{method}: {half:?} {all:?}");
        // Behind it all, it changes nothing but the background.
        let behind = render("cpu", &of(vec![wall(-30.0, [1.0; 3])]));
        let difference = behind.max_difference(&render("cpu", &of(vec![])));
        assert!(difference < 1e-6, "{method}: {difference}");
    }
}

/// A wall that covers half of each pixel: the mean of what it hides and what it shows.
#[test]
fn edge_is_smooth() {
    // A pixel is 0.3 wide: the wall's edge runs through the middle of the tenth column.
    let moved = DAffine3::from_translation(DVec3::new(20.0 - 6.0 + 9.5 * 0.3, 0.0, 0.0));
    let wall = wall(0.0, RED).placed(moved).expect("it is only moved");
    let modes = [Mode::Extinction, Mode::Separate, Mode::Associated];
    let backends = backends_with(Method::ImageAligned);
    for (backend, mode) in backends.flat_map(|name| modes.map(|mode| (name, mode))) {
        let settings = exact_settings().mode(mode);
        let image = |meshes| {
            let mut scene = scene(vec![medium(0.05)], meshes, settings.clone());
            // A fifth of the rows, which are all alike.
            scene.image.height = 8;
            let [eye, target, up] = [scene.camera.eye(), scene.camera.target(), scene.camera.up()];
            let projection = Projection::Orthographic { view_height: 12.0 / 5.0 };
            scene.camera = Camera::new(eye, target, up, projection).expect("it looks as before");
            render(backend, &scene)
        };
        let (with, without) = (image(vec![wall.clone()]), image(vec![]));
        for y in 0..8 {
            assert_eq!(with.pixel(8, y), without.pixel(8, y), "{backend}, {mode}");
            let [edge, occluded, shown] =
                [with.pixel(9, y), with.pixel(10, y), without.pixel(9, y)];
            for channel in 0..4 {
                let expected = 0.5 * (occluded[channel] + shown[channel]);
                let off = (edge[channel] - expected).abs();
                assert!(off < 1e-5, "{backend}, {mode}: {edge:?} {expected}");
            }
        }
    }
}

/// A mesh of no triangles is none.
#[test]
fn mesh_of_nothing() {
    let empty = MeshLayer::new(Mesh::default());
    let settings = RenderSettings::default();
    let with = scene(vec![medium(0.1)], vec![empty.clone()], settings.clone().tolerance(0.0));
    let without = with.clone().meshes(Vec::new());
    for backend in backends_with(Method::ImageAligned) {
        assert!(render(backend, &with) == render(backend, &without), "{backend}");
        let alone = render(backend, &scene(Vec::new(), vec![empty.clone()], settings.clone()));
        assert!(alone.pixels().iter().all(|pixel| *pixel == [1.0; 4]), "{backend}");
    }
}

/// Meshes that no number holds are an error or nothing, not a panic.
#[test]
fn meshes_beyond_numbers() {
    for backend in backends_with(Method::ImageAligned) {
        let mut renderer = slabsplat::Renderer::new(open(backend));
        for size in [1e-300, 1e-30, 1e30, 1e150, 1e300, 1e308] {
            let world_from_mesh = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::splat(size)));
            let Ok(layer) = wall(0.5, RED).placed(world_from_mesh) else { continue };
            let settings = RenderSettings::default();
            let beside = scene(vec![medium(0.1)], vec![layer.clone()], settings.clone());
            let beside = renderer.render(&beside).expect("there is a volume");
            let alone = renderer.render(&scene(Vec::new(), vec![layer], settings));
            for frame in std::iter::once(beside).chain(alone) {
                let mut channels = frame.image.pixels().iter().flatten();
                assert!(channels.all(|channel| channel.is_finite()), "{backend}, {size}");
            }
        }
    }
}

#[test]
fn methods_without_meshes_say_so() {
    let mut planner = slabsplat::Planner::default();
    for (method, mode, who) in [
        (Method::AxisAligned, Mode::Extinction, "the method axis-aligned draws no meshes"),
        (Method::EverySample, Mode::Separate, "the method every-sample draws no meshes"),
        (Method::ImageAligned, Mode::Maximum, "the mode maximum draws no meshes"),
        (Method::PostClassified, Mode::Average, "the mode average draws no meshes"),
    ] {
        let settings = RenderSettings::default().method(method).mode(mode);
        let scene = scene(vec![medium(0.1)], vec![wall(0.0, RED)], settings);
        let error = planner.plan(&scene).expect_err("there are no such pictures").to_string();
        assert!(error.starts_with(who), "{error}");
    }
    let nothing = scene(Vec::new(), Vec::new(), RenderSettings::default());
    assert!(planner.plan(&nothing).is_err());
}
