//! Frames that go straight into textures of the caller's, on the caller's device.
//!
//! A device that runs the shaders draws a frame and leaves it in the texture, in the order of the queue.
//! Where it does not, or is only software, a thread draws on the CPU, and its pictures are uploaded: so
//! whoever shows a texture need not know which it was.

#[cfg(not(target_arch = "wasm32"))]
mod cpu;
#[cfg(target_arch = "wasm32")]
#[path = "texture_renderer/no_cpu.rs"]
mod cpu;

use crate::{NoBackend, RenderError};
use cpu::{OnCpu, Uploaded};
use slabsplat_backend::{Backend, BackendError, Caps, Frame, FrameCost, FrameStats, Planner};
use slabsplat_core::{FrameHandle, Scene};
use slabsplat_gpu::GpuBackend;
use slabsplat_kernel::{Kernel, KernelError};
use slabsplat_wgpu::{TextureTarget, WgpuDevice, wgpu};
use std::fmt;
use std::sync::Arc;
use std::task::Poll;

/// Renders scenes into textures of the caller's, by the caller's device: for windows that have one anyway, of
/// egui, bevy or winit. No picture is read back, and no call waits for one, but [`wait`](Self::wait).
///
/// ```no_run
/// use slabsplat::{Scene, TextureRenderer, TextureTarget, wgpu};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let (device, queue, mut scene): (wgpu::Device, wgpu::Queue, Scene) = unimplemented!();
/// // Once:
/// let mut renderer = TextureRenderer::open(&device, &queue, |note| eprintln!("{note}"))?;
/// // Whenever the window has another size:
/// let texture = device.create_texture(&wgpu::TextureDescriptor {
///     label: None,
///     size: wgpu::Extent3d { width: 640, height: 480, depth_or_array_layers: 1 },
///     mip_level_count: 1,
///     sample_count: 1,
///     dimension: wgpu::TextureDimension::D2,
///     format: wgpu::TextureFormat::Rgba8Unorm,
///     usage: TextureTarget::USAGES | wgpu::TextureUsages::TEXTURE_BINDING,
///     view_formats: &[],
/// });
/// let target = TextureTarget::new(&texture)?;
/// [scene.image.width, scene.image.height] = target.size();
/// // Whenever the scene has changed; what the window submits after that shows it.
/// let frame = renderer.submit(&scene, &target)?;
/// // When the window is drawn next:
/// if renderer.poll(&frame)?.is_ready() {
///     println!("the scene may change again");
/// }
/// # Ok(())
/// # }
/// ```
pub struct TextureRenderer {
    queue: wgpu::Queue,
    planner: Planner,
    /// Those that were added.
    kernels: Vec<Arc<dyn Kernel>>,
    drawing: Drawing,
    /// In the order of submission.
    under_way: Vec<UnderWay>,
    /// What says why it continues with the CPU, if it may.
    #[cfg_attr(target_arch = "wasm32", expect(dead_code, reason = "there is none"))]
    fallback: Option<Tell>,
}

type Tell = Box<dyn FnMut(&str) + Send>;

#[cfg_attr(target_arch = "wasm32", expect(dead_code, reason = "no thread draws on the CPU"))]
enum Drawing {
    Gpu(Box<GpuBackend<WgpuDevice>>),
    Cpu(OnCpu),
}

struct UnderWay {
    frame: FrameHandle,
    target: TextureTarget,
    /// To begin it again elsewhere.
    #[cfg_attr(target_arch = "wasm32", expect(dead_code, reason = "there is nowhere else"))]
    scene: Scene,
    /// If the CPU draws it.
    on_cpu: Option<Uploaded>,
}

/// What is known of a frame whose picture is in a texture.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Drawn {
    /// What was drawn.
    pub stats: FrameStats,
    /// What it cost.
    pub cost: FrameCost,
}

impl fmt::Debug for TextureRenderer {
    /// What renders, and nothing of what it has cached.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TextureRenderer").field("backend", self.caps()).finish_non_exhaustive()
    }
}

impl TextureRenderer {
    /// A renderer on the device, be it a fast one or not. The device stays the caller's, as it says at
    /// [`Renderer::on_wgpu`](crate::Renderer::on_wgpu).
    ///
    /// # Errors
    /// If the shaders do not run on it, with all that it lacks:
    /// [`device_descriptor`](crate::device_descriptor) asks for it.
    pub fn on(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Self, NoBackend> {
        let opened = slabsplat_wgpu::on(device.clone(), queue.clone());
        let device =
            opened.map_err(|none| NoBackend::Unavailable { name: "wgpu", reason: none.reason })?;
        Ok(Self::drawing_by(queue, Drawing::Gpu(Box::new(GpuBackend::new("wgpu", device)))))
    }

    fn drawing_by(queue: &wgpu::Queue, drawing: Drawing) -> Self {
        Self {
            queue: queue.clone(),
            planner: Planner::default(),
            kernels: Vec::new(),
            drawing,
            under_way: Vec::new(),
            fallback: None,
        }
    }

    /// Adds a kernel, which the settings of scenes may name from now on. It stays with a fallback. What the
    /// CPU draws just now is cancelled.
    ///
    /// # Errors
    /// As [`Kernels::add`](slabsplat_kernel::Kernels::add).
    pub fn add_kernel(&mut self, kernel: Arc<dyn Kernel>) -> Result<(), KernelError> {
        self.planner.add_kernel(kernel.clone())?;
        self.kernels.push(kernel.clone());
        if let Drawing::Cpu(on_cpu) = &mut self.drawing {
            on_cpu.add_kernel(kernel);
        }
        Ok(())
    }

    /// What renders: `cpu` where the device does not.
    pub fn caps(&self) -> &Caps {
        match &self.drawing {
            Drawing::Gpu(backend) => backend.caps(),
            Drawing::Cpu(on_cpu) => on_cpu.caps(),
        }
    }

    /// Begins a frame whose picture goes to `target`, which has the size of the scene's image.
    ///
    /// A device draws it in the order of the queue: whatever is submitted from now on, such as a window's own
    /// commands, sees it. Rarely a frame needs room that was not there, and the texture stays as it was until
    /// [`poll`](Self::poll) has seen to that. The CPU's picture comes with the `poll` that finds it done. Of
    /// frames that go to one texture the last one stays.
    ///
    /// The frame is dropped with its handle. One that is cancelled, or dropped, may still get to the texture,
    /// whole, if it was begun.
    ///
    /// # Errors
    /// If the scene cannot be drawn, the texture does not fit it, or the device fails and there is no
    /// fallback.
    pub fn submit(
        &mut self,
        scene: &Scene,
        target: &TextureTarget,
    ) -> Result<FrameHandle, RenderError> {
        let size = [scene.image.width, scene.image.height];
        match self.drawing {
            Drawing::Gpu(_) => target.check_drawable(size)?,
            Drawing::Cpu(_) => target.check_writable(size)?,
        }
        self.under_way.retain(|other| !other.is_abandoned());
        let frame = FrameHandle::new();
        let on_cpu = match self.begin(scene, target, &frame) {
            Err(RenderError::Backend(error)) if self.falls_back(&error) => {
                self.begin(scene, target, &frame)?
            }
            begun => begun?,
        };
        let (target, scene) = (target.clone(), scene.clone());
        self.under_way.push(UnderWay { frame: frame.clone(), target, scene, on_cpu });
        Ok(frame)
    }

    fn begin(
        &mut self,
        scene: &Scene,
        target: &TextureTarget,
        frame: &FrameHandle,
    ) -> Result<Option<Uploaded>, RenderError> {
        match &mut self.drawing {
            Drawing::Gpu(backend) => {
                self.planner.plan_cells(backend.caps().draws_cells);
                let plan = self.planner.plan_for_frame(scene, frame)?;
                backend.submit_into(&plan, frame, &target.destination())?;
                Ok(None)
            }
            Drawing::Cpu(on_cpu) => Ok(Some(on_cpu.begin(scene, frame)?)),
        }
    }

    /// Says what was drawn if the frame is done, and in its texture; without waiting.
    ///
    /// # Errors
    /// If the frame failed or was cancelled, or is none of this renderer's.
    pub fn poll(&mut self, frame: &FrameHandle) -> Result<Poll<Drawn>, RenderError> {
        let idx = self.idx_of(frame)?;
        let taken = match (&mut self.under_way[idx].on_cpu, &mut self.drawing) {
            (Some(on_cpu), _) => on_cpu.try_take(),
            (None, Drawing::Gpu(backend)) => backend.poll_image(frame).map_err(RenderError::from),
            (None, Drawing::Cpu(_)) => Err(BackendError::UnknownFrame.into()),
        };
        match taken {
            Ok(Poll::Pending) => Ok(Poll::Pending),
            Ok(Poll::Ready(taken)) => self.finish(idx, taken).map(Poll::Ready),
            Err(error) => self.fail(idx, error).map(|()| Poll::Pending),
        }
    }

    /// Says what was drawn as soon as the frame is done, and in its texture; sleeps until then.
    ///
    /// # Errors
    /// If the frame failed or was cancelled, or is none of this renderer's.
    pub fn wait(&mut self, frame: &FrameHandle) -> Result<Drawn, RenderError> {
        loop {
            let idx = self.idx_of(frame)?;
            let taken = match (&mut self.under_way[idx].on_cpu, &mut self.drawing) {
                (Some(on_cpu), _) => on_cpu.wait(),
                (None, Drawing::Gpu(backend)) => {
                    backend.wait_image(frame).map_err(RenderError::from)
                }
                (None, Drawing::Cpu(_)) => Err(BackendError::UnknownFrame.into()),
            };
            match taken {
                Ok(taken) => return self.finish(idx, taken),
                Err(error) => self.fail(idx, error)?,
            }
        }
    }

    /// Renders a frame into a texture and waits until it is there.
    ///
    /// # Errors
    /// As [`submit`](Self::submit) and [`wait`](Self::wait).
    pub fn render(&mut self, scene: &Scene, target: &TextureTarget) -> Result<Drawn, RenderError> {
        let frame = self.submit(scene, target)?;
        self.wait(&frame)
    }

    fn idx_of(&self, frame: &FrameHandle) -> Result<usize, BackendError> {
        let idx = self.under_way.iter().position(|under_way| under_way.frame == *frame);
        idx.ok_or(BackendError::UnknownFrame)
    }

    /// A frame is done, and one of the CPU's gets to its texture.
    fn finish(&mut self, idx: usize, done: Frame) -> Result<Drawn, RenderError> {
        let UnderWay { target, on_cpu, .. } = self.under_way.remove(idx);
        if on_cpu.is_some() {
            let size = [done.image.width(), done.image.height()];
            target.write(&self.queue, size, done.image.pixels())?;
        }
        Ok(Drawn { stats: done.stats, cost: done.cost })
    }

    /// A frame has failed; it may have begun again elsewhere.
    fn fail(&mut self, idx: usize, error: RenderError) -> Result<(), RenderError> {
        if let RenderError::Backend(of_device) = &error
            && self.falls_back(of_device)
        {
            return Ok(());
        }
        // A frame that nobody may wait for is still there to be polled.
        if error != RenderError::Backend(BackendError::CannotWait) {
            self.under_way.remove(idx);
        }
        Err(error)
    }
}

impl UnderWay {
    /// Whether nobody can ask for it any more: two handles are its own and that of who draws it.
    fn is_abandoned(&self) -> bool {
        self.frame.n_handles() <= 2
    }
}
