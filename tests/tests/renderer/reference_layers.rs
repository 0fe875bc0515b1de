//! The reference renderer's layers and regions (model §§10, 11) against what is known without it.

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{
    Camera, Compositing, Grid, ImageDesc, Layer, Method, Mode, Normalization, Plane, Projection,
    Region, RenderSettings, Samples, Scaling, Scene, Shading, TransferFunction, Volume,
};
use slabsplat_seeds::for_each_seed;
use slabsplat_tests::random_scene::{SceneKind, random_layers, random_scene};
use slabsplat_tests::reference::{
    ReferenceImage, render, render_within_tolerance, undecided_pixels,
};

/// What a sum may be off by that is rounded in another order.
const REORDERED_SUM: f64 = 1e-12;

/// A medium that is the same everywhere in a cube about the world's origin, 24 world units a side, on a grid
/// of such steps: what goes through it loses so much per world unit.
fn medium(step: f64, extinction: f64) -> Layer {
    let steps = DMat3::from_diagonal(DVec3::splat(step));
    let world_from_index = DAffine3::from_mat3_translation(steps, DVec3::splat(-12.0));
    let n_voxels = (24.0 / step).round() as usize + 1;
    let grid = Grid::new([n_voxels; 3], world_from_index).expect("no step is 0");
    let samples = Samples::F64(vec![1.0; grid.n_voxels()]);
    let volume = Volume::new(grid, samples, Scaling::IDENTITY).expect("one sample a voxel");
    // Per voxel step.
    let opacity = -(-extinction * step).exp_m1();
    let transfer = TransferFunction::new(vec![(0.0, [opacity])], vec![(0.0, [0.2, 0.4, 0.8])]);
    Layer::new(volume, transfer.expect("an opacity is from 0 to 1")).shading(Shading::None)
}

/// Looks along −z at the origin, from 40: nine rays, 4 world units apart at the origin.
fn scene(layers: Vec<Layer>, projection: Projection, settings: RenderSettings) -> Scene {
    let camera = Camera::new(40.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, projection);
    Scene::new(layers[0].clone(), camera.expect("up is not forward"))
        .layers(layers)
        .image(ImageDesc::new(3, 3))
        .settings(settings)
}

/// Of a window of 12 world units at the origin.
fn projections() -> [Projection; 2] {
    let fov_y_radians = 2.0 * (6.0_f64 / 40.0).atan();
    [Projection::Orthographic { view_height: 12.0 }, Projection::Perspective { fov_y_radians }]
}

fn behind(normal: DVec3, distance: f64) -> Plane {
    Plane::new(normal, distance).expect("the normal is not zero")
}

/// What lies between two depths before and behind the origin.
fn between(near: f64, far: f64) -> Region {
    Region::new(vec![behind(DVec3::Z, -near), behind(-DVec3::Z, far)])
}

/// `τ` of each pixel.
fn depths_of_light(image: &ReferenceImage) -> Vec<f64> {
    image.pixels.iter().map(|pixel| -(-pixel[3]).ln_1p()).collect()
}

fn assert_same(a: &ReferenceImage, b: &ReferenceImage, tolerance: f64, what: &str) {
    let difference = a.compare_reference(b);
    assert!(difference.max < tolerance, "{what}: {difference:?}");
}

/// Two slabs, each with half of the medium. Of either a region cuts half away, wherever the medium is in it.
#[test]
fn half_a_slab_has_half_the_extinction() {
    let of = |mode: Mode, region| {
        let settings = RenderSettings::default().mode(mode).slab_width(50.0);
        render(&scene(vec![medium(2.0, 0.1).region(region)], projections()[0], settings))
    };
    let whole = of(Mode::Extinction, Region::default());
    let half = of(Mode::Extinction, between(-50.0, 50.0));
    let [of_whole, of_half] = [&whole, &half].map(depths_of_light);
    for (pixel, (a, b)) in of_whole.into_iter().zip(of_half).enumerate() {
        assert!((0.5 * a - b).abs() < REORDERED_SUM, "{a} {b}");
        let [red, _, blue, alpha] = half.pixels[pixel];
        assert!((red - 0.2 * alpha).abs() < REORDERED_SUM, "{:?}", half.pixels[pixel]);
        assert!((blue - 0.8 * alpha).abs() < REORDERED_SUM, "{:?}", half.pixels[pixel]);
    }
    // Elsewhere it is a matter of the middle.
    for mode in [Mode::Separate, Mode::Associated] {
        let whole = of(mode, Region::default());
        assert!(whole.pixels.iter().all(|pixel| 0.5 < pixel[3]), "{mode}");
        assert_eq!(of(mode, between(-51.0, 51.0)), whole, "{mode}");
        let nothing = of(mode, between(-49.0, 49.0));
        assert!(nothing.pixels.iter().all(|pixel| *pixel == [0.0; 4]), "{mode}");
    }
}

/// Light has gone through as much as there is of the medium between the faces of a wedge, on its true ray.
#[test]
fn cut_medium_is_as_long_as_its_ray() {
    let normal = DVec3::new(0.6, -0.4, 0.7).normalize();
    let wedge = Region::new(vec![behind(normal, 3.0), behind(DVec3::NEG_Z, 4.0)]);
    for projection in projections() {
        for (method, slab_width) in [(Method::ImageAligned, 0.9), (Method::PostClassified, 0.9)] {
            let settings = RenderSettings::default().method(method).slab_width(slab_width);
            let layer = medium(1.0, 0.1).region(wedge.clone());
            let image = render(&scene(vec![layer], projection, settings));
            for (pixel, depth_of_light) in depths_of_light(&image).into_iter().enumerate() {
                let [x, y] = [pixel % 3, pixel / 3].map(|at| 4.0 * (at as f64 - 1.0));
                let at_target = DVec3::new(x, -y, 0.0);
                let direction = match projection {
                    Projection::Orthographic { .. } => DVec3::NEG_Z,
                    Projection::Perspective { .. } => (at_target - 40.0 * DVec3::Z) / 40.0,
                };
                // n·(at_target + t·direction) = 3 where it begins; z = −4 where it ends.
                let start = (3.0 - normal.dot(at_target)) / normal.dot(direction);
                // An extinction counts along the view.
                let expected = 0.1 * (4.0 - start);
                // Kernels sum up to nearly 1.
                let error = (depth_of_light / expected - 1.0).abs();
                assert!(
                    error < 0.01,
                    "{projection:?} {method} {pixel}: {depth_of_light} {expected}"
                );
            }
        }
    }
}

/// Of the same medium on two grids, either alone, a half of each and both together.
#[test]
fn coarse_and_fine_grids_of_one_medium() {
    let of = |layers, projection| {
        let settings = RenderSettings::default().slab_width(0.7);
        depths_of_light(&render(&scene(layers, projection, settings)))
    };
    // Grids end a voxel step of their own behind their last voxels; regions end where we say.
    let (slice, normal) = (between(-9.0, 10.0), DVec3::new(1.0, 0.5, 0.4));
    let cut = |layer: &Layer, plane| layer.clone().region(slice.clone().behind(plane));
    let [coarse, fine] = [2.0, 1.0].map(|step| medium(step, 0.03).region(slice.clone()));
    for projection in projections() {
        let [of_coarse, of_fine] =
            [&coarse, &fine].map(|layer| of(vec![layer.clone()], projection));
        let halves = [cut(&coarse, behind(normal, 0.3)), cut(&fine, behind(-normal, -0.3))];
        let halves = of(halves.to_vec(), projection);
        let both = of(vec![coarse.clone(), fine.clone()], projection);
        for pixel in 0..9 {
            let [expected, a, b] = [0.03 * 19.0, of_coarse[pixel], of_fine[pixel]];
            for actual in [a, b, halves[pixel], 0.5 * both[pixel]] {
                let error = (actual / expected - 1.0).abs();
                assert!(error < 0.01, "{projection:?} {pixel}: {actual} {expected}");
            }
        }
    }
}

/// What a region takes its complement brings back, in slabs of any width, cut by whatever planes.
#[test]
fn region_and_complement_are_the_whole() {
    for_each_seed(1, |mut rng| {
        let slabs = |kind: &SceneKind| kind.method == Method::ImageAligned;
        for kind in SceneKind::all().into_iter().filter(slabs).step_by(4) {
            let mut scene = random_scene(&mut rng, &kind);
            (scene.image.width, scene.image.height) = (12, 12);
            let whole = render(&scene);
            // Faces that are lit are no part of the whole.
            let lit = random_layers(&mut rng, &kind).layers.swap_remove(0).region;
            let region = Region::new(lit.planes().to_vec());
            let layer = &scene.layers[0];
            let parts =
                [region.clone(), region.inverted()].map(|region| layer.clone().region(region));
            let parts = render(&scene.layers(parts.to_vec()));
            assert_same(&parts, &whole, REORDERED_SUM, &format!("{kind:?}"));
        }
    });
}

/// The same of densities, of which a picture has one layer: what does not go through either does not go
/// through the whole.
#[test]
fn densities_of_region_and_complement_are_the_whole() {
    for_each_seed(1, |mut rng| {
        let are_extinct = |kind: &SceneKind| {
            kind.method == Method::PostClassified && kind.compositing == Compositing::Extinction
        };
        for kind in SceneKind::all().into_iter().filter(are_extinct).step_by(3) {
            let mut scene = random_layers(&mut rng, &kind);
            (scene.image.width, scene.image.height) = (12, 12);
            scene.image.background = [0.0; 4];
            let mut through = |region: Region| {
                scene.layers[0].region = region;
                let pixels = render(&scene).pixels;
                pixels.into_iter().map(|pixel| 1.0 - pixel[3]).collect::<Vec<f64>>()
            };
            let region = random_layers(&mut rng, &kind).layers[0].region.clone();
            let [all, inside, outside] =
                [Region::default(), region.clone(), region.inverted()].map(&mut through);
            for ((all, inside), outside) in all.into_iter().zip(inside).zip(outside) {
                assert!((inside * outside - all).abs() < REORDERED_SUM, "{kind:?}: {all}");
            }
        }
    });
}

#[test]
fn order_of_layers_has_no_meaning() {
    for_each_seed(1, |mut rng| {
        let slabs = |kind: &SceneKind| kind.method == Method::ImageAligned;
        for kind in SceneKind::all().into_iter().filter(slabs).step_by(9) {
            let mut scene = random_layers(&mut rng, &kind);
            (scene.image.width, scene.image.height) = (12, 12);
            scene.settings.tolerance = 0.02;
            let one = [render(&scene), render_within_tolerance(&scene)];
            scene.layers.reverse();
            let other = [render(&scene), render_within_tolerance(&scene)];
            for (one, other) in one.iter().zip(&other) {
                assert_same(one, other, REORDERED_SUM, &format!("{kind:?}"));
            }
        }
    });
}

/// A layer of which nothing is seen, on the same grid, changes nothing.
#[test]
fn layer_beside_nothing_is_alone() {
    for_each_seed(1, |mut rng| {
        let slabs = |kind: &SceneKind| kind.method == Method::ImageAligned;
        for kind in SceneKind::all().into_iter().filter(slabs).step_by(13) {
            let mut scene = random_scene(&mut rng, &kind);
            (scene.image.width, scene.image.height) = (12, 12);
            let alone = render(&scene);
            let nowhere = scene.layers[0].clone().region(Region::default().inverted());
            scene.layers.insert(0, nowhere);
            assert_same(&render(&scene), &alone, REORDERED_SUM, &format!("{kind:?}"));
        }
    });
}

/// A tolerance is shared out among layers.
#[test]
fn tolerance_is_that_of_all_layers_together() {
    for_each_seed(1, |mut rng| {
        let kind = SceneKind::all().into_iter().find(|kind| {
            kind.compositing == Compositing::Extinction
                && kind.normalization == Normalization::None
                && kind.method == Method::ImageAligned
        });
        let mut scene = random_scene(&mut rng, &kind.expect("it is one of all"));
        let nowhere = scene.layers[0].clone().region(Region::default().inverted());
        let of = |scene: &Scene, tolerance| {
            let settings = scene.settings.clone().tolerance(tolerance);
            render_within_tolerance(&scene.clone().settings(settings))
        };
        let alone = of(&scene, 0.01);
        scene.layers.push(nowhere);
        assert_same(&of(&scene, 0.02), &alone, REORDERED_SUM, "half of twice as much");
    });
}

/// Where planes meet middles of slabs, and where rays lie within them.
#[test]
fn undecided_pixels_by_hand() {
    let check = |mode: Mode, plane, expected: [bool; 3]| {
        let settings = RenderSettings::default().mode(mode).slab_width(2.0);
        for region in [Region::new(vec![plane]), Region::new(vec![plane]).inverted()] {
            let scene =
                scene(vec![medium(1.0, 0.1).region(region)], projections()[0], settings.clone());
            let columns = [expected; 3].concat();
            assert_eq!(undecided_pixels(&scene), columns, "{mode} {plane:?}");
        }
    };
    for &compositing in Compositing::ALL {
        let (mode, jumps) = (compositing.into(), compositing != Compositing::Extinction);
        check(mode, behind(DVec3::Z, 3.0), [jumps; 3]);
        check(mode, behind(DVec3::NEG_Z, 3.000_005), [jumps; 3]);
        check(mode, behind(DVec3::Z, 3.000_02), [false; 3]);
        check(mode, behind(DVec3::Z, 2.0), [false; 3]);
        check(mode, behind(DVec3::X, 4.0), [false, false, true]);
        check(mode, behind(DVec3::X, 3.9), [false; 3]);
    }
}
