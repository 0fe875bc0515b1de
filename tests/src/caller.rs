//! Somebody who has a device of wgpu's already, as a window has, and textures on it.

use crate::render::backends;
use slabsplat::wgpu;
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll, Waker};

/// A device, and what is known of it.
#[derive(Debug)]
pub struct Caller {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Errors that came to the caller's handler.
    n_errors: Arc<AtomicUsize>,
}

impl Caller {
    /// On the device that the backend `wgpu` has; `None` if there is none.
    ///
    /// # Panics
    /// If a device opened before and does not now.
    pub fn new() -> Option<Self> {
        if !backends().contains(&"wgpu") {
            return None;
        }
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::PRIMARY,
            flags: wgpu::InstanceFlags::VALIDATION | wgpu::InstanceFlags::DEBUG,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = now(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        let adapter = adapter.expect("there is one");
        let own = wgpu::DeviceDescriptor { label: Some("window"), ..Default::default() };
        let descriptor = slabsplat::device_descriptor(&adapter, own);
        let (device, queue) = now(adapter.request_device(&descriptor)).expect("it opened before");
        let n_errors = Arc::new(AtomicUsize::new(0));
        let count = n_errors.clone();
        device.on_uncaptured_error(Arc::new(move |error| {
            println!("{error}");
            count.fetch_add(1, Ordering::Relaxed);
        }));
        Some(Self { device, queue, n_errors })
    }

    /// Errors that came to the caller's handler, and none should.
    pub fn n_errors(&self) -> usize {
        self.n_errors.load(Ordering::Relaxed)
    }

    /// A texture for pictures, which can be read.
    pub fn texture(&self, [width, height]: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
        let usage = slabsplat::TextureTarget::USAGES | wgpu::TextureUsages::COPY_SRC;
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    }

    /// The bytes of a texture, after all that was submitted so far.
    ///
    /// # Panics
    /// If the device fails.
    pub fn read(&self, texture: &wgpu::Texture) -> Vec<u8> {
        let row = texture.width() * texture.format().block_copy_size(None).expect("no depth");
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read"),
            size: u64::from(padded) * u64::from(texture.height()),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder =
            self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(padded),
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        self.queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.expect("it is mapped"));
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is there");
        let bytes = buffer.slice(..).get_mapped_range().expect("it is mapped");
        bytes.chunks(padded as usize).flat_map(|padded| &padded[..row as usize]).copied().collect()
    }

    /// The pixels of a texture of 32-bit floats.
    ///
    /// # Panics
    /// If the device fails, or it is none.
    pub fn read_floats(&self, texture: &wgpu::Texture) -> Vec<[f32; 4]> {
        assert_eq!(texture.format(), wgpu::TextureFormat::Rgba32Float);
        let bytes = self.read(texture);
        let (floats, _) = bytes.as_chunks::<4>();
        let floats: Vec<f32> = floats.iter().map(|&bytes| f32::from_ne_bytes(bytes)).collect();
        floats.as_chunks::<4>().0.to_vec()
    }
}

/// What is there at once, as all of wgpu's futures are outside of browsers.
fn now<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => panic!("nobody waits here"),
    }
}
