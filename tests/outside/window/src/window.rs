//! The window: sliders, a picture, and the mouse on it.

use crate::{By, Orbit, Picture};
use eframe::egui::{self, Rect, Sense, TextureId, Ui};
use eframe::egui_wgpu::RenderState;
use slabsplat::wgpu::{FilterMode, Texture, TextureViewDescriptor};
use slabsplat::{
    Automatic, ImageDesc, RenderSettings, Scene, TextureTarget, TransferError, TransferFunction,
    Volume,
};
use std::error::Error;
use std::sync::Arc;

/// A window on a volume.
pub struct Window {
    picture: Picture,
    scene: Scene,
    orbit: Orbit,
    /// As it was found for the volume.
    transfer: TransferFunction,
    opacity: f64,
    egui: RenderState,
    /// What egui calls the texture.
    shown: Option<(Texture, TextureId)>,
    complaint: Option<String>,
}

impl Window {
    /// A window that shows all of the volume.
    ///
    /// # Errors
    /// If egui has no device, or nothing draws.
    pub fn new(
        context: &eframe::CreationContext<'_>,
        volume: Arc<Volume>,
        by: By,
    ) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let egui = context.wgpu_render_state.clone().ok_or("egui does not draw by wgpu")?;
        let picture = Picture::new(&egui.device, &egui.queue, by)?;
        let automatic = Automatic::new(volume);
        let image = ImageDesc::default();
        let mut scene = automatic.scene(image, RenderSettings::default());
        scene.camera = automatic.camera(&image, true);
        Ok(Self {
            picture,
            orbit: Orbit::new(scene.camera),
            transfer: automatic.transfer().clone(),
            scene,
            opacity: 1.0,
            egui,
            shown: None,
            complaint: None,
        })
    }

    /// The sliders, and what is known of frames.
    fn settings(&mut self, ui: &mut Ui) {
        let width = &mut self.scene.settings.slab_width;
        let width = egui::Slider::new(width, 0.25..=4.0).logarithmic(true).text("slab width");
        let opacity = egui::Slider::new(&mut self.opacity, 0.02..=1.0).logarithmic(true);
        let has_new_width = ui.add(width).changed();
        if ui.add(opacity.text("opacity")).changed() {
            match fainter(&self.transfer, self.opacity) {
                Ok(transfer) => self.scene.layers[0].transfer = transfer,
                Err(error) => self.complaint = Some(error.to_string()),
            }
            self.picture.change();
        }
        if has_new_width {
            self.picture.change();
        }
        ui.label(self.picture.drawn_by());
        if self.picture.is_under_way() {
            ui.add(egui::ProgressBar::new(self.picture.progress()));
        }
        if let Some(complaint) = &self.complaint {
            ui.colored_label(ui.visuals().error_fg_color, complaint);
        }
    }

    /// The picture, as large as there is room, and what the mouse does on it.
    fn volume(&mut self, ui: &mut Ui) {
        let (rect, mouse) = ui.allocate_exact_size(ui.available_size(), Sense::drag());
        let dragged = mouse.drag_delta() / rect.height().max(1.0);
        if dragged != egui::Vec2::ZERO {
            self.orbit.drag(dragged.x.into(), dragged.y.into());
            self.picture.change();
        }
        let wheel =
            if mouse.hovered() { ui.input(|input| input.smooth_scroll_delta().y) } else { 0.0 };
        if wheel != 0.0 {
            self.orbit.magnify(f64::from(wheel / 300.0).exp());
            self.picture.change();
        }
        let pixels = rect.size() * ui.ctx().pixels_per_point();
        let size = [pixels.x, pixels.y].map(|side| (side.round() as u32).clamp(1, 4096));
        if size != [self.scene.image.width, self.scene.image.height] {
            [self.scene.image.width, self.scene.image.height] = size;
            self.picture.change();
        }
        self.show(ui, rect);
    }

    fn show(&mut self, ui: &mut Ui, rect: Rect) {
        if let Ok(camera) = self.orbit.camera() {
            self.scene.camera = camera;
        }
        match self.picture.update(&self.scene).map(|target| target.map(TextureTarget::texture)) {
            Ok(Some(texture)) if self.shown.as_ref().map(|(known, _)| known) != Some(texture) => {
                let texture = texture.clone();
                self.show_instead(texture);
            }
            Ok(_) => {}
            Err(error) => self.complaint = Some(error.to_string()),
        }
        if let Some((_, id)) = self.shown {
            let all = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            ui.painter().image(id, rect, all, egui::Color32::WHITE);
        }
        if self.picture.is_under_way() {
            ui.ctx().request_repaint();
        }
    }

    /// Tells egui of a texture: the first, or a new one after the window was resized.
    fn show_instead(&mut self, texture: Texture) {
        let (device, mut egui) = (&self.egui.device, self.egui.renderer.write());
        let view = texture.create_view(&TextureViewDescriptor::default());
        let id = match self.shown {
            None => egui.register_native_texture(device, &view, FilterMode::Linear),
            Some((_, id)) => {
                let linear = FilterMode::Linear;
                egui.update_egui_texture_from_wgpu_texture(device, &view, linear, id);
                id
            }
        };
        self.shown = Some((texture, id));
    }
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        egui::Panel::top("settings").show(ui, |ui| ui.horizontal_wrapped(|ui| self.settings(ui)));
        egui::CentralPanel::no_frame().show(ui, |ui| self.volume(ui));
    }
}

/// The same colours with so many times the opacity.
fn fainter(transfer: &TransferFunction, times: f64) -> Result<TransferFunction, TransferError> {
    let fainter = |&(value, [opacity]): &(f64, [f64; 1])| (value, [opacity * times]);
    let opacities: Vec<_> = transfer.opacity_points().points().iter().map(fainter).collect();
    TransferFunction::new(opacities, transfer.color_points().points().to_vec())
}
