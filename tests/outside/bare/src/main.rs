//! A window of winit's that shows a volume, with wgpu and nothing else: slabsplat draws on the window's
//! device into a texture of the window's, and the window presents that. Drag to turn the volume.
//!
//! ```text
//! bare [VOLUME]
//! ```
//!
//! `shown.rs` has all of wgpu; a game or a viewer with a device of its own does the same.

mod shown;

use shown::Shown;
use slabsplat::{Automatic, ImageDesc, RenderSettings, Scene, io};
use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseButton, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::WindowId;

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "neuron".to_owned());
    let automatic = if Path::new(&name).exists() {
        Automatic::new(io::read_volume(&name)?.volume)
    } else {
        Automatic::new(io::builtin_volume(&name, None)?)
    };
    // Nothing shows through a window.
    let image = ImageDesc::new(800, 600).background([0.02, 0.02, 0.04, 1.0]);
    let scene = automatic.scene(image, RenderSettings::default());
    let mut app = App { scene, shown: None, pointer_x: 0.0, is_dragged: false, result: Ok(()) };
    EventLoop::new()?.run_app(&mut app)?;
    app.result
}

struct App {
    scene: Scene,
    shown: Option<Shown>,
    /// In pixels.
    pointer_x: f64,
    is_dragged: bool,
    result: Result<(), Box<dyn Error>>,
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        match Shown::open(event_loop, &self.scene) {
            Ok(shown) => self.shown = Some(shown),
            Err(error) => self.end(event_loop, Err(error)),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(shown) = &mut self.shown else { return };
        let result = match event {
            WindowEvent::CloseRequested => return self.end(event_loop, Ok(())),
            WindowEvent::Resized(size) => shown.resize(&mut self.scene, size),
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                self.is_dragged = state == ElementState::Pressed;
                Ok(())
            }
            WindowEvent::CursorMoved { position, .. } => {
                let right = position.x - self.pointer_x;
                self.pointer_x = position.x;
                if self.is_dragged {
                    // Across the window is half a turn.
                    let radians = -PI * right / f64::from(self.scene.image.width);
                    self.scene.camera = self.scene.camera.orbited(radians);
                    shown.change();
                }
                Ok(())
            }
            WindowEvent::RedrawRequested => shown.redraw(&self.scene),
            _ => Ok(()),
        };
        if result.is_err() {
            self.end(event_loop, result);
        }
    }
}

impl App {
    fn end(&mut self, event_loop: &ActiveEventLoop, result: Result<(), Box<dyn Error>>) {
        self.result = result;
        event_loop.exit();
    }
}
