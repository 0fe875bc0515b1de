//! A window that shows a volume: drag to turn it, turn the wheel to zoom, and move the sliders.
//!
//! ```text
//! window [--cpu | --gpu] [VOLUME]
//! ```
//!
//! `VOLUME` is a file, or a built-in volume (`neuron` if nothing is said). Frames are drawn by the graphics
//! card that draws the window, on the same device, straight into a texture of the window's. Where there is
//! none that runs the shaders, or only software that plays one, a thread draws on the CPU; `--gpu` and
//! `--cpu` force the one or the other. The window never waits for a frame.
//!
//! What is of interest is in `picture.rs`: [`slabsplat::TextureRenderer`] and a texture. `orbit.rs` makes a
//! camera of what the mouse does, and `window.rs` is egui.

use eframe::egui_wgpu::{WgpuSetup, WgpuSetupCreateNew};
use slabsplat::wgpu::Adapter;
use std::error::Error;
use std::sync::Arc;
use window::{By, Window, open};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut by, mut volume) = (By::Best, "neuron".to_owned());
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--cpu" => by = By::Cpu,
            "--gpu" => by = By::Gpu,
            flag if flag.starts_with('-') => return Err(format!("there is no flag {flag}").into()),
            name => volume = name.to_owned(),
        }
    }
    let volume = open(&volume)?;
    let mut options = eframe::NativeOptions::default();
    options.wgpu_options.wgpu_setup = with_frames();
    // Pixels are shown as they were drawn.
    options.dithering = false;
    let create = move |context: &eframe::CreationContext<'_>| {
        let window: Box<dyn eframe::App> = Box::new(Window::new(context, volume, by)?);
        Ok(window)
    };
    Ok(eframe::run_native("slabsplat", options, Box::new(create))?)
}

/// egui asks for a device; what frames need is added to that.
fn with_frames() -> WgpuSetup {
    let own = WgpuSetupCreateNew::without_display_handle();
    let of_egui = own.device_descriptor.clone();
    let device_descriptor =
        Arc::new(move |adapter: &Adapter| slabsplat::device_descriptor(adapter, of_egui(adapter)));
    WgpuSetup::CreateNew(WgpuSetupCreateNew { device_descriptor, ..own })
}
