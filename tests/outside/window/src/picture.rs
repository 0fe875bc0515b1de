//! A picture in a texture that the window shows: drawn again whenever the scene has changed, one frame at a
//! time, while the window goes on.

use slabsplat::wgpu::{self, Device, Queue};
use slabsplat::{FrameHandle, NoBackend, RenderError, Scene, TextureRenderer, TextureTarget};
use std::error::Error;
use std::task::Poll;

/// What shall draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// The window's graphics card, or else the CPU.
    Best,
    /// The CPU.
    Cpu,
    /// The window's device, even if it is only software.
    Gpu,
}

/// A picture of a scene that changes.
#[derive(Debug)]
pub struct Picture {
    device: Device,
    renderer: TextureRenderer,
    shown: Option<TextureTarget>,
    /// The frame that is under way, and where it goes.
    next: Option<(FrameHandle, TextureTarget)>,
    is_stale: bool,
}

impl Picture {
    /// None yet, to be drawn on that device.
    ///
    /// # Errors
    /// If nothing draws.
    pub fn new(device: &Device, queue: &Queue, by: By) -> Result<Self, NoBackend> {
        let renderer = match by {
            By::Best => TextureRenderer::open(device, queue, |note| eprintln!("{note}")),
            By::Cpu => TextureRenderer::on_cpu(queue),
            By::Gpu => TextureRenderer::on(device, queue),
        }?;
        Ok(Self { device: device.clone(), renderer, shown: None, next: None, is_stale: true })
    }

    /// What draws, for people.
    pub fn drawn_by(&self) -> &str {
        &self.renderer.caps().device
    }

    /// To be called when the scene has changed.
    pub fn change(&mut self) {
        self.is_stale = true;
    }

    /// Whether what is shown is not, or not yet, what it should be.
    pub fn is_under_way(&self) -> bool {
        self.is_stale || self.next.is_some()
    }

    /// How much of the frame that is under way is drawn, 0 … 1.
    pub fn progress(&self) -> f32 {
        self.next.as_ref().map_or(1.0, |(frame, _)| frame.progress())
    }

    /// To be called before the window is drawn: looks what has become of the frame that is under way, and
    /// begins the next one. It never waits. What it returns is to be shown.
    ///
    /// # Errors
    /// If the scene cannot be drawn.
    pub fn update(&mut self, scene: &Scene) -> Result<Option<&TextureTarget>, Box<dyn Error>> {
        if let Some((frame, target)) = self.next.take() {
            match self.renderer.poll(&frame) {
                Ok(Poll::Ready(_)) => self.shown = Some(target),
                Ok(Poll::Pending) => self.next = Some((frame, target)),
                Err(error) => return Err(error.into()),
            }
        }
        if self.is_stale && self.next.is_none() {
            self.is_stale = false;
            self.next = Some(self.begin(scene)?);
        }
        Ok(self.shown.as_ref())
    }

    fn begin(&mut self, scene: &Scene) -> Result<(FrameHandle, TextureTarget), RenderError> {
        let size = [scene.image.width, scene.image.height];
        // The same texture as long as the window has the same size.
        let target = match self.shown.take_if(|shown| shown.size() == size) {
            Some(target) => self.shown.insert(target).clone(),
            None => TextureTarget::new(&self.texture(size))?,
        };
        let frame = self.renderer.submit(scene, &target)?;
        Ok((frame, target))
    }

    fn texture(&self, [width, height]: [u32; 2]) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("volume"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            // egui takes numbers as screens do, and so does a picture have them.
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: TextureTarget::USAGES
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }
}
