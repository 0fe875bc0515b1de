//! The window's picture, without a window: the mouse turns it, and both who can draw it draw the same.

use slabsplat::wgpu;
use slabsplat::{Automatic, ImageDesc, RenderSettings, Scene};
use std::pin::pin;
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};
use window::{By, Orbit, Picture, open};

#[test]
fn picture_follows_the_mouse() {
    let Some((device, queue)) = device() else { return };
    let volume = open("sphere").unwrap();
    assert!(open("no such volume").is_err());
    let automatic = Automatic::new(volume);
    let image = ImageDesc::new(60, 41).background([0.0, 0.0, 0.5, 1.0]);
    let mut scene = automatic.scene(image, RenderSettings::default());
    let mut of_both = Vec::new();
    for by in [By::Gpu, By::Cpu] {
        scene.image = image;
        scene.camera = automatic.camera(&image, true);
        let mut orbit = Orbit::new(scene.camera);
        let mut picture = Picture::new(&device, &queue, by).unwrap();
        let texture = shown(&mut picture, &scene);
        assert_eq!([texture.width(), texture.height()], [60, 41]);
        let before = read(&device, &queue, &texture);
        assert_eq!(before[..4], [0, 0, 128, 255], "the background, {by:?}");
        assert_ne!(before[4 * (20 * 60 + 30)..][..4], [0, 0, 128, 255], "the ball, {by:?}");
        orbit.magnify(2.0);
        orbit.drag(0.2, 0.1);
        scene.camera = orbit.camera().unwrap();
        picture.change();
        let texture = shown(&mut picture, &scene);
        let turned = read(&device, &queue, &texture);
        assert_ne!(turned, before, "{by:?}");
        [scene.image.width, scene.image.height] = [81, 40];
        picture.change();
        assert_eq!(shown(&mut picture, &scene).width(), 81, "{by:?}");
        of_both.push([before, turned]);
    }
    for (a, b) in of_both[0].iter().flatten().zip(of_both[1].iter().flatten()) {
        assert!(a.abs_diff(*b) <= 1, "{a} on the device, {b} on the CPU");
    }
}

/// What is shown when the window has been drawn often enough.
fn shown(picture: &mut Picture, scene: &Scene) -> wgpu::Texture {
    let begin = Instant::now();
    loop {
        let asked = Instant::now();
        let target = picture.update(scene).unwrap().cloned();
        println!("asked within {:?}", asked.elapsed());
        if let (Some(target), false) = (target, picture.is_under_way()) {
            return target.texture().clone();
        }
        assert!(begin.elapsed() < Duration::from_secs(100), "nothing comes");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A device, if this machine has one.
fn device() -> Option<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = now(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let adapter = match adapter {
        Ok(adapter) => adapter,
        Err(none) if std::env::var_os("SLABSPLAT_REQUIRE_GPU").is_some() => panic!("{none}"),
        Err(none) => {
            println!("skipped: {none}");
            return None;
        }
    };
    let descriptor = slabsplat::device_descriptor(&adapter, wgpu::DeviceDescriptor::default());
    Some(now(adapter.request_device(&descriptor)).unwrap())
}

fn read(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Vec<u8> {
    let row = 4 * texture.width() as usize;
    let padded = row.next_multiple_of(256);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: padded as u64 * u64::from(texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let bytes_per_row = Some(padded as u32);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let bytes = buffer.slice(..).get_mapped_range().unwrap();
    bytes.chunks(padded).flat_map(|padded| &padded[..row]).copied().collect()
}

/// All of wgpu's futures are ready at once, but in browsers.
fn now<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => unreachable!("this is no browser"),
    }
}
