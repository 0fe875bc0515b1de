//! A program that has a device of wgpu's anyway shares it: frames are drawn into a texture of the program's,
//! on which the program continues. This one only copies it out, to see it: `cargo run --release -p slabsplat
//! --features wgpu --example own_device [picture.png]`.

use slabsplat::{
    Automatic, Image, ImageDesc, RenderSettings, TextureRenderer, TextureTarget, io, wgpu,
};
use std::error::Error;
use std::path::Path;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "own-device.png".to_owned());
    draw(Path::new(&path))
}

/// Draws a volume on a device of its own.
///
/// # Errors
/// If there is no device, or the picture cannot be written.
pub(crate) fn draw(path: &Path) -> Result<(), Box<dyn Error>> {
    let (device, queue) = device()?;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width: 320, height: 240, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: TextureTarget::USAGES | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let target = TextureTarget::new(&texture)?;
    let [width, height] = target.size();

    let automatic = Automatic::new(io::builtin_volume("neuron", Some(64))?);
    let image = ImageDesc::new(width, height);
    let scene = automatic.scene(image, RenderSettings::default());
    let mut renderer = TextureRenderer::open(&device, &queue, |note| eprintln!("{note}"))?;
    let drawn = renderer.render(&scene, &target)?;
    println!("{} splats on {}", drawn.stats.n_splats, renderer.caps().device);
    Ok(io::write_picture(path, &copied(&device, &queue, &texture)?)?)
}

/// As a program opens it for its own things, with what frames need added.
fn device() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = now(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let own =
        wgpu::DeviceDescriptor { label: Some("program"), ..wgpu::DeviceDescriptor::default() };
    Ok(now(adapter.request_device(&slabsplat::device_descriptor(&adapter, own)))?)
}

/// What a window would not do: the texture's pixels, on the CPU.
fn copied(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Image, Box<dyn Error>> {
    // 16 bytes a pixel are a multiple of the 256 that rows of a copy have to be.
    let bytes_per_row = 16 * texture.width();
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("copied"),
        size: u64::from(bytes_per_row * texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let bytes_per_row = Some(bytes_per_row);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = buffer.slice(..).get_mapped_range()?;
    let mut image = Image::filled(texture.width(), texture.height(), [0.0; 4]);
    let floats = image.pixels_mut().as_flattened_mut();
    for (float, bytes) in floats.iter_mut().zip(bytes.as_chunks::<4>().0) {
        *float = f32::from_ne_bytes(*bytes);
    }
    Ok(image)
}

/// All of wgpu's futures are ready at once, but in browsers.
fn now<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => unreachable!("this is no browser"),
    }
}
