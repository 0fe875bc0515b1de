//! Pictures that stay on the device: in textures of a caller's, on a device of a caller's.

use slabsplat::glam::DVec3;
use slabsplat::{
    Backend, BackendError, Camera, FrameHandle, Isosurface, Layer, Lookup, Mesh, MeshLayer,
    MeshParts, Method, Mode, Planner, Projection, RenderError, Renderer, Scene, TargetError,
    TextureRenderer, TextureTarget, wgpu,
};
use slabsplat_gpu::{Destination, Device, DeviceError, GpuBackend, Picture, Work};
use slabsplat_tests::caller::Caller;
use slabsplat_tests::on_devices::{
    alone, layered_scene, scene, stretched, transfer, volume, with_host_list,
};
use slabsplat_tests::render::{devices, validation_messages};
use slabsplat_tests::spy_device::{SpyDevice, locked};
use std::sync::{Arc, Mutex};
use std::task::Poll;
use std::time::Duration;

const FLOATS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Widths that are no multiple of a tile, of 64 pixels, or of anything.
const WIDTHS: [u32; 4] = [37, 64, 1, 131];

/// Something of everything that a picture can be made of.
fn scenes() -> Vec<(String, Scene)> {
    let small = volume([9, 8, 7]);
    let by_method =
        Method::ALL.iter().map(|&method| (method.to_string(), scene(&small, 0, method)));
    let mut scenes: Vec<_> = by_method.collect();
    for &mode in Mode::ALL {
        let mut scene = scene(&small, 0, Method::PostClassified);
        scene.settings.mode = mode;
        if mode == Mode::Isosurfaces {
            scene.layers[0].isosurfaces = vec![Isosurface::new(0.4, 0.8, None).expect("it is one")];
        }
        scenes.push((mode.to_string(), scene));
    }
    let layers = layered_scene([&small, &stretched(&small, 0.7)], 0);
    scenes.push(("layers, listed by the host".to_owned(), with_host_list(layers)));
    let mut invisible = scene(&small, 0, Method::ImageAligned);
    invisible.layers[0].transfer = transfer(0.0);
    scenes.push(("nothing".to_owned(), invisible));
    let mut mesh = scene(&small, 0, Method::ImageAligned);
    mesh.meshes = vec![MeshLayer::new(triangle(mesh.camera.target()))];
    scenes.push(("a mesh".to_owned(), mesh));
    for ((_, scene), width) in scenes.iter_mut().zip(WIDTHS.into_iter().cycle()) {
        [scene.image.width, scene.image.height] = [width, width / 2 + 20];
    }
    scenes
}

fn triangle(center: DVec3) -> Mesh {
    let positions = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| center + 3.0 * axis).to_vec();
    let parts = MeshParts::new(positions).triangles(vec![[0, 1, 2]]);
    Mesh::new(parts).expect("it is one")
}

fn size_of(scene: &Scene) -> [u32; 2] {
    [scene.image.width, scene.image.height]
}

fn target(caller: &Caller, scene: &Scene, format: wgpu::TextureFormat) -> TextureTarget {
    TextureTarget::new(&caller.texture(size_of(scene), format)).expect("it has such a format")
}

/// Two renderers on one device: one reads back, the other leaves pictures there. They are one picture.
#[test]
fn textures_hold_what_is_rendered() {
    let _alone = alone();
    let Some(caller) = Caller::new() else { return };
    let mut reading = Renderer::on_wgpu(&caller.device, &caller.queue).expect("it was asked for");
    let mut leaving = TextureRenderer::on(&caller.device, &caller.queue).expect("likewise");
    for (what, scene) in scenes() {
        let expected = reading.render(&scene).expect("the scene is valid");
        let target = target(&caller, &scene, FLOATS);
        let drawn = leaving.render(&scene, &target).expect("the scene is valid");
        assert_eq!(drawn.stats, expected.stats, "{what}");
        assert!(caller.read_floats(target.texture()) == expected.image.pixels(), "{what}");
    }
    assert_eq!(caller.n_errors(), 0);
    assert_eq!(validation_messages(), Vec::<String>::new());
}

#[test]
fn textures_hold_the_cpus_pictures() {
    let _alone = alone();
    let Some(caller) = Caller::new() else { return };
    let mut reading = Renderer::open("cpu", |_| ()).expect("there is always one");
    let mut leaving = TextureRenderer::on_cpu(&caller.queue).expect("likewise");
    assert_eq!(leaving.caps().name, "cpu");
    for (what, scene) in scenes() {
        let expected = reading.render(&scene).expect("the scene is valid");
        let target = target(&caller, &scene, FLOATS);
        let drawn = leaving.render(&scene, &target).expect("the scene is valid");
        assert_eq!(drawn.stats, expected.stats, "{what}");
        assert!(caller.read_floats(target.texture()) == expected.image.pixels(), "{what}");
    }
    assert_eq!(caller.n_errors(), 0);
}

/// Formats of windows have the bytes of the picture's file, as the pixels are opaque.
#[test]
fn every_format_shows_the_same() {
    let _alone = alone();
    let Some(caller) = Caller::new() else { return };
    let mut opaque = scene(&volume([9, 8, 7]), 51, Method::ImageAligned);
    opaque.image.background = [0.0, 0.5, 1.0, 1.0];
    let mut translucent = opaque.clone();
    translucent.image.background = [0.0; 4];
    let on_gpu = TextureRenderer::on(&caller.device, &caller.queue).expect("it was asked for");
    let on_cpu = TextureRenderer::on_cpu(&caller.queue).expect("there is always one");
    for mut renderer in [on_gpu, on_cpu] {
        let name = renderer.caps().name;
        for scene in [&opaque, &translucent] {
            let image = Renderer::open("cpu", |_| ()).expect("it is there").render(scene);
            let image = image.expect("the scene is valid").image;
            let premultiplied: Vec<u8> = image
                .pixels()
                .as_flattened()
                .iter()
                .map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8)
                .collect();
            if scene.image.background[3] == 1.0 {
                assert_eq!(image.to_rgba8(), premultiplied);
            }
            for format in TextureTarget::FORMATS {
                let target = target(&caller, scene, format);
                renderer.render(scene, &target).expect("the scene is valid");
                let shown = as_bytes(format, &caller.read(target.texture()));
                let worst = shown.iter().zip(&premultiplied).map(|(a, b)| a.abs_diff(*b)).max();
                assert!(worst <= Some(1), "{name}, {format:?}: {worst:?}");
            }
        }
    }
    assert_eq!(caller.n_errors(), 0);
}

/// What is in a texture, as bytes of red, green, blue and opacity.
fn as_bytes(format: wgpu::TextureFormat, bytes: &[u8]) -> Vec<u8> {
    let to_byte = |value: f32| (value * 255.0).round() as u8;
    match format {
        wgpu::TextureFormat::Rgba16Float => {
            let half = |&bytes: &[u8; 2]| to_byte(from_half(u16::from_ne_bytes(bytes)));
            bytes.as_chunks::<2>().0.iter().map(half).collect()
        }
        FLOATS => {
            let float = |&bytes: &[u8; 4]| to_byte(f32::from_ne_bytes(bytes));
            bytes.as_chunks::<4>().0.iter().map(float).collect()
        }
        wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Bgra8UnormSrgb => {
            bytes.as_chunks::<4>().0.iter().flat_map(|&[b, g, r, a]| [r, g, b, a]).collect()
        }
        _ => bytes.to_vec(),
    }
}

/// A number from 0 on.
fn from_half(bits: u16) -> f32 {
    let fraction = f32::from(bits & 0x3ff) / 1024.0;
    match bits >> 10 {
        0 => fraction * 2.0_f32.powi(-14),
        exponent => (1.0 + fraction) * 2.0_f32.powi(i32::from(exponent) - 15),
    }
}

/// The caller's commands come right after the frame's, in one queue, and see the picture; nobody polls.
#[test]
fn caller_sees_the_picture_without_waiting() {
    let _alone = alone();
    let Some(caller) = Caller::new() else { return };
    let renderer = TextureRenderer::on(&caller.device, &caller.queue).expect("it was asked for");
    let mut renderer = for_any_thread(renderer);
    let mut scene = scene(&volume([9, 8, 7]), 51, Method::ImageAligned);
    let target = for_any_thread(target(&caller, &scene, FLOATS));
    let own = caller.texture([16, 16], wgpu::TextureFormat::Rgba8Unorm);
    renderer.render(&scene, &target).expect("the scene is valid");
    for turn in 1..4 {
        scene.camera = scene.camera.orbited(0.2);
        let frame = renderer.submit(&scene, &target).expect("the scene is valid");
        caller.queue.write_texture(
            own.as_image_copy(),
            &[turn; 1024],
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(64),
                rows_per_image: None,
            },
            own.size(),
        );
        let shown = caller.read_floats(target.texture());
        assert_eq!(caller.read(&own), [turn; 1024]);
        let mut reading = Renderer::on_wgpu(&caller.device, &caller.queue).expect("it is there");
        let expected = reading.render(&scene).expect("the scene is valid").image;
        assert!(shown == expected.pixels(), "turn {turn}");
        renderer.wait(&frame).expect("it is drawn");
    }
    assert_eq!(caller.n_errors(), 0);
}

fn for_any_thread<T: Send>(value: T) -> T {
    value
}

/// Frames that need room are drawn again. What is shown at last is the last one, and never half of one.
#[test]
fn frames_that_need_room_keep_their_order() {
    let _alone = alone();
    let Some(caller) = Caller::new() else { return };
    let close_up = close_up(200);
    let mut whole = scene(&volume([9, 8, 7]), 200, Method::ImageAligned);
    whole.image = close_up.image;
    let target = target(&caller, &whole, FLOATS);
    let mut reading = Renderer::on_wgpu(&caller.device, &caller.queue).expect("it was asked for");
    let [near, far] =
        [&close_up, &whole].map(|scene| reading.render(scene).expect("it is valid").image);
    let new = || TextureRenderer::on(&caller.device, &caller.queue).expect("it was asked for");

    let mut renderer = new();
    let frame = renderer.submit(&close_up, &target).expect("it is valid");
    let early = caller.read_floats(target.texture());
    assert!(early.iter().all(|pixel| *pixel == [0.0; 4]), "there was no room, so nothing is shown");
    renderer.wait(&frame).expect("there is room");
    assert!(caller.read_floats(target.texture()) == near.pixels());

    let mut renderer = new();
    let frames = [&close_up, &whole].map(|scene| renderer.submit(scene, &target));
    for frame in frames {
        renderer.wait(&frame.expect("it is valid")).expect("there is room");
    }
    assert!(caller.read_floats(target.texture()) == far.pixels(), "the last one stays");
    assert_eq!(caller.n_errors(), 0);
}

/// An eye within the volume.
fn close_up(width: u32) -> Scene {
    let volume = volume([24, 24, 24]);
    let mut scene = scene(&volume, width, Method::EverySample);
    let target = volume.grid().center_in_world();
    let projection = Projection::Perspective { fov_y_radians: 1.9 };
    let eye = target + DVec3::new(3.0, 0.5, 0.2);
    scene.camera = Camera::new(eye, target, DVec3::Y, projection).expect("up is not forward");
    scene
}

#[test]
fn texture_that_does_not_fit_is_an_error() {
    let _alone = alone();
    let Some(caller) = Caller::new() else { return };
    let scene = scene(&volume([4, 4, 4]), 40, Method::ImageAligned);
    let on_gpu = TextureRenderer::on(&caller.device, &caller.queue).expect("it was asked for");
    let on_cpu = TextureRenderer::on_cpu(&caller.queue).expect("there is always one");
    let texture = caller.texture([40, 31], FLOATS);
    let target = TextureTarget::new(&texture).expect("it has such a format");
    for mut renderer in [on_gpu.with_fallback(|note| panic!("{note}")), on_cpu] {
        let error = renderer.submit(&scene, &target).expect_err("it has another size");
        let (picture, texture) = ([40, 30], [40, 31]);
        assert_eq!(error, RenderError::Target(TargetError::Size { picture, texture }));
        let sentence = "a picture of 40 x 30 pixels does not go into a texture of 40 x 31";
        assert_eq!(error.to_string(), sentence);
    }
}

/// More layers than the shaders draw: the CPU goes on.
#[test]
fn cpu_goes_on_where_the_device_does_not() {
    let _alone = alone();
    let Some(caller) = Caller::new() else { return };
    let mut scene = scene(&volume([3, 3, 3]), 40, Method::ImageAligned);
    let target = target(&caller, &scene, FLOATS);
    let notes = Arc::new(Mutex::new(Vec::new()));
    let reporter = notes.clone();
    let renderer = TextureRenderer::on(&caller.device, &caller.queue).expect("it was asked for");
    let mut renderer = renderer
        .with_fallback(move |note| reporter.lock().expect("no test failed").push(note.to_owned()));
    let before = renderer.submit(&scene, &target).expect("it is valid");
    let layer: Layer = scene.layers[0].clone();
    scene.layers = vec![layer; 65];
    let frame = renderer.submit(&scene, &target).expect("the CPU draws it");
    assert_eq!(renderer.caps().name, "cpu");
    renderer.wait(&before).expect("it begins again");
    renderer.wait(&frame).expect("the CPU draws it");
    let expected = Renderer::open("cpu", |_| ()).expect("it is there").render(&scene);
    assert!(caller.read_floats(target.texture()) == expected.expect("it is valid").image.pixels());
    let notes = notes.lock().expect("no test failed");
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].ends_with("not 65; going on with the backend \"cpu\""), "{notes:?}");
}

#[test]
fn frames_are_cancelled_and_taken_once() {
    let _alone = alone();
    let Some(caller) = Caller::new() else { return };
    let scene = scene(&volume([5, 4, 3]), 40, Method::ImageAligned);
    let target = target(&caller, &scene, FLOATS);
    let on_gpu = TextureRenderer::on(&caller.device, &caller.queue).expect("it was asked for");
    let on_cpu = TextureRenderer::on_cpu(&caller.queue).expect("there is always one");
    for mut renderer in [on_gpu, on_cpu] {
        let unknown = Err(RenderError::Backend(BackendError::UnknownFrame));
        assert_eq!(renderer.poll(&FrameHandle::new()), unknown);
        let frame = renderer.submit(&scene, &target).expect("it is valid");
        frame.cancel();
        let error = renderer.wait(&frame).expect_err("it is cancelled");
        assert!(error.is_cancelled(), "{error}");
        // Nobody waits for these.
        for _ in 0..9 {
            drop(renderer.submit(&scene, &target).expect("it is valid"));
        }
        let frame = renderer.submit(&scene, &target).expect("it is valid");
        while renderer.poll(&frame).expect("it is there").is_pending() {
            std::thread::yield_now();
        }
        assert_eq!(renderer.poll(&frame), unknown);
    }
    assert_eq!(caller.n_errors(), 0);
}

#[test]
fn device_that_its_caller_destroys_is_an_error() {
    let _alone = alone();
    let Some(caller) = Caller::new() else { return };
    let scene = scene(&volume([5, 4, 3]), 40, Method::ImageAligned);
    let target = target(&caller, &scene, FLOATS);
    let mut renderer =
        TextureRenderer::on(&caller.device, &caller.queue).expect("it was asked for");
    renderer.render(&scene, &target).expect("it is valid");
    caller.device.destroy();
    let error = renderer.render(&scene, &target).expect_err("the device is gone");
    let is_lost = matches!(error, RenderError::Backend(BackendError::DeviceLost { .. }));
    assert!(is_lost, "{error}");
    assert_eq!(caller.n_errors(), 0);
}

/// Takes pictures by reading them, which only tests do.
#[derive(Debug, Default)]
struct Reading {
    /// Whether each picture was whole, its bytes, and how many there are of counts.
    taken: Mutex<Vec<(bool, Vec<u32>, u64)>>,
}

impl Destination<SpyDevice> for Reading {
    fn check_size(&self, size: [u32; 2]) -> Result<(), String> {
        if size[0] < 1000 { Ok(()) } else { Err("too wide".to_owned()) }
    }

    fn take(&self, device: &mut SpyDevice, picture: &Picture) -> Result<(), DeviceError> {
        let bands = picture.bands.iter().map(|band| band.pixels);
        let reads = std::iter::once(picture.counts).chain(bands).collect();
        let work = device.submit(&Work { reads, ..Work::default() })?;
        let done = loop {
            if let Poll::Ready(done) = device.poll(work)? {
                break done;
            }
            device.wait(work, Duration::from_millis(5));
        };
        let is_whole = done.reads[0][picture.is_whole_at as usize] == 1;
        self.taken.lock().expect("no test failed").push((
            is_whole,
            done.reads[1..].concat(),
            picture.counts.size,
        ));
        Ok(())
    }
}

/// On every graphics interface: nothing but counts is read, little is written, and the picture is said to be
/// whole when it is.
#[test]
fn pictures_left_on_a_device_are_not_read() {
    let _alone = alone();
    for (name, device) in devices() {
        let spy = SpyDevice::new(device, |info| {
            info.max_binding_bytes = info.max_binding_bytes.min(128 << 10);
        });
        let orders = spy.orders();
        let mut backend = GpuBackend::new(name, spy);
        let reading = Arc::new(Reading::default());
        let to: Arc<dyn Destination<SpyDevice>> = reading.clone();
        let mut planner = Planner::default();
        // The second is in two bands.
        let small = volume([9, 8, 7]);
        let scenes = [
            scene(&small, 37, Method::ImageAligned),
            scene(&small, 120, Method::ImageAligned),
            scene(&small, 37, Method::EverySample),
        ];
        for mut scene in scenes {
            scene.settings.sections = 16;
            scene.settings.radial_samples = 16;
            scene.settings.lookup = Lookup::Nearest;
            let plan = planner.plan(&scene).expect("the scene is valid");
            let expected = FrameHandle::new();
            backend.submit(&plan, &expected).expect("it fits");
            let expected = backend.wait_image(&expected).expect("it fits").image;
            let mut left = || {
                *locked(&orders) = Default::default();
                let frame = FrameHandle::new();
                backend.submit_into(&plan, &frame, &to).expect("it fits");
                backend.wait_image(&frame).expect("it fits").image
            };
            let image = left();
            assert_eq!((image.width(), image.height()), (0, 0), "{name}");
            let taken = std::mem::take(&mut *reading.taken.lock().expect("no test failed"));
            let [(is_whole, words, n_counts)] = &taken[..] else { panic!("{name}: there is room") };
            let floats: Vec<f32> = words.iter().map(|&word| f32::from_bits(word)).collect();
            assert!(*is_whole && floats == expected.pixels().as_flattened(), "{name}");
            let n_read = locked(&orders).bytes_read;
            let n_written = locked(&orders).bytes_written;
            // All but the counts is read by the destination.
            assert_eq!(n_read, n_counts + n_counts + 4 * words.len() as u64, "{name}");
            // A frame's parameters and those of one layer, however large the picture.
            assert!(n_written <= 544, "{name}: {n_written}");
        }
        let wide = scene(&small, 1000, Method::ImageAligned);
        let plan = planner.plan(&wide).expect("the scene is valid");
        let error = backend.submit_into(&plan, &FrameHandle::new(), &to).expect_err("too wide");
        assert!(error.to_string().ends_with("too wide"), "{name}: {error}");
    }
}

/// A frame for which there is no room is not whole, and is left again when it is.
#[test]
fn pictures_are_whole_when_there_is_room() {
    let _alone = alone();
    for (name, device) in devices() {
        let mut backend = GpuBackend::new(name, SpyDevice::new(device, |_| ()));
        let reading = Arc::new(Reading::default());
        let to: Arc<dyn Destination<SpyDevice>> = reading.clone();
        let scene = close_up(200);
        let (mut planner, frame) = (Planner::default(), FrameHandle::new());
        let plan = planner.plan(&scene).expect("the scene is valid");
        backend.submit_into(&plan, &frame, &to).expect("it fits");
        backend.wait_image(&frame).expect("it fits");
        let taken = reading.taken.lock().expect("no test failed");
        let were_whole: Vec<bool> = taken.iter().map(|(is_whole, ..)| *is_whole).collect();
        assert_eq!(were_whole, [false, true], "{name}");
    }
}
