//! What egui calls textures that frames were drawn into.

use crate::frames::WindowTexture;
use eframe::egui::TextureId;
#[cfg(not(target_arch = "wasm32"))]
use slabsplat::wgpu::{FilterMode, TextureViewDescriptor};

/// A name for each pane, which stands for whatever texture the pane shows.
#[derive(Debug, Default)]
pub(super) struct Textures(Vec<Option<TextureId>>);

#[cfg(not(target_arch = "wasm32"))]
impl Textures {
    /// What the texture is called from now on; nothing if the window is not drawn by wgpu.
    pub(super) fn id_of(
        &mut self,
        window: &eframe::Frame,
        pane_idx: usize,
        texture: &WindowTexture,
    ) -> Option<TextureId> {
        let egui = window.wgpu_render_state()?;
        let view = texture.texture().create_view(&TextureViewDescriptor::default());
        if self.0.len() <= pane_idx {
            self.0.resize(pane_idx + 1, None);
        }
        let (device, filter) = (&egui.device, FilterMode::Linear);
        let mut renderer = egui.renderer.write();
        let known = self.0[pane_idx];
        if let Some(id) = known {
            renderer.update_egui_texture_from_wgpu_texture(device, &view, filter, id);
        } else {
            self.0[pane_idx] = Some(renderer.register_native_texture(device, &view, filter));
        }
        self.0[pane_idx]
    }
}

#[cfg(target_arch = "wasm32")]
impl Textures {
    /// Nothing: a page is drawn by WebGL, and textures of WebGPU are not to be seen there.
    pub(super) fn id_of(
        &mut self,
        _: &eframe::Frame,
        _: usize,
        _: &WindowTexture,
    ) -> Option<TextureId> {
        None
    }
}
