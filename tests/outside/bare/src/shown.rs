//! A window, its device, and the texture that slabsplat draws into.

use slabsplat::wgpu::util::TextureBlitter;
use slabsplat::wgpu::{self, CurrentSurfaceTexture};
use slabsplat::{FrameHandle, Scene, TextureRenderer, TextureTarget};
use std::error::Error;
use std::pin::pin;
use std::sync::Arc;
use std::task::{Context, Poll, Waker};
use winit::dpi::PhysicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::{Window, WindowAttributes};

/// What is on the screen.
pub struct Shown {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// Copies the texture onto the surface, which slabsplat knows nothing of.
    blitter: TextureBlitter,
    renderer: TextureRenderer,
    target: TextureTarget,
    /// The frame that is under way.
    frame: Option<FrameHandle>,
    is_stale: bool,
}

impl Shown {
    /// A window for that scene, which has drawn nothing yet.
    ///
    /// # Errors
    /// If there is no screen, or nothing that draws on it.
    pub fn open(event_loop: &ActiveEventLoop, scene: &Scene) -> Result<Self, Box<dyn Error>> {
        let size = PhysicalSize::new(scene.image.width, scene.image.height);
        let attributes = WindowAttributes::default().with_title("slabsplat").with_inner_size(size);
        let window = Arc::new(event_loop.create_window(attributes)?);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(window.clone())?;
        let adapter = now(instance.request_adapter(&wgpu::RequestAdapterOptions {
            compatible_surface: Some(&surface),
            ..wgpu::RequestAdapterOptions::default()
        }))?;
        // The window asks for nothing of its own, and frames add what they need.
        let desc = slabsplat::device_descriptor(&adapter, wgpu::DeviceDescriptor::default());
        let (device, queue) = now(adapter.request_device(&desc))?;
        let config = surface
            .get_default_config(&adapter, size.width, size.height)
            .ok_or("the device does not draw on this screen")?;
        surface.configure(&device, &config);
        Ok(Self {
            blitter: TextureBlitter::new(&device, config.format),
            renderer: TextureRenderer::open(&device, &queue, |note| eprintln!("{note}"))?,
            target: target(&device, &config)?,
            window,
            surface,
            config,
            device,
            queue,
            frame: None,
            is_stale: true,
        })
    }

    /// To be called when the scene has changed.
    pub fn change(&mut self) {
        self.is_stale = true;
        self.window.request_redraw();
    }

    /// The window and the picture get another size; one without pixels shows nothing.
    ///
    /// # Errors
    /// If there is no such texture.
    pub fn resize(
        &mut self,
        scene: &mut Scene,
        size: PhysicalSize<u32>,
    ) -> Result<(), Box<dyn Error>> {
        if size.width == 0 || size.height == 0 {
            return Ok(());
        }
        (self.config.width, self.config.height) = (size.width, size.height);
        self.surface.configure(&self.device, &self.config);
        scene.image = scene.image.size(size.width, size.height);
        if let Some(frame) = self.frame.take() {
            frame.cancel();
        }
        self.target = target(&self.device, &self.config)?;
        self.change();
        Ok(())
    }

    /// Begins a frame if the scene has changed and none is under way, and presents the texture. It waits for
    /// the screen alone.
    ///
    /// # Errors
    /// If the scene cannot be drawn.
    pub fn redraw(&mut self, scene: &Scene) -> Result<(), Box<dyn Error>> {
        if let Some(frame) = &self.frame
            && self.renderer.poll(frame)?.is_ready()
        {
            self.frame = None;
        }
        if self.is_stale && self.frame.is_none() {
            self.frame = Some(self.renderer.submit(scene, &self.target)?);
            self.is_stale = false;
        }
        self.present();
        if self.is_stale || self.frame.is_some() {
            self.window.request_redraw();
        }
        Ok(())
    }

    /// What a card draws into the texture it has drawn before this, which comes later in its queue.
    fn present(&self) {
        let onto = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(onto) | CurrentSurfaceTexture::Suboptimal(onto) => onto,
            // It comes again with the next event.
            _ => return self.surface.configure(&self.device, &self.config),
        };
        let view =
            |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder =
            self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let (from, to) = (view(self.target.texture()), view(&onto.texture));
        self.blitter.copy(&self.device, &mut encoder, &from, &to);
        self.queue.submit([encoder.finish()]);
        self.queue.present(onto);
    }
}

/// A texture as large as the window, with the curve of sRGB if the screen's has it.
fn target(
    device: &wgpu::Device,
    config: &wgpu::SurfaceConfiguration,
) -> Result<TextureTarget, Box<dyn Error>> {
    let format = if config.format.is_srgb() {
        wgpu::TextureFormat::Rgba8UnormSrgb
    } else {
        wgpu::TextureFormat::Rgba8Unorm
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("volume"),
        size: wgpu::Extent3d {
            width: config.width,
            height: config.height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureTarget::USAGES | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    Ok(TextureTarget::new(&texture)?)
}

/// All of wgpu's futures are ready at once, but in browsers.
fn now<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => unreachable!("this is no browser"),
    }
}
