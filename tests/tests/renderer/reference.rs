//! The reference renderer against what is known without it: single voxels in closed form, limits,
//! and things that must not change a picture.

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{
    Camera, Compositing, Grid, ImageDesc, KernelName, Layer, Method, Normalization, Projection,
    RenderSettings, Samples, Scaling, Scene, Shading, TransferFunction, Volume,
};
use slabsplat_tests::random_scene::{SceneKind, random_scene};
use slabsplat_tests::reference::{Kernel, ReferenceImage, render};
use std::sync::Arc;

fn scene(volume: &Arc<Volume>, camera: Camera, settings: RenderSettings) -> Scene {
    let transfer =
        TransferFunction::new(vec![(0.0, [0.0]), (1.0, [0.6])], vec![(0.0, [0.2, 0.4, 0.8])])
            .expect("the points rise");
    let layer = Layer::new(volume.clone(), transfer).shading(Shading::None);
    Scene::new(layer, camera).image(ImageDesc::new(21, 21)).settings(settings)
}

fn orthographic(target: DVec3, view_height: f64) -> Camera {
    let projection = Projection::Orthographic { view_height };
    Camera::new(target + DVec3::new(3.0, 4.0, 12.0), target, DVec3::Y, projection)
        .expect("up is not forward")
}

fn volume(dims: [usize; 3], value: impl Fn([usize; 3]) -> f64) -> Arc<Volume> {
    let grid = Grid::with_spacing(dims, [1.0; 3]).expect("no axis is empty");
    let samples = (0..grid.n_voxels()).map(|i| value(grid.voxel_coords(i))).collect();
    let volume = Volume::new(grid, Samples::F64(samples), Scaling::IDENTITY);
    Arc::new(volume.expect("one sample a voxel"))
}

fn wavy() -> Arc<Volume> {
    volume([6, 5, 7], |[i, j, k]| 0.5 + 0.5 * (i as f64 + 1.7 * j as f64 - 0.6 * k as f64).sin())
}

fn settings(method: Method, compositing: Compositing) -> RenderSettings {
    RenderSettings::default().method(method).mode(compositing.into())
}

fn assert_same(a: &ReferenceImage, b: &ReferenceImage, tolerance: f64) {
    let difference = a.compare_reference(b);
    assert!(difference.max < tolerance, "{difference:?}");
}

/// A whole Gaussian footprint, worked out with the error function's series instead of quadrature.
#[test]
fn render_single_voxel_in_closed_form() {
    let volume = volume([1; 3], |_| 1.0);
    for method in [Method::AxisAligned, Method::EverySample] {
        let settings = settings(method, Compositing::Extinction);
        let scene = scene(&volume, orthographic(DVec3::ZERO, 5.25), settings);
        let image = render(&scene);
        for (x, y) in [(10, 10), (12, 10), (10, 5), (13, 14), (0, 0)] {
            let rho = 0.25 * f64::from(x - 10_i32).hypot(f64::from(y - 10_i32));
            let tau = -0.4_f64.ln() * gaussian_footprint(rho);
            let opacity = 1.0 - (-tau).exp();
            let pixel = image.pixel(x as u32, y as u32);
            for (channel, color) in pixel.into_iter().zip([0.2, 0.4, 0.8, 1.0]) {
                assert!((channel - color * opacity).abs() < 1e-12, "({x}, {y}): {pixel:?}");
            }
        }
    }
}

/// `∫ c·2^(−2(ρ²+t²)) dt` over `t² < 4 − ρ²`, term by term.
fn gaussian_footprint(rho: f64) -> f64 {
    if 2.0 <= rho {
        return 0.0;
    }
    let (half, a) = ((4.0 - rho * rho).sqrt(), 4.0_f64.ln());
    let mut term = half;
    let mut sum = 0.0;
    for n in 0..80 {
        sum += term / f64::from(2 * n + 1);
        term *= -a * half * half / f64::from(n + 1);
    }
    2.0 * Kernel::Gaussian.at(rho) * sum
}

#[test]
fn render_nothing_but_background() {
    let volume = volume([3; 3], |_| 0.0);
    for &method in Method::ALL {
        let settings = settings(method, Compositing::Separate);
        let mut scene = scene(&volume, orthographic(DVec3::ONE, 6.0), settings);
        scene.image.background = [0.5, 0.25, 1.0, 0.5];
        assert!(render(&scene).pixels.iter().all(|p| *p == [0.25, 0.125, 0.5, 0.5]));
    }
}

/// model §3: two thin slabs composited have exactly the opacity of one thick one, so in `extinction`
/// the opacity of a picture does not depend on the slab width, nor on the method.
#[test]
fn render_extinction_opacity_is_additive() {
    let volume = wavy();
    let of = |method, slab_width| {
        let settings = settings(method, Compositing::Extinction).slab_width(slab_width);
        render(&scene(&volume, orthographic(DVec3::new(2.5, 2.0, 3.0), 9.0), settings))
    };
    let thin = of(Method::ImageAligned, 0.3);
    let others = [
        of(Method::ImageAligned, 2.0),
        of(Method::ImageAligned, 20.0),
        of(Method::AxisAligned, 1.0),
        of(Method::EverySample, 1.0),
    ];
    for other in others {
        for (a, b) in thin.pixels.iter().zip(&other.pixels) {
            assert!((a[3] - b[3]).abs() < 1e-9, "{a:?} {b:?}");
            // One colour throughout: it is the opacity's fixed share.
            assert!((b[2] - 0.8 * b[3]).abs() < 1e-9, "{b:?}");
        }
    }
}

#[test]
fn render_perspective_from_afar_is_orthographic() {
    let volume = wavy();
    let target = volume.grid().center_in_world();
    let direction = DVec3::new(0.3, 0.4, 1.2).normalize();
    for &method in Method::ALL {
        let settings = settings(method, Compositing::Separate);
        let distance = 1e6;
        let fov_y_radians = 2.0 * (4.5_f64 / distance).atan();
        let perspective = Camera::new(
            target + distance * direction,
            target,
            DVec3::Y,
            Projection::Perspective { fov_y_radians },
        );
        let near = orthographic(target, 9.0);
        let far = render(&scene(&volume, perspective.unwrap(), settings.clone()));
        assert_same(&far, &render(&scene(&volume, near, settings)), 2e-5);
    }
}

/// Storing the voxels in another order, with the matrix to match, is the same volume.
#[test]
fn render_does_not_depend_on_storage() {
    let wavy = wavy();
    let [nx, ny, nz] = wavy.grid().dims();
    // Axes (k, −i, j): a turn, by the matrix.
    let matrix = DMat3::from_cols(DVec3::Z, DVec3::NEG_X, DVec3::Y);
    let origin = DVec3::new(nx as f64 - 1.0, 0.0, 0.0);
    let grid = Grid::new([nz, nx, ny], DAffine3::from_mat3_translation(matrix, origin)).unwrap();
    let value = |i: usize| {
        let [a, b, c] = grid.voxel_coords(i);
        wavy.value(wavy.grid().voxel_idx([nx - 1 - b, c, a]))
    };
    let samples = Samples::F64((0..grid.n_voxels()).map(value).collect());
    let turned = Arc::new(Volume::new(grid, samples, Scaling::IDENTITY).unwrap());
    for &method in Method::ALL {
        let camera = orthographic(wavy.grid().center_in_world(), 9.0);
        let settings = settings(method, Compositing::Separate);
        let [a, b] =
            [&wavy, &turned].map(|volume| render(&scene(volume, camera, settings.clone())));
        assert_same(&a, &b, 1e-9);
    }
}

/// A world in other units looks the same.
#[test]
fn render_does_not_depend_on_world_unit() {
    let small = wavy();
    let grid = Grid::with_spacing(small.grid().dims(), [7.0; 3]).unwrap();
    let large = Arc::new(Volume::clone(&small).with_grid(grid).unwrap());
    for &method in Method::ALL {
        let settings = settings(method, Compositing::Extinction).slab_width(0.8);
        let center = small.grid().center_in_world();
        let a = render(&scene(&small, orthographic(center, 9.0), settings.clone()));
        let eye = 7.0 * (center + DVec3::new(3.0, 4.0, 12.0));
        let projection = Projection::Orthographic { view_height: 63.0 };
        let camera = Camera::new(eye, 7.0 * center, DVec3::Y, projection).unwrap();
        assert_same(&a, &render(&scene(&large, camera, settings)), 1e-9);
    }
}

/// model §5: a volume shrunk to a few pixels keeps its sum, wherever between the pixels it lies.
#[test]
fn render_minified_volume_keeps_its_sum() {
    let volume = wavy();
    let center = volume.grid().center_in_world();
    let sum_at = |shift: f64, view_height: f64| -> f64 {
        let camera = orthographic(center + DVec3::Y * shift, view_height);
        let settings = settings(Method::ImageAligned, Compositing::Extinction);
        let mut scene = scene(&volume, camera, settings);
        // Thin as mist, so that the sum is linear in what is there.
        scene.layers[0].transfer =
            TransferFunction::new(vec![(0.0, [0.0]), (1.0, [1e-6])], vec![(0.0, [1.0; 3])])
                .unwrap();
        let pixel_area = (view_height / 21.0).powi(2);
        render(&scene).pixels.iter().map(|p| p[3] * pixel_area).sum()
    };
    let full = sum_at(0.0, 16.0);
    for shift in [0.0, 0.9, 1.7, 3.1] {
        let small = sum_at(shift, 84.0);
        assert!((small / full - 1.0).abs() < 0.02, "shift {shift}: {small} {full}");
    }
}

/// NaN voxels are not there; infinite ones take the ends of the transfer function.
#[test]
fn render_odd_values() {
    let with = |odd: f64| volume([3, 1, 1], move |[i, _, _]| [0.5, odd, 0.5][i]);
    let settings = settings(Method::ImageAligned, Compositing::Associated);
    let image = |odd| render(&scene(&with(odd), orthographic(DVec3::X, 5.0), settings.clone()));
    assert_same(&image(f64::NAN), &image(0.0), 1e-15);
    assert_same(&image(f64::INFINITY), &image(1.0), 1e-15);
    assert_same(&image(f64::NEG_INFINITY), &image(0.0), 1e-15);
}

/// A plain footprint turned into slabs of the hierarchy's base is left alone by normalisation.
#[test]
fn render_normalization_spares_the_base() {
    let volume = wavy();
    let of = |normalization| {
        let settings = settings(Method::ImageAligned, Compositing::Separate)
            .normalization(normalization)
            .slab_width(0.5)
            .kernel(KernelName("crawfis-max".into()));
        render(&scene(&volume, orthographic(DVec3::ONE, 9.0), settings))
    };
    assert_eq!(of(Normalization::None), of(Normalization::Product));
}

/// One scene of each kind: a number in every pixel, and no colour brighter than its opacity.
#[test]
fn render_random_scenes_are_sane() {
    let mut rng = fastrand::Rng::with_seed(7);
    let mut n_visible = 0;
    let kinds = SceneKind::all();
    for kind in &kinds {
        let scene = random_scene(&mut rng, kind);
        let image = render(&scene);
        for pixel in &image.pixels {
            let [r, g, b, a] = *pixel;
            assert!((0.0..=1.0 + 1e-12).contains(&a), "{kind:?}: {pixel:?}");
            for c in [r, g, b] {
                assert!(-1e-12 <= c && c <= a + 1e-9, "{kind:?}: {pixel:?}");
            }
        }
        n_visible += usize::from(image.pixels.iter().any(|p| *p != image.pixels[0]));
    }
    assert!(9 * kinds.len() < 10 * n_visible, "{n_visible} of {} show anything", kinds.len());
}
