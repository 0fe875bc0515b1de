//! The mode `isosurfaces` (model §12): the CPU against the float64 reference, and what is known without it.

use fastrand::Rng;
use slabsplat::glam::DVec3;
use slabsplat::{
    Camera, Grid, Image, ImageDesc, Isosurface, Layer, Light, Method, Mode, Phong, Plane,
    Projection, Region, RenderSettings, Samples, Scaling, Scene, Shading, TransferFunction, Volume,
};
use slabsplat_seeds::{for_each_numbered_seed, for_each_seed};
use slabsplat_tests::exact_settings;
use slabsplat_tests::random_scene::{SceneKind, random_layers};
use slabsplat_tests::reference::render_with_undecided;
use slabsplat_tests::render::render;

/// What a pixel may differ from the reference at most, and on average over a picture.
const MAX_DIFFERENCE: f64 = 1e-3;
const MEAN_DIFFERENCE: f64 = 1e-4;

/// The part of all pixels that may lie where a ray just touches a surface.
const UNDECIDED: f64 = 0.02;

/// Every kernel, projection and kind of grid, with regions and without.
#[test]
fn parity_of_isosurfaces() {
    let (mut n_scenes, mut max, mut mean) = (0, 0.0_f64, 0.0_f64);
    let (mut n_undecided, mut n_pixels, mut n_seen) = (0, 0, 0);
    for_each_numbered_seed(SceneKind::SHARES, |seed, mut rng| {
        for kind in SceneKind::share(seed).filter(|kind| kind.method == Method::PostClassified) {
            let scene = random_layers(&mut rng, &kind);
            let scene = with_random_isosurfaces(&mut rng, scene);
            let image = render("cpu", &scene);
            let (mut expected, undecided) = render_with_undecided(&scene);
            for (idx, is_undecided) in undecided.into_iter().enumerate() {
                if is_undecided {
                    expected.pixels[idx] = image.pixels()[idx].map(f64::from);
                    n_undecided += 1;
                }
            }
            let background = scene.image.premultiplied_background();
            n_seen += image.pixels().iter().filter(|pixel| **pixel != background).count();
            n_pixels += image.pixels().len();
            let off = expected.compare(&image);
            let what = format!("{kind:?}, w {}", scene.settings.slab_width);
            assert!(off.max < MAX_DIFFERENCE, "{:?} by {}: {what}", off.worst_pixel, off.max);
            assert!(off.mean < MEAN_DIFFERENCE, "pixels are off by {}: {what}", off.mean);
            (n_scenes, max, mean) = (n_scenes + 1, max.max(off.max), mean.max(off.mean));
        }
    });
    println!("{n_scenes} scenes: at most {max:.1e}, {mean:.1e} on average");
    println!("{n_undecided} of {n_pixels} pixels undecided, {n_seen} seen");
    assert!((n_undecided as f64) < UNDECIDED * n_pixels as f64, "{n_undecided} of {n_pixels}");
    assert!(n_pixels < 10 * n_seen, "{n_seen} of {n_pixels}");
}

fn with_random_isosurfaces(rng: &mut Rng, mut scene: Scene) -> Scene {
    let layer = &mut scene.layers[0];
    let n_voxels = layer.volume.grid().n_voxels();
    let values = (0..n_voxels).map(|i| layer.volume.value(i)).filter(|v| v.is_finite());
    let [lo, hi] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)]);
    let surfaces = (0..rng.usize(1..=3)).map(|_| {
        let color = rng.bool().then(|| [0; 3].map(|_| rng.f64()));
        let opacity = if rng.bool() { 1.0 } else { rng.f64() };
        isosurface(lo + (hi - lo) * (0.1 + 0.8 * rng.f64()), opacity, color)
    });
    layer.isosurfaces = surfaces.collect();
    scene.settings.mode = Mode::Isosurfaces;
    scene
}

fn isosurface(value: f64, opacity: f64, color: Option<[f64; 3]>) -> Isosurface {
    Isosurface::new(value, opacity, color).expect("a number, and shares of one")
}

/// `image-aligned` and `post-classified` have the same surfaces, in whatever order they are listed.
#[test]
fn isosurfaces_have_no_order() {
    for_each_seed(1, |mut rng| {
        let kinds = SceneKind::all().into_iter();
        for kind in kinds.filter(|kind| kind.method == Method::PostClassified).step_by(7) {
            let scene = random_layers(&mut rng, &kind);
            let mut scene = with_random_isosurfaces(&mut rng, scene);
            let image = render("cpu", &scene);
            scene.layers[0].isosurfaces.reverse();
            scene.settings.method = Method::ImageAligned;
            assert!(render("cpu", &scene) == image, "{kind:?}");
        }
    });
}

/// The shape of a volume, and how it is looked at.
struct Phantom {
    dims: [usize; 3],
    /// Pixels to a voxel, and pixels a side.
    zoom: f64,
    side: u32,
    /// From where, and what is upwards.
    from: [DVec3; 2],
    is_perspective: bool,
}

impl Phantom {
    /// Seen along −z.
    fn new(dims: [usize; 3], zoom: f64, side: u32) -> Self {
        Self { dims, zoom, side, from: [DVec3::Z, DVec3::Y], is_perspective: false }
    }

    /// Unlit surfaces of a density that is a function of the position from the middle, in voxels.
    fn scene(
        &self,
        density: impl Fn(DVec3) -> f64,
        isosurfaces: Vec<Isosurface>,
        settings: RenderSettings,
    ) -> Scene {
        let grid = Grid::with_spacing(self.dims, [1.0; 3]).expect("no axis is empty");
        let middle = grid.center_in_world();
        let value = |idx: usize| {
            density(DVec3::from_array(grid.voxel_coords(idx).map(|c| c as f64)) - middle)
        };
        let samples = Samples::F64((0..grid.n_voxels()).map(value).collect());
        let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
        let transfer = TransferFunction::new(vec![(0.0, [1.0])], vec![(0.0, [1.0; 3])]);
        let [from, up] = self.from;
        let height = f64::from(self.side) / self.zoom;
        let projection = if self.is_perspective {
            Projection::Perspective { fov_y_radians: 2.0 * (0.5 * height / DISTANCE).atan() }
        } else {
            Projection::Orthographic { view_height: height }
        };
        let camera = Camera::new(middle + DISTANCE * from, middle, up, projection);
        let layer = Layer::new(volume, transfer.expect("a point"))
            .shading(Shading::None)
            .isosurfaces(isosurfaces);
        Scene::new(layer, camera.expect("it looks somewhere"))
            .image(ImageDesc::new(self.side, self.side))
            .settings(settings.mode(Mode::Isosurfaces))
    }
}

/// Of the eye from the middle of a phantom.
const DISTANCE: f64 = 120.0;

/// A half-space of positions from the middle of a scene's volume.
fn half_space(scene: &Scene, normal: DVec3, distance: f64) -> Region {
    let middle = scene.layers[0].volume.grid().center_in_world();
    let plane = Plane::new(normal, distance + normal.dot(middle)).expect("the normal is not zero");
    Region::new(vec![plane])
}

/// A ball's radius, by which its density is 100, and what the kernel leaves of it: a mean over a Gaussian of
/// variance σ² is what a smooth function is, and half of σ² times its Laplacian, here twice the slope per
/// radius.
const RADIUS: f64 = 16.4;

fn ball(at: DVec3) -> f64 {
    100.0 + 4.0 * (RADIUS - at.length())
}

fn radius_by_kernel() -> f64 {
    RADIUS - 0.25 / std::f64::consts::LN_2 / RADIUS
}

/// Positions and normals of a ball, lit from the side: a pixel is as bright as its normal points there.
#[test]
fn isosurface_of_a_ball_has_its_normals() {
    let phantom = Phantom { from: TILTED, ..Phantom::new([44; 3], 4.0, 150) };
    let [from, up] = phantom.from;
    let scene = phantom.scene(ball, vec![isosurface(100.0, 1.0, None)], exact_settings());
    let light = (from + 0.7 * up).normalize();
    let phong = Phong::default().ambient(0.0).diffuse(1.0).specular(0.0).two_sided(false);
    let light_from = Light::towards(light).expect("it is not zero");
    let mut scene = scene;
    scene.layers[0].shading = Shading::Phong(phong);
    scene.lights = vec![light_from];
    let image = render("cpu", &scene);
    let right = up.cross(from).normalize();
    let (mut worst, mut sum, mut n_pixels) = (0.0_f64, 0.0, 0);
    for (y, x) in (0..150).flat_map(|y| (0..150).map(move |x| (y, x))) {
        let [x_view, y_view] = [x, y].map(|p| (f64::from(p) + 0.5 - 75.0) / 4.0);
        let across = x_view.hypot(y_view) / radius_by_kernel();
        let [red, .., opacity] = image.pixel(x, y);
        // A hundredth of a voxel.
        let is_at_edge = (across - 1.0).abs() < 6e-4;
        let is_hit = if across < 1.0 { 1.0 } else { 0.0 };
        assert!(is_at_edge || opacity == is_hit, "{x} {y}: {across}");
        if across < 0.97 {
            let depth = radius_by_kernel() * (1.0 - across * across).sqrt();
            let upwards = from.cross(right);
            let normal = (right * x_view - upwards * y_view + from * depth).normalize();
            let expected = normal.dot(light).max(0.0);
            let off = (f64::from(red) - expected).abs();
            (worst, sum, n_pixels) = (worst.max(off), sum + off, n_pixels + 1);
        }
    }
    let mean = sum / f64::from(n_pixels);
    println!("{n_pixels} pixels, at most {worst:.1e}, {mean:.1e} on average");
    // The kernel's own: its ramps have waves of a hundredth of a voxel.
    assert!(worst < 0.04 && mean < 0.008 && 10_000 < n_pixels, "{worst}, {mean}, {n_pixels}");
}

/// A view that no axis of the grid suits.
const TILTED: [DVec3; 2] = [DVec3::new(0.51, 0.34, 0.79), DVec3::new(0.1, 0.9, 0.2)];

/// Where a ray meets a surface: a plane that cuts it off lies nearer.
fn position_on_middle_ray(scene: &Scene) -> f64 {
    let [mut behind, mut before] = [-10.0, 10.0];
    for _ in 0..14 {
        let middle = 0.5 * (behind + before);
        let mut cut = scene.clone();
        cut.layers[0].region = half_space(scene, DVec3::Z, middle);
        let [.., opacity] = render("cpu", &cut).pixel(1, 1);
        if opacity == 0.0 { behind = middle } else { before = middle }
    }
    0.5 * (behind + before)
}

/// Walls lie where they are, not where the next sheet is: those of a ramp, and of an edge as sharp as voxels
/// have one, half way up, and far below and above. What is left is the kernel's, in thin slabs too.
#[test]
fn isosurface_of_a_wall_is_between_sheets() {
    let edge = |z: f64| 50.0 - 50.0 * (1.2 * z).tanh();
    let ramp = |z: f64| 50.0 - 7.0 * z;
    for (is_perspective, value) in [(false, 50.0), (true, 50.0), (false, 10.0), (false, 90.0)] {
        for density in [&ramp as &dyn Fn(f64) -> f64, &edge] {
            let positions = |slab_width: f64| {
                let position = |step: u32| {
                    let from_voxel = f64::from(step) / 8.0;
                    let phantom = Phantom { is_perspective, ..Phantom::new([9, 9, 25], 4.0, 3) };
                    let settings = exact_settings().slab_width(slab_width);
                    let surface = vec![isosurface(value, 1.0, None)];
                    let scene = phantom.scene(|at| density(at.z - from_voxel), surface, settings);
                    position_on_middle_ray(&scene) - from_voxel
                };
                (0..8).map(position).collect::<Vec<f64>>()
            };
            let (positions, thin) = (positions(1.0), positions(0.2));
            let off = |(position, thin): (&f64, &f64)| (position - thin).abs();
            let worst = positions.iter().zip(&thin).map(off).fold(0.0, f64::max);
            let ends =
                thin.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], position| {
                    [position.min(lo), position.max(hi)]
                });
            println!("{value}: {worst:.1e} off thin slabs, those at {ends:?}");
            assert!(worst < 0.01 && ends[1] - ends[0] < 0.06, "{value}: {worst}, {ends:?}");
        }
    }
}

/// A shell within another: what is before the rest, and behind it.
#[test]
fn isosurfaces_lie_before_each_other() {
    let outer = isosurface(100.0, 0.25, Some([1.0, 0.0, 0.0]));
    let inner = isosurface(120.0, 0.5, Some([0.0, 1.0, 0.0]));
    for is_perspective in [false, true] {
        let phantom = Phantom { is_perspective, from: TILTED, ..Phantom::new([44; 3], 1.0, 41) };
        let image = render("cpu", &phantom.scene(ball, vec![inner, outer], exact_settings()));
        let assert_close = |pixel: [f32; 4], expected: [f32; 4]| {
            let is_close = (0..4).all(|i| (pixel[i] - expected[i]).abs() < 1e-6);
            assert!(is_close, "{pixel:?}, not {expected:?}");
        };
        // Front of the outer one, of the inner one, and their backs.
        let through = 0.75 * 0.5 * 0.5;
        let red = 0.25 + through * 0.25;
        let green = 0.75 * (0.5 + 0.5 * 0.5);
        assert_close(image.pixel(20, 20), [red, green, 0.0, 1.0 - 0.75 * through]);
        // Past the inner one.
        assert_close(image.pixel(20, 6), [0.4375, 0.0, 0.0, 0.4375]);
        assert_close(image.pixel(20, 1), [0.0; 4]);
    }
}

/// A region leaves of a surface what lies in it, and its complement the rest.
#[test]
fn isosurfaces_are_cut() {
    let phantom = Phantom::new([44; 3], 1.0, 41);
    let scene = phantom.scene(ball, vec![isosurface(100.0, 0.5, None)], exact_settings());
    let opacity = |region: Region, x: u32, y: u32| {
        let mut scene = scene.clone();
        scene.layers[0].region = region;
        render("cpu", &scene).pixel(x, y)[3]
    };
    let back = half_space(&scene, DVec3::Z, 4.0);
    for region in [back.clone(), back.clone().inverted()] {
        assert_eq!(opacity(region, 20, 20), 0.5);
    }
    // Near the silhouette both sides lie behind it.
    assert_eq!(opacity(back.clone(), 20, 4), 0.75);
    assert_eq!(opacity(back.inverted(), 20, 4), 0.0);
    let right = half_space(&scene, -DVec3::X, 0.0);
    assert_eq!([opacity(right.clone(), 25, 20), opacity(right, 15, 20)], [0.75, 0.0]);
}

/// Where a volume ends there is no surface, and a surface that reaches its border ends there, half a voxel
/// outside of the outermost ones.
#[test]
fn isosurfaces_end_with_the_volume() {
    let wall = |at: DVec3| 100.0 + 5.0 * at.z;
    let phantom = Phantom::new([12, 12, 12], 16.0, 256);
    let surface = vec![isosurface(100.0, 1.0, None)];
    let image = render("cpu", &phantom.scene(wall, surface.clone(), exact_settings()));
    let mut last = 1.0;
    for x in 128..256 {
        let [.., opacity] = image.pixel(x, 120);
        let outside = (f64::from(x) + 0.5 - 128.0) / 16.0 - 5.5;
        assert!(opacity <= last, "{outside}: {opacity} after {last}");
        assert!(0.0 <= outside || opacity == 1.0, "{outside}: {opacity}");
        assert!(outside <= 0.75 || opacity == 0.0, "{outside}: {opacity}");
        let is_half = (0.35..0.65).contains(&opacity);
        assert!(is_half || 0.04 < (outside - 0.5).abs(), "{outside}: {opacity}");
        last = opacity;
    }
    // The same wall from its edge: a line, and nothing where the volume begins or ends.
    let from_aside = Phantom { from: [DVec3::X, DVec3::Y], ..phantom };
    let image = render("cpu", &from_aside.scene(wall, surface, exact_settings()));
    assert!(image.pixels().iter().all(|pixel| pixel[3] == 0.0));
}

/// Voxels whose values lie just on a surface are inside of it, all of them.
#[test]
fn isosurfaces_of_plateaus_are_not_speckled() {
    for_each_seed(1, |mut rng| {
        for (air, matter) in [(0.0, 80.0), (0.1, 0.7), (-1000.0, 0.3)] {
            // A kernel's radius within it, all are of one value.
            let half = 6.0 + 4.0 * rng.f64();
            let cube = |at: DVec3| if at.abs().max_element() < half { matter } else { air };
            let from = [DVec3::from_array([0; 3].map(|_| rng.f64() - 0.5)).normalize(), DVec3::Y];
            for tolerance in [0.0, 0.05] {
                let phantom = Phantom { from, ..Phantom::new([26; 3], 8.0, 24) };
                let settings = exact_settings().tolerance(tolerance);
                let surface = vec![isosurface(matter, 0.5, None)];
                let image = render("cpu", &phantom.scene(cube, surface, settings));
                let is_whole = |pixel: &[f32; 4]| pixel[3] == 0.75;
                let n_whole = image.pixels().iter().filter(|pixel| is_whole(pixel)).count();
                assert_eq!(n_whole, 24 * 24, "{matter} in {air}, {half}, {from:?}, {tolerance}");
            }
        }
    });
}

/// A picture hardly depends on how thick slabs are.
#[test]
fn isosurfaces_do_not_depend_on_slabs() {
    let waves = |at: DVec3| 100.0 + 30.0 * (0.5 * at.x).sin() * (0.4 * at.y).cos() - 6.0 * at.z;
    let picture = |slab_width: f64| -> Image {
        let phantom = Phantom { from: TILTED, ..Phantom::new([32; 3], 4.0, 64) };
        let settings = exact_settings().slab_width(slab_width);
        let mut scene = phantom.scene(waves, vec![isosurface(100.0, 1.0, None)], settings);
        scene.layers[0].shading = Shading::Phong(Phong::default());
        render("cpu", &scene)
    };
    let thin = picture(0.25);
    for (slab_width, most) in [(0.5, 0.01), (1.0, 0.015), (1.5, 0.05)] {
        let image = picture(slab_width);
        let pairs = image.pixels().iter().zip(thin.pixels());
        let mut off: Vec<f32> = pairs.map(|(a, b)| (a[0] - b[0]).abs()).collect();
        off.sort_by(f32::total_cmp);
        // Where one wave hides another, pixels are of either.
        let nearly_all = off[off.len() * 98 / 100];
        println!("w {slab_width}: {nearly_all:.1e}");
        assert!(nearly_all < most, "{slab_width}: {nearly_all}");
    }
}
