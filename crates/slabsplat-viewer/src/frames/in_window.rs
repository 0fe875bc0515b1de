//! Frames that stay on the graphics card: they are drawn into textures of the window's own device, so that
//! nothing is read back, and nothing uploaded to be shown.
//!
//! Only frames that move do so. What is at rest is read back, as it is compared, saved and finished.
//! A texture has a frame as long as anybody shows it, and is drawn into again afterwards: a pane has three at
//! most, the one that is shown, the one that has come, and the one that is being drawn.

use super::{Request, Urgency, WindowTexture};
use slabsplat::wgpu::{self, Device, Queue};
use slabsplat::{Finish, FrameHandle, RenderError, TextureRenderer, TextureTarget};
use std::task::Poll;

/// The device that draws a window, and what draws frames on it.
#[derive(Debug)]
pub struct WindowDevice {
    device: Device,
    queue: Queue,
    panes: Vec<Pane>,
}

#[derive(Debug)]
struct Pane {
    renderer: TextureRenderer,
    textures: Vec<WindowTexture>,
}

/// A frame that is being drawn into a texture.
#[derive(Debug)]
pub(crate) struct Begun {
    pub(crate) frame: FrameHandle,
    pane: usize,
    texture: WindowTexture,
}

impl WindowDevice {
    /// The device and its queue.
    pub fn new(device: Device, queue: Queue) -> Self {
        Self { device, queue, panes: Vec::new() }
    }

    /// Whether a request may be answered by a texture: it moves, nobody asks for its pixels, and nothing is
    /// to be done with these after they are drawn.
    pub(crate) fn takes(request: &Request) -> bool {
        request.urgency == Urgency::Moving
            && !request.is_read_back
            && request.opened.scene.finish == Finish::default()
    }

    /// Begins a frame.
    ///
    /// # Errors
    /// If the device does not draw it.
    pub(crate) fn begin(&mut self, request: &Request) -> Result<Begun, RenderError> {
        let image = request.opened.scene.image;
        while self.panes.len() <= request.pane {
            // Each has its own renderer, as what one keeps for its next frame is of no use to another's.
            let renderer = TextureRenderer::on(&self.device, &self.queue)?;
            self.panes.push(Pane { renderer, textures: Vec::new() });
        }
        let pane = &mut self.panes[request.pane];
        let texture = pane.texture(&self.device, [image.width, image.height])?;
        let frame = pane.renderer.submit(&request.opened.scene, texture.target())?;
        Ok(Begun { frame, pane: request.pane, texture })
    }

    /// Where the frame is, and how many voxels it has, once it is drawn; it never waits.
    ///
    /// # Errors
    /// If the device has not drawn it.
    pub(crate) fn poll(
        &mut self,
        begun: &Begun,
    ) -> Result<Poll<(WindowTexture, u64)>, RenderError> {
        let drawn = self.panes[begun.pane].renderer.poll(&begun.frame)?;
        Ok(drawn.map(|drawn| (begun.texture.clone(), drawn.stats.n_voxels)))
    }

    /// Whether an error is the device's, so that others may draw what it does not; else it is the scene's, or
    /// nobody wants the frame any more.
    pub(crate) fn is_failure(error: &RenderError) -> bool {
        match error {
            RenderError::Backend(error) => error.is_of_device(),
            RenderError::NoBackend(_) | RenderError::Target(_) => true,
            _ => false,
        }
    }
}

impl Pane {
    /// A texture of that size that nobody shows.
    fn texture(&mut self, device: &Device, size: [u32; 2]) -> Result<WindowTexture, RenderError> {
        self.textures.retain(|texture| texture.is_shown() || texture.size() == size);
        let unused = self.textures.iter().find(|texture| !texture.is_shown());
        if let Some(texture) = unused {
            return Ok(texture.clone());
        }
        let texture = WindowTexture::new(TextureTarget::new(&made(device, size))?);
        self.textures.push(texture.clone());
        Ok(texture)
    }
}

fn made(device: &Device, [width, height]: [u32; 2]) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("slabsplat frame"),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Event, FrameSource, RenderingThread, Wake};
    use slabsplat::io::{SceneFile, VolumeSource};
    use slabsplat::{Image, OpenScene, Renderer};
    use std::pin::pin;
    use std::sync::mpsc::{self, Receiver};
    use std::sync::{Arc, Mutex};
    use std::task::{Context, Waker};
    use std::time::Duration;

    const SIZE: [u32; 2] = [40, 24];

    fn scene() -> OpenScene {
        let source = VolumeSource::Builtin { name: "sphere".to_owned(), size: Some(16) };
        let mut file = SceneFile::of_volume(source);
        [file.image.width, file.image.height] = SIZE;
        OpenScene::open(&file).unwrap()
    }

    /// A device as a window has one, or `None` after a line.
    fn window() -> Option<(Device, Queue)> {
        if let Err(none) = Renderer::open("wgpu", |_| {}) {
            let must_be = std::env::var_os("SLABSPLAT_REQUIRE_GPU").is_some();
            assert!(!must_be, "SLABSPLAT_REQUIRE_GPU is set, but {none}");
            println!("skipped: {none}");
            return None;
        }
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = now(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        let adapter = adapter.expect("the renderer had one");
        let own = wgpu::DeviceDescriptor { label: Some("window"), ..Default::default() };
        let descriptor = slabsplat::device_descriptor(&adapter, own);
        Some(now(adapter.request_device(&descriptor)).expect("the renderer had one"))
    }

    /// What is ready at once, as devices are outside of browsers.
    fn now<T>(future: impl Future<Output = T>) -> T {
        match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(value) => value,
            Poll::Pending => panic!("it is not there at once"),
        }
    }

    /// A thread that draws, and what asks it.
    struct Drawing {
        thread: RenderingThread,
        woken: Receiver<()>,
        number: u64,
        /// What was said.
        notes: Vec<String>,
    }

    impl Drawing {
        fn new(backend: &str, (device, queue): &(Device, Queue)) -> Self {
            let (sender, woken) = mpsc::channel();
            let sender = Mutex::new(sender);
            let wake: Wake = Arc::new(move || _ = sender.lock().unwrap().send(()));
            let window = WindowDevice::new(device.clone(), queue.clone());
            let thread = RenderingThread::spawn_in_window(backend.to_owned(), wake, Some(window));
            Self { thread: thread.unwrap(), woken, number: 0, notes: Vec::new() }
        }

        fn ask(&mut self, opened: &OpenScene, urgency: Urgency, is_read_back: bool) -> Event {
            self.number += 1;
            let (number, opened) = (self.number, opened.clone());
            self.thread.ask(Request { pane: 0, number, opened, urgency, is_read_back });
            loop {
                let mut answer = None;
                for event in self.thread.events() {
                    match event {
                        Event::Note(note) => self.notes.push(note),
                        event => answer = Some(event),
                    }
                }
                if let Some(answer) = answer {
                    return answer;
                }
                self.woken.recv_timeout(Duration::from_secs(120)).unwrap();
            }
        }

        fn texture(&mut self, opened: &OpenScene) -> WindowTexture {
            match self.ask(opened, Urgency::Moving, false) {
                Event::InTexture(drawn) => drawn.texture,
                other => panic!("{other:?} instead of a texture"),
            }
        }
    }

    /// The bytes of a texture, four a pixel.
    fn bytes((device, queue): &(Device, Queue), texture: &WindowTexture) -> Vec<u8> {
        let [width, height] = texture.size();
        let padded = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(padded * height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(padded),
            rows_per_image: None,
        };
        encoder.copy_texture_to_buffer(
            texture.texture().as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.unwrap());
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let mapped = buffer.slice(..).get_mapped_range().unwrap();
        let rows = mapped.chunks(padded as usize);
        rows.flat_map(|row| row[..4 * width as usize].to_vec()).collect()
    }

    fn largest_difference(bytes: &[u8], image: &Image) -> f32 {
        let values = image.pixels().as_flattened();
        assert_eq!(bytes.len(), values.len());
        let off = bytes.iter().zip(values).map(|(byte, value)| f32::from(*byte) - 255.0 * value);
        off.map(f32::abs).fold(0.0, f32::max)
    }

    #[test]
    fn what_moves_stays_on_the_window_device() {
        let Some(window) = window() else { return };
        let mut drawing = Drawing::new("wgpu", &window);
        let opened = scene();
        let texture = drawing.texture(&opened);
        let mut renderer = Renderer::open("wgpu", |_| {}).unwrap();
        let expected = renderer.render(&opened.scene).unwrap().image;
        let off = largest_difference(&bytes(&window, &texture), &expected);
        // Rounded to whole numbers, by one device and another.
        assert!(off < 0.51, "{off}");
        assert!(expected.pixels().iter().any(|pixel| pixel[0] != expected.pixels()[0][0]));
    }

    #[test]
    fn what_is_at_rest_compared_or_finished_is_read_back() {
        let Some(window) = window() else { return };
        let mut drawing = Drawing::new("wgpu", &window);
        let mut opened = scene();
        for (urgency, is_read_back) in [(Urgency::AtRest, false), (Urgency::Moving, true)] {
            let event = drawing.ask(&opened, urgency, is_read_back);
            assert!(matches!(event, Event::Drawn(_)), "{event:?}");
        }
        opened.scene.finish = Finish::default().background_below([0.0, 0.0, 1.0, 1.0]);
        let event = drawing.ask(&opened, Urgency::Moving, false);
        assert!(matches!(event, Event::Drawn(_)), "{event:?}");
        let mut on_cpu = Drawing::new("cpu", &window);
        let event = on_cpu.ask(&scene(), Urgency::Moving, false);
        assert!(matches!(event, Event::Drawn(_)), "{event:?}");
    }

    #[test]
    fn a_texture_stays_as_it_is_while_it_is_shown() {
        let Some(window) = window() else { return };
        let mut drawing = Drawing::new("wgpu", &window);
        let mut opened = scene();
        let first = drawing.texture(&opened);
        let before = bytes(&window, &first);
        let mut textures = vec![first.texture().clone()];
        let mut shown = first.clone();
        for step in 1..8 {
            opened.scene.camera = opened.scene.camera.magnified(1.1).unwrap();
            let next = drawing.texture(&opened);
            assert_ne!(next.texture(), shown.texture(), "frame {step} is drawn over what is shown");
            if !textures.contains(next.texture()) {
                textures.push(next.texture().clone());
            }
            shown = next;
        }
        assert_eq!(bytes(&window, &first), before);
        assert_ne!(bytes(&window, &shown), before, "it was magnified");
        assert!(textures.len() <= 3, "{} textures", textures.len());
    }

    #[test]
    fn what_a_lost_window_device_does_not_draw_is_read_back() {
        let Some(window) = window() else { return };
        let mut drawing = Drawing::new("wgpu", &window);
        drop(drawing.texture(&scene()));
        window.0.destroy();
        for _ in 0..2 {
            let event = drawing.ask(&scene(), Urgency::Moving, false);
            assert!(matches!(event, Event::Drawn(_)), "{event:?}");
        }
        let notes = &drawing.notes;
        assert!(notes.len() == 1 && notes[0].ends_with("frames are read back"), "{notes:?}");
    }

    #[test]
    fn a_scene_that_cannot_be_drawn_fails_and_the_next_does_not() {
        let Some(window) = window() else { return };
        let mut drawing = Drawing::new("wgpu", &window);
        let mut opened = scene();
        opened.scene.settings.mode = slabsplat::Mode::Isosurfaces;
        let event = drawing.ask(&opened, Urgency::Moving, false);
        assert!(matches!(event, Event::Failed { number: 1, .. }), "{event:?}");
        drop(drawing.texture(&scene()));
    }
}
