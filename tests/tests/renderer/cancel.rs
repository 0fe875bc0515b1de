//! Frames that are cancelled at any moment: whatever a renderer was doing then, its next frame has the bits
//! of a fresh one, and a frame that was not cancelled in time is as good as any.

use fastrand::Rng;
use slabsplat::kernel::Gaussian;
use slabsplat::{Automatic, Kernel, KernelName, Normalization, io};
use slabsplat::{
    FrameHandle, Image, ImageDesc, Isosurface, Method, Mode, RenderError, RenderSettings,
    RenderThread, Renderer, Scene,
};
use slabsplat_seeds::for_each_seed;
use slabsplat_tests::random_scene::{
    SceneKind, random_layers, random_meshes, random_scene, random_several_layers,
};
use slabsplat_tests::render::{backends, open, render};
use std::hint::spin_loop;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Frames of a renderer. With every one something else is to be made anew, and cancelled on the way.
const N_BY_CPU: usize = 12;

/// The same of one on a GPU, which may be software.
const N_BY_GPU: usize = 2;

#[test]
fn next_frame_has_the_bits_of_a_fresh_renderer() {
    let (mut n_cancelled, mut n_drawn) = (0, 0);
    for_each_seed(1, |mut rng| {
        for &name in backends() {
            let mut renderer = Renderer::new(open(name));
            let n_frames = if name == "cpu" { N_BY_CPU } else { N_BY_GPU };
            for frame_idx in 0..n_frames {
                let scene = any_scene(&mut rng, name);
                let expected = render(name, &scene);
                for _ in 0..rng.usize(0..3) {
                    match render_and_cancel(&mut rng, &mut renderer, &scene) {
                        Ok(image) => {
                            assert!(image == expected, "{name}, frame {frame_idx}, not in time");
                            n_drawn += 1;
                        }
                        Err(error) => {
                            assert!(error.is_cancelled(), "{error}");
                            n_cancelled += 1;
                        }
                    }
                }
                let image = renderer.render(&scene).expect("the scene is valid").image;
                assert!(image == expected, "{name}, frame {frame_idx}");
            }
        }
    });
    println!("{n_cancelled} frames cancelled, {n_drawn} drawn before they were");
    assert!(0 < n_cancelled, "{n_drawn} frames were drawn");
}

/// Tables are made of a kernel, and this one cancels the frame while they are: nothing that is made after
/// that is made of it, and the next frame begins anew.
#[test]
fn first_frame_stops_while_tables_are_made() {
    let volume = io::builtin_volume("sphere", Some(12)).expect("the name is listed");
    let image = ImageDesc::new(24, 24);
    let normalized =
        RenderSettings::default().normalization(Normalization::Product).slab_width(4.0);
    let post_classified = RenderSettings::default().method(Method::PostClassified);
    for settings in [RenderSettings::default(), normalized, post_classified] {
        let mut scene = Automatic::new(volume.clone()).scene(image, settings);
        scene.settings.kernel = KernelName("cancelling".into());
        let kernel = Arc::new(Cancelling::default());
        let mut renderer = Renderer::new(open("cpu"));
        renderer.add_kernel(kernel.clone()).expect("it is a kernel");
        kernel.cancel_at(usize::MAX, &FrameHandle::new());
        let expected = renderer.render(&scene).expect("nobody cancels").image;
        let n_in_all = kernel.n_integrals();
        for at_integral in [1, n_in_all / 3, n_in_all - 1] {
            let mut renderer = Renderer::new(open("cpu"));
            renderer.add_kernel(kernel.clone()).expect("it is a kernel");
            let frame = FrameHandle::new();
            kernel.cancel_at(at_integral, &frame);
            let error = renderer.render_as(&scene, &frame).expect_err("it is cancelled");
            assert!(error.is_cancelled(), "{error}");
            let n_more = kernel.n_integrals() - at_integral;
            assert!(n_more <= MOST_INTEGRALS_AT_ONCE, "{n_more} after {at_integral} of {n_in_all}");
            let image = renderer.render(&scene).expect("nobody cancels").image;
            assert!(image == expected, "after {at_integral} of {n_in_all}");
        }
    }
}

/// Integrals that a frame may go on with: a row of cubics, or what it takes to look whether a kernel is a
/// product. Tables have tens of thousands.
const MOST_INTEGRALS_AT_ONCE: usize = 1500;

/// A Gaussian that cancels a frame when it is asked for its so-manieth integral since it was told to.
#[derive(Debug, Default)]
struct Cancelling {
    n_integrals: AtomicUsize,
    cancels: Mutex<Option<(usize, FrameHandle)>>,
}

impl Cancelling {
    fn n_integrals(&self) -> usize {
        self.n_integrals.load(Ordering::Relaxed)
    }

    fn cancel_at(&self, at_integral: usize, frame: &FrameHandle) {
        self.n_integrals.store(0, Ordering::Relaxed);
        *self.cancels.lock().expect("nothing panics") = Some((at_integral, frame.clone()));
    }
}

impl Kernel for Cancelling {
    fn name(&self) -> &str {
        "cancelling"
    }

    fn radius(&self) -> f64 {
        Gaussian.radius()
    }

    fn value(&self, r: f64) -> f64 {
        Gaussian.value(r)
    }

    fn line_integral(&self, rho: f64, a: f64, b: f64) -> f64 {
        let nth = self.n_integrals.fetch_add(1, Ordering::Relaxed);
        let mut cancels = self.cancels.lock().expect("nothing panics");
        if let Some((_, frame)) = cancels.take_if(|(at_integral, _)| *at_integral <= nth) {
            frame.cancel();
        }
        Gaussian.line_integral(rho, a, b)
    }
}

/// Frames that follow each other on a thread: those that somebody waits for are the right ones.
#[test]
fn frames_on_a_thread_are_the_right_ones() {
    for_each_seed(1, |mut rng| {
        let thread =
            RenderThread::spawn(Renderer::new(open("cpu"))).expect("threads can be started");
        let (mut pending, mut last_newest) = (Vec::new(), None);
        for nth in 0..30 {
            let scene = any_scene(&mut rng, "cpu");
            let is_newest = rng.bool();
            let frame =
                if is_newest { thread.submit_newest(&scene) } else { thread.submit(&scene) };
            if is_newest {
                last_newest = Some(nth);
            }
            match rng.u8(..4) {
                0 => drop(frame),
                1 => frame.cancel(),
                _ => pending.push((nth, frame, is_newest, scene)),
            }
            for _ in 0..rng.u32(..200_000) {
                spin_loop();
            }
        }
        for (nth, frame, is_newest, scene) in pending {
            match frame.wait() {
                Ok(frame) => assert!(frame.image == render("cpu", &scene), "frame {nth}"),
                Err(error) => {
                    let may_be_replaced = is_newest && Some(nth) != last_newest;
                    assert!(error.is_cancelled() && may_be_replaced, "{error}: frame {nth}");
                }
            }
        }
    });
}

/// Renders a frame that is cancelled before it has begun, after it is done, or in between.
fn render_and_cancel(
    rng: &mut Rng,
    renderer: &mut Renderer,
    scene: &Scene,
) -> Result<Image, RenderError> {
    let frame = FrameHandle::new();
    let after = Duration::from_micros(10_u64.pow(rng.u32(..4)) * rng.u64(..10));
    thread::scope(|scope| {
        scope.spawn(|| {
            let start = Instant::now();
            while start.elapsed() < after {
                spin_loop();
            }
            frame.cancel();
        });
        renderer.render_as(scene, &frame).map(|frame| frame.image)
    })
}

/// A scene of any kind that a backend has, small or a little larger.
fn any_scene(rng: &mut Rng, backend: &str) -> Scene {
    let kinds = SceneKind::all();
    let kind = &kinds[rng.usize(..kinds.len())];
    let is_slabs = kind.method == Method::ImageAligned;
    let has_regions = is_slabs || kind.method == Method::PostClassified;
    let mut scene = match rng.u8(..4) {
        0 if backend == "cpu" => builtin(rng, kind.method),
        1 if is_slabs => random_meshes(rng, kind),
        2 if is_slabs => random_several_layers(rng, kind),
        _ if has_regions => random_layers(rng, kind),
        _ => random_scene(rng, kind),
    };
    // Of densities a GPU has not all that the CPU has.
    if backend == "cpu"
        && scene.meshes.is_empty()
        && scene.settings.method == Method::PostClassified
    {
        scene.settings.mode = Mode::ALL[rng.usize(..Mode::ALL.len())];
        if scene.settings.mode == Mode::Isosurfaces {
            let surface = Isosurface::new(0.5, 0.5, None).expect("it is half opaque");
            scene.layers[0].isosurfaces = vec![surface];
        }
    }
    scene
}

/// 48 voxels a side, so that lists, tosses and ranges of slabs are of several tasks.
fn builtin(rng: &mut Rng, method: Method) -> Scene {
    let name = ["neuron", "marschner-lobb", "shepp-logan"][rng.usize(..3)];
    let volume = io::builtin_volume(name, Some(48)).expect("the name is listed");
    let image = ImageDesc::new(rng.u32(8..200), rng.u32(8..200));
    let mut scene = Automatic::new(volume).scene(image, RenderSettings::default().method(method));
    scene.camera = scene.camera.orbited(6.0 * rng.f64());
    scene
}
