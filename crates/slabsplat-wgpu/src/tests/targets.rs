//! Textures that take a picture, or do not.

use super::caller::{Caller, check_works};
use super::{run, slice};
use crate::{TargetError, TextureTarget, WgpuDevice};
use slabsplat_gpu::{Device, DeviceError, Picture, PictureBand, Work, Write};

fn texture(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

const FLOATS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

const SIZE: [u32; 2] = [5, 4];

/// A picture in two bands, of numbers that count up from `first`.
fn picture(device: &mut WgpuDevice, first: f32, is_whole: u32) -> Picture {
    let numbers: Vec<f32> = (0..80).map(|n| first + n as f32).collect();
    let [top, below, counts] =
        [240, 80, 12].map(|size| device.create_buffer("band", size).unwrap());
    let bytes = |numbers: &[f32]| numbers.iter().flat_map(|n| n.to_ne_bytes()).collect::<Vec<u8>>();
    let write = |buffer, bytes: Vec<u8>| Write { buffer, offset: 0, bytes: bytes.into() };
    let writes = vec![
        write(top, bytes(&numbers[..60])),
        write(below, bytes(&numbers[60..])),
        write(counts, [0, 0, is_whole].map(u32::to_ne_bytes).concat()),
    ];
    run(device, &Work { writes, ..Work::default() });
    let bands = vec![
        PictureBand { rows: 0..3, pixels: slice(top, 0, 240) },
        PictureBand { rows: 3..4, pixels: slice(below, 0, 80) },
    ];
    Picture { size: SIZE, bands, counts: slice(counts, 0, 12), is_whole_at: 2 }
}

/// The floats in a texture.
fn read(caller: &Caller, texture: &wgpu::Texture) -> Vec<f32> {
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
    let buffer = caller.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 1024,
        usage,
        mapped_at_creation: false,
    });
    let mut encoder = caller.device.create_command_encoder(&Default::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(256), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    caller.queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.unwrap());
    caller.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let bytes = buffer.slice(..).get_mapped_range().unwrap();
    let rows = bytes.chunks(256).take(4).flat_map(|row| &row[..80]);
    let bytes: Vec<u8> = rows.copied().collect();
    bytemuck::pod_collect_to_vec(&bytes)
}

#[test]
fn picture_is_drawn_if_it_is_whole() {
    let Some(caller) = Caller::new(None) else { return };
    let mut device = caller.opened();
    let usage = TextureTarget::USAGES | wgpu::TextureUsages::COPY_SRC;
    let texture = texture(&caller.device, SIZE, FLOATS, usage);
    let target = TextureTarget::new(&texture).unwrap();
    let expected = |first: f32| (0..80).map(|n| first + n as f32).collect::<Vec<_>>();
    for (first, is_whole, shown) in [(-7.5, 1, -7.5), (100.0, 0, -7.5), (0.25, 1, 0.25)] {
        let picture = picture(&mut device, first, is_whole);
        target.destination().take(&mut device, &picture).unwrap();
        assert_eq!(read(&caller, &texture), expected(shown), "{first}, {is_whole}");
    }
    let pixels: Vec<[f32; 4]> = (0..20).map(|n| [n as f32, 0.5, -1.0, 2.0]).collect();
    target.write(&caller.queue, SIZE, &pixels).unwrap();
    assert_eq!(read(&caller, &texture), pixels.as_flattened());
    assert_eq!(caller.n_errors(), 0);
}

/// Of frames that resemble each other nothing is made but commands.
#[test]
fn pictures_use_what_there_is() {
    let Some(caller) = Caller::new(None) else { return };
    let mut device = caller.opened();
    let texture = texture(&caller.device, SIZE, FLOATS, TextureTarget::USAGES);
    let target = TextureTarget::new(&texture).unwrap();
    let picture = picture(&mut device, 0.0, 1);
    target.destination().take(&mut device, &picture).unwrap();
    let n_kept = device.bind_groups.n_kept();
    for _ in 0..5 {
        target.destination().take(&mut device, &picture).unwrap();
    }
    assert_eq!((n_kept, device.bind_groups.n_kept()), (2, 2));
    device.destroy_buffer(picture.bands[0].pixels.buffer);
    assert_eq!(device.bind_groups.n_kept(), 1);
}

#[test]
fn textures_that_take_no_picture() {
    let Some(caller) = Caller::new(None) else { return };
    let check = |format, usage| TextureTarget::new(&texture(&caller.device, SIZE, format, usage));
    let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let error = check(wgpu::TextureFormat::R8Unorm, drawn).unwrap_err();
    assert!(matches!(error, TargetError::Format { .. }), "{error}");
    let target = check(FLOATS, drawn).unwrap();
    assert_eq!(target.check_drawable(SIZE), Ok(()));
    assert_eq!(
        target.check_drawable([5, 5]).unwrap_err().to_string(),
        "a picture of 5 x 5 pixels does not go into a texture of 5 x 4"
    );
    let missing = wgpu::TextureUsages::COPY_DST;
    let error = target.write(&caller.queue, SIZE, &[[0.0; 4]; 20]).unwrap_err();
    assert_eq!(error, TargetError::Usage { missing });
    let target = check(FLOATS, wgpu::TextureUsages::COPY_DST).unwrap();
    assert_eq!(target.check_drawable(SIZE).unwrap_err(), TargetError::Usage { missing: drawn });
    let several = caller.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 4, height: 4, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 4,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: drawn,
        view_formats: &[],
    });
    let error = TextureTarget::new(&several).unwrap_err();
    assert!(matches!(error, TargetError::Shape { n_samples: 4, .. }), "{error}");
    assert_eq!(caller.n_errors(), 0);
}

/// Of another device, or destroyed: an error of this picture, and nothing else is lost.
#[test]
fn texture_that_wgpu_refuses() {
    let Some(caller) = Caller::new(None) else { return };
    let other = caller.beside();
    let mut device = caller.opened();
    let picture = picture(&mut device, 0.0, 1);
    let foreign = texture(&other.device, SIZE, FLOATS, TextureTarget::USAGES);
    let destroyed = texture(&caller.device, SIZE, FLOATS, TextureTarget::USAGES);
    let targets = [&foreign, &destroyed].map(|texture| TextureTarget::new(texture).unwrap());
    destroyed.destroy();
    for target in targets {
        let error = target.destination().take(&mut device, &picture).unwrap_err();
        assert!(matches!(error, DeviceError::Refused { .. }), "{error}");
        check_works(&mut device);
    }
    assert_eq!((caller.n_errors(), other.n_errors()), (0, 0));
}
