//! What egui calls textures that frames were drawn into.

use crate::frames::WindowTexture;
use eframe::egui::TextureId;
use eframe::egui_wgpu::RenderState;
use slabsplat::wgpu::{FilterMode, TextureViewDescriptor};

/// A name for each pane, which stands for whatever texture the pane shows.
#[derive(Debug, Default)]
pub(super) struct Textures(Vec<Option<TextureId>>);

impl Textures {
    /// What the texture is called from now on.
    pub(super) fn id_of(
        &mut self,
        egui: &RenderState,
        pane_idx: usize,
        texture: &WindowTexture,
    ) -> TextureId {
        let view = texture.texture().create_view(&TextureViewDescriptor::default());
        if self.0.len() <= pane_idx {
            self.0.resize(pane_idx + 1, None);
        }
        let (device, filter) = (&egui.device, FilterMode::Linear);
        let mut renderer = egui.renderer.write();
        match self.0[pane_idx] {
            Some(id) => {
                renderer.update_egui_texture_from_wgpu_texture(device, &view, filter, id);
                id
            }
            None => {
                let id = renderer.register_native_texture(device, &view, filter);
                *self.0[pane_idx].insert(id)
            }
        }
    }
}
