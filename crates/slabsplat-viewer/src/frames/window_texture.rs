//! A picture where it was drawn: a texture of the window's device.

use slabsplat::TextureTarget;
use slabsplat::wgpu::Texture;
use std::sync::Arc;

/// A picture in a texture of the window's device, which stays what it is as long as one has it.
#[derive(Clone, Debug)]
pub struct WindowTexture(Arc<TextureTarget>);

impl WindowTexture {
    /// The texture.
    pub fn texture(&self) -> &Texture {
        self.0.texture()
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        self.0.size()
    }
}

#[cfg(not(target_arch = "wasm32"))]
impl WindowTexture {
    pub(super) fn new(target: TextureTarget) -> Self {
        Self(Arc::new(target))
    }

    pub(super) fn target(&self) -> &TextureTarget {
        &self.0
    }

    /// Whether anybody but who asks has it.
    pub(super) fn is_shown(&self) -> bool {
        1 < Arc::strong_count(&self.0)
    }
}
