//! Where the device does not draw: a thread that draws on the CPU, and pictures that are uploaded.

use super::{Drawing, TextureRenderer};
use crate::backends::{CPU, is_fast};
use crate::{NoBackend, PendingFrame, RenderError, RenderThread, Renderer};
use slabsplat_backend::{BackendError, Caps, Frame};
use slabsplat_core::{FrameHandle, Scene};
use slabsplat_gpu::{Device, GpuBackend};
use slabsplat_kernel::Kernel;
use slabsplat_wgpu::wgpu;
use std::mem;
use std::sync::Arc;
use std::task::Poll;

/// The CPU, and the thread that it draws on once there is something to be drawn.
pub(super) struct OnCpu {
    caps: Caps,
    kernels: Vec<Arc<dyn Kernel>>,
    thread: Option<RenderThread>,
}

/// A frame that the thread draws.
pub(super) struct Uploaded(Option<PendingFrame>);

impl TextureRenderer {
    /// A renderer on the device if it is a graphics card that runs the shaders, and else on the CPU, which
    /// also continues where the device fails; `tell` is given a sentence for people whenever one that should
    /// draw does not. Software that plays a graphics card is slower than the CPU, and not taken.
    ///
    /// # Errors
    /// If the device does not draw, and this build has no CPU backend.
    pub fn open(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        mut tell: impl FnMut(&str) + Send + 'static,
    ) -> Result<Self, NoBackend> {
        let device = slabsplat_wgpu::on(device.clone(), queue.clone());
        let drawing = match (device, OnCpu::new(&[])) {
            (Ok(device), Some(on_cpu)) if !is_fast(device.info().kind) => Drawing::Cpu(on_cpu),
            (Ok(device), _) => Drawing::Gpu(Box::new(GpuBackend::new("wgpu", device))),
            (Err(none), Some(on_cpu)) => {
                tell(&format!("{none}; going on with the backend \"cpu\""));
                Drawing::Cpu(on_cpu)
            }
            (Err(none), None) => {
                return Err(NoBackend::Unavailable { name: "wgpu", reason: none.reason });
            }
        };
        Ok(Self::drawing_by(queue, drawing).with_fallback(tell))
    }

    /// The same on the CPU from the start, as where the device is wanted for other things.
    ///
    /// # Errors
    /// If this build has no CPU backend.
    pub fn on_cpu(queue: &wgpu::Queue) -> Result<Self, NoBackend> {
        let on_cpu = OnCpu::new(&[]).ok_or(NoBackend::NotBuilt { name: "cpu" })?;
        Ok(Self::drawing_by(queue, Drawing::Cpu(on_cpu)))
    }

    /// The same, but where the device runs out of memory, is lost or cannot make a frame, the CPU draws that
    /// frame and all that follow, if this build has it; `tell` is told so, in a sentence for people.
    #[must_use]
    pub fn with_fallback(self, tell: impl FnMut(&str) + Send + 'static) -> Self {
        Self { fallback: Some(Box::new(tell)), ..self }
    }

    /// Whether what the device could not draw is now drawn by the CPU, if it may be.
    pub(super) fn falls_back(&mut self, error: &BackendError) -> bool {
        if !error.is_of_device() || matches!(self.drawing, Drawing::Cpu(_)) {
            return false;
        }
        let Some((mut tell, mut on_cpu)) = self.fallback.take().zip(OnCpu::new(&self.kernels))
        else {
            return false;
        };
        tell(&format!("{error}; going on with the backend \"cpu\""));
        for under_way in &mut self.under_way {
            under_way.on_cpu = on_cpu.begin(&under_way.scene, &under_way.frame).ok();
        }
        self.drawing = Drawing::Cpu(on_cpu);
        true
    }
}

impl OnCpu {
    /// The CPU with these kernels beside its own, if this build has it.
    fn new(kernels: &[Arc<dyn Kernel>]) -> Option<Self> {
        let caps = CPU?().caps().clone();
        Some(Self { caps, kernels: kernels.to_vec(), thread: None })
    }

    pub(super) fn caps(&self) -> &Caps {
        &self.caps
    }

    pub(super) fn add_kernel(&mut self, kernel: Arc<dyn Kernel>) {
        self.kernels.push(kernel);
        // The next one has it.
        self.thread = None;
    }

    /// Asks for a frame.
    pub(super) fn begin(
        &mut self,
        scene: &Scene,
        frame: &FrameHandle,
    ) -> Result<Uploaded, RenderError> {
        let thread = match self.thread.take() {
            Some(thread) => thread,
            None => self.spawned()?,
        };
        let pending = self.thread.insert(thread).submit_as(scene, frame);
        Ok(Uploaded(Some(pending)))
    }

    fn spawned(&self) -> Result<RenderThread, RenderError> {
        let Some(make) = CPU else { return Err(NoBackend::NotBuilt { name: "cpu" }.into()) };
        let mut renderer = Renderer::new(make());
        for kernel in &self.kernels {
            // They were taken before.
            drop(renderer.add_kernel(kernel.clone()));
        }
        RenderThread::spawn(renderer).map_err(|error| {
            let reason = format!("the system starts no thread for it: {error}");
            NoBackend::Unavailable { name: "cpu", reason }.into()
        })
    }
}

impl Uploaded {
    pub(super) fn try_take(&mut self) -> Result<Poll<Frame>, RenderError> {
        self.0.as_mut().map_or(Err(BackendError::UnknownFrame.into()), PendingFrame::try_take)
    }

    pub(super) fn wait(&mut self) -> Result<Frame, RenderError> {
        mem::take(&mut self.0).map_or(Err(BackendError::UnknownFrame.into()), PendingFrame::wait)
    }
}
