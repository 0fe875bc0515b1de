//! What a GPU backend leaves out since it was hidden in the frame before: never anything that is seen.

use slabsplat::{Camera, Frame, Method, Plane, Projection, Region, Scene, TransferFunction};
use slabsplat_seeds::for_each_numbered_seed;
use slabsplat_tests::on_devices::{
    alone, as_it_is, in_rounds, layered_scene, on_a_device, on_devices, render, scene, submit,
    take, transfer, volume,
};
use std::cell::{Cell, RefCell};

/// Methods whose tiles have sheets that are saturated.
const METHODS: [Method; 3] = [Method::ImageAligned, Method::AxisAligned, Method::PostClassified];

/// An opaque ball, which is larger than the picture.
fn opaque(method: Method) -> Scene {
    // Mesa's software driver draws densities at a tenth of the speed of colours.
    let is_slow = method == Method::PostClassified;
    let (dims, width, larger) =
        if is_slow { ([14, 12, 16], 32, 3.0) } else { ([30, 26, 34], 96, 1.6) };
    let scene = scene(&volume(dims), width, method);
    let mut scene = magnified(&scene, larger);
    let opacities = vec![(0.3, [0.0]), (0.35, [1.0])];
    let colors = vec![(0.0, [1.0, 0.3, 0.1]), (1.0, [0.2, 0.9, 1.0])];
    let transfer = TransferFunction::new(opacities, colors);
    scene.layers[0].transfer = transfer.expect("points are sorted");
    scene
}

fn turned(scene: &Scene, by: f64) -> Scene {
    let mut scene = scene.clone();
    scene.camera = scene.camera.orbited(by);
    scene
}

fn magnified(scene: &Scene, by: f64) -> Scene {
    let mut scene = scene.clone();
    scene.camera = scene.camera.magnified(by).expect("it is finite");
    scene
}

/// All scenes by one backend, one after the other, on every device: each has the bits and the counts that it
/// has when it is drawn alone. Gives how many splats each left out on the last device.
fn check(what: &str, scenes: &[Scene]) -> Vec<u64> {
    let alone = one_by_one(scenes);
    let (number, n_hidden) = (Cell::new(0), RefCell::new(Vec::new()));
    on_devices(in_rounds, |name, backend, _| {
        let expected = alone.iter().map(|frames| &frames[number.get()]);
        let hidden = scenes.iter().zip(expected).enumerate().map(|(n, (scene, expected))| {
            let frame = render(backend, scene).expect("it can be drawn");
            assert_same(&format!("{name}, {what}, frame {n}"), &frame, expected);
            frame.cost.n_hidden
        });
        n_hidden.replace(hidden.collect());
        number.set(number.get() + 1);
    });
    n_hidden.into_inner()
}

/// Each scene by a backend of its own, on every device.
fn one_by_one(scenes: &[Scene]) -> Vec<Vec<Frame>> {
    let of = |scene: &Scene| {
        let frames = RefCell::new(Vec::new());
        on_devices(as_it_is, |_, backend, _| {
            frames.borrow_mut().push(render(backend, scene).expect("it can be drawn"));
        });
        frames.into_inner()
    };
    scenes.iter().map(of).collect()
}

fn assert_same(what: &str, frame: &Frame, expected: &Frame) {
    assert_eq!(frame.stats, expected.stats, "{what}");
    assert!(frame.image == expected.image, "{what}");
}

#[test]
fn a_turn_leaves_out_what_is_hidden() {
    let _alone = alone();
    for method in METHODS {
        let scenes: Vec<Scene> =
            (0..3).map(|n| turned(&opaque(method), 0.02 * f64::from(n))).collect();
        let n_hidden = check(method.name(), &scenes);
        if let [first, others @ ..] = &n_hidden[..] {
            assert_eq!(*first, 0, "{method}: there was no frame before");
            assert!(others.iter().all(|n| 0 < *n), "{method}: {n_hidden:?}");
        }
    }
}

/// Everything that a next frame can be but like the last one.
#[test]
fn frames_that_are_nothing_like_the_last_one() {
    let _alone = alone();
    let ball = opaque(Method::ImageAligned);
    let mut faint = ball.clone();
    faint.layers[0].transfer = transfer(0.1);
    let mut cut = ball.clone();
    let center = ball.layers[0].volume.grid().center_in_world();
    let normal = -ball.camera.axes().forward;
    let plane = Plane::new(normal, normal.dot(center)).expect("it is not zero");
    cut.layers[0].region = Region::new(vec![plane]);
    let mut wide = ball.clone();
    wide.image.width += 24;
    let (near, far, behind) = (magnified(&ball, 3.0), magnified(&ball, 0.3), turned(&ball, 3.0));
    let scenes = [&ball, &faint, &ball, &cut, &wide, &near, &far, &behind].map(Scene::clone);
    check("scenes in turn", &scenes);

    let ball = opaque(Method::AxisAligned);
    check("slices", &[ball.clone(), turned(&ball, 1.2), magnified(&ball, 0.5), ball]);
}

/// Frames under way at a time, of which each follows one whose counts nobody has seen yet.
#[test]
fn frames_under_way_follow_each_other() {
    let _alone = alone();
    let ball = opaque(Method::ImageAligned);
    let scenes = [0.0, 0.02, 2.0, 2.02, 0.1].map(|angle| turned(&ball, angle));
    let alone = one_by_one(&scenes);
    let number = Cell::new(0);
    on_devices(as_it_is, |name, backend, _| {
        let frames =
            scenes.each_ref().map(|scene| submit(backend, scene).expect("it can be drawn"));
        for (n, (frame, expected)) in frames.iter().zip(&alone).enumerate() {
            let frame = take(backend, frame).expect("it is drawn");
            assert_same(&format!("{name}, frame {n}"), &frame, &expected[number.get()]);
        }
        number.set(number.get() + 1);
    });
}

/// Cameras that jump a little or far, in and out: the bits are those of a backend that has no last frame.
#[test]
fn random_walks_have_the_bits_of_single_frames() {
    let _alone = alone();
    for_each_numbered_seed(4, |seed, mut rng| {
        let mut scene = opaque(METHODS[rng.usize(..2)]);
        if scene.settings.method == Method::ImageAligned && rng.bool() {
            scene.layers.push(
                layered_scene([&volume([9, 12, 8]), &volume([20, 18, 22])], 8).layers.remove(1),
            );
        }
        if rng.bool() {
            let projection = Projection::Perspective { fov_y_radians: 0.5 };
            let camera = scene.camera;
            let eye = camera.target() + 1.5 * (camera.eye() - camera.target());
            scene.camera =
                Camera::new(eye, camera.target(), camera.up(), projection).expect("it stays apart");
        }
        let mut scenes = vec![scene.clone()];
        for _ in 0..4 {
            let angle = if rng.bool() { 0.03 } else { 0.6 } * rng.f64();
            scene = magnified(&turned(&scene, angle), 0.9 + 0.3 * rng.f64());
            scenes.push(scene.clone());
        }
        on_a_device(seed as usize, as_it_is, |name, backend, _| {
            for (n, scene) in scenes.iter().enumerate() {
                let frame = render(backend, scene).expect("it can be drawn");
                on_a_device(seed as usize, as_it_is, |_, alone, _| {
                    let expected = render(alone, scene).expect("it can be drawn");
                    assert_same(&format!("{name}, seed {seed}, frame {n}"), &frame, &expected);
                });
            }
        });
    });
}
