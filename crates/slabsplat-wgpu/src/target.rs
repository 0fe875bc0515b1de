//! Textures of the caller's that pictures go to.

use crate::WgpuDevice;
use crate::present::Canvas;
use slabsplat_gpu::{Destination, DeviceError, Picture};
use std::sync::Arc;
use thiserror::Error;

/// A texture that frames are left in, on the device that it belongs to. It holds the texture and nothing
/// else; clones are one target. Made once for a texture, and not for every frame. One of another device is
/// refused, with an error; of another instance of wgpu, wgpu panics about it, as it does everywhere.
///
/// The texture is one of two dimensions, with one sample a pixel, and one of [`FORMATS`](Self::FORMATS); of
/// several mip levels or layers the first is drawn. It gets premultiplied colours. Formats of 8 bits hold the
/// numbers that a PNG of the picture has, but for its being premultiplied, whether or not they have the
/// transfer curve of sRGB; formats of floats hold the same numbers as fractions of 1.
#[derive(Clone, Debug)]
pub struct TextureTarget(Arc<Target>);

#[derive(Debug)]
struct Target {
    texture: wgpu::Texture,
    format: PixelFormat,
    /// If it can be drawn into.
    view: Option<wgpu::TextureView>,
}

/// The formats that pictures can have in a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum PixelFormat {
    Rgba8 { is_srgb: bool },
    Bgra8 { is_srgb: bool },
    Rgba16Float,
    Rgba32Float,
}

/// Why a texture takes no picture.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum TargetError {
    /// It has a format that pictures have not.
    #[error(
        "pictures do not go into textures of the format {format:?}, but into {:?}",
        TextureTarget::FORMATS
    )]
    Format {
        /// The texture's.
        format: wgpu::TextureFormat,
    },
    /// It is none of two dimensions and one sample a pixel.
    #[error(
        "pictures go into textures of two dimensions with one sample a pixel, not of {dimension:?} with \
         {n_samples}"
    )]
    Shape {
        /// The texture's.
        dimension: wgpu::TextureDimension,
        /// The texture's.
        n_samples: u32,
    },
    /// It was made for other uses.
    #[error("the texture must be made with the usage {missing:?}, to have pictures")]
    Usage {
        /// What it lacks.
        missing: wgpu::TextureUsages,
    },
    /// It has another size than the picture.
    #[error(
        "a picture of {} x {} pixels does not go into a texture of {} x {}", picture[0], picture[1],
        texture[0], texture[1]
    )]
    Size {
        /// Columns and rows of the picture.
        picture: [u32; 2],
        /// Columns and rows of the texture.
        texture: [u32; 2],
    },
}

impl TextureTarget {
    /// The usages that a texture needs for pictures from a device and from the CPU alike: the first to be
    /// drawn into, the second to be [written](Self::write).
    pub const USAGES: wgpu::TextureUsages =
        wgpu::TextureUsages::RENDER_ATTACHMENT.union(wgpu::TextureUsages::COPY_DST);

    /// The formats that it may have.
    pub const FORMATS: [wgpu::TextureFormat; 6] = [
        wgpu::TextureFormat::Rgba8Unorm,
        wgpu::TextureFormat::Rgba8UnormSrgb,
        wgpu::TextureFormat::Bgra8Unorm,
        wgpu::TextureFormat::Bgra8UnormSrgb,
        wgpu::TextureFormat::Rgba16Float,
        wgpu::TextureFormat::Rgba32Float,
    ];

    /// A texture as a target.
    ///
    /// # Errors
    /// If pictures cannot go there: by its format, or by its shape.
    pub fn new(texture: &wgpu::Texture) -> Result<Self, TargetError> {
        let format = texture.format();
        let format = PixelFormat::new(format).ok_or(TargetError::Format { format })?;
        let (dimension, n_samples) = (texture.dimension(), texture.sample_count());
        if dimension != wgpu::TextureDimension::D2 || n_samples != 1 {
            return Err(TargetError::Shape { dimension, n_samples });
        }
        let is_drawable = texture.usage().contains(wgpu::TextureUsages::RENDER_ATTACHMENT);
        let view = is_drawable.then(|| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                label: Some("slabsplat picture"),
                dimension: Some(wgpu::TextureViewDimension::D2),
                mip_level_count: Some(1),
                array_layer_count: Some(1),
                ..wgpu::TextureViewDescriptor::default()
            })
        });
        Ok(Self(Arc::new(Target { texture: texture.clone(), format, view })))
    }

    /// The texture.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.0.texture
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        self.0.size()
    }

    /// Whether a device can draw pictures of so many columns and rows into it.
    ///
    /// # Errors
    /// If not.
    pub fn check_drawable(&self, size: [u32; 2]) -> Result<(), TargetError> {
        self.0.check(size, wgpu::TextureUsages::RENDER_ATTACHMENT)
    }

    /// Whether pictures of so many columns and rows can be [written](Self::write) to it.
    ///
    /// # Errors
    /// If not.
    pub fn check_writable(&self, size: [u32; 2]) -> Result<(), TargetError> {
        self.0.check(size, wgpu::TextureUsages::COPY_DST)
    }

    /// Writes a picture that is on the CPU: columns and rows, and premultiplied RGBA from the top. It is
    /// there for all that is submitted to the queue from now on.
    ///
    /// # Errors
    /// If the texture has another size, or lacks the usage `COPY_DST`.
    ///
    /// # Panics
    /// If there are fewer pixels than that.
    pub fn write(
        &self,
        queue: &wgpu::Queue,
        size: [u32; 2],
        pixels: &[[f32; 4]],
    ) -> Result<(), TargetError> {
        self.check_writable(size)?;
        let [width, height] = size;
        let pixels = &pixels[..width as usize * height as usize];
        let bytes: Vec<u8> = match self.0.format {
            PixelFormat::Rgba8 { .. } => pixels.iter().flat_map(|&pixel| bytes(pixel)).collect(),
            PixelFormat::Bgra8 { .. } => {
                pixels.iter().flat_map(|&[r, g, b, a]| bytes([b, g, r, a])).collect()
            }
            PixelFormat::Rgba16Float => {
                let halves = pixels.as_flattened().iter();
                halves.flat_map(|&value| half(value).to_ne_bytes()).collect()
            }
            PixelFormat::Rgba32Float => {
                pixels.as_flattened().iter().flat_map(|value| value.to_ne_bytes()).collect()
            }
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * self.0.format.n_bytes()),
            rows_per_image: None,
        };
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        queue.write_texture(self.0.texture.as_image_copy(), &bytes, layout, extent);
        Ok(())
    }

    /// The same as a destination that a [`GpuBackend`](slabsplat_gpu::GpuBackend) leaves pictures in.
    pub fn destination(&self) -> Arc<dyn Destination<WgpuDevice>> {
        self.0.clone()
    }
}

impl Target {
    fn size(&self) -> [u32; 2] {
        [self.texture.width(), self.texture.height()]
    }

    fn check(&self, size: [u32; 2], usage: wgpu::TextureUsages) -> Result<(), TargetError> {
        let missing = usage - self.texture.usage();
        if !missing.is_empty() {
            return Err(TargetError::Usage { missing });
        }
        if size != self.size() {
            return Err(TargetError::Size { picture: size, texture: self.size() });
        }
        Ok(())
    }
}

impl Destination<WgpuDevice> for Target {
    fn check_size(&self, size: [u32; 2]) -> Result<(), String> {
        let checked = self.check(size, wgpu::TextureUsages::RENDER_ATTACHMENT);
        checked.map_err(|error| error.to_string())
    }

    fn take(&self, device: &mut WgpuDevice, picture: &Picture) -> Result<(), DeviceError> {
        let view = self.view.as_ref().ok_or_else(|| {
            let missing = wgpu::TextureUsages::RENDER_ATTACHMENT;
            DeviceError::Refused { reason: TargetError::Usage { missing }.to_string() }
        })?;
        device.present(picture, Canvas { view, format: self.format })
    }
}

impl PixelFormat {
    fn new(format: wgpu::TextureFormat) -> Option<Self> {
        Some(match format {
            wgpu::TextureFormat::Rgba8Unorm => Self::Rgba8 { is_srgb: false },
            wgpu::TextureFormat::Rgba8UnormSrgb => Self::Rgba8 { is_srgb: true },
            wgpu::TextureFormat::Bgra8Unorm => Self::Bgra8 { is_srgb: false },
            wgpu::TextureFormat::Bgra8UnormSrgb => Self::Bgra8 { is_srgb: true },
            wgpu::TextureFormat::Rgba16Float => Self::Rgba16Float,
            wgpu::TextureFormat::Rgba32Float => Self::Rgba32Float,
            _ => return None,
        })
    }

    pub(crate) fn of_wgpu(self) -> wgpu::TextureFormat {
        match self {
            Self::Rgba8 { is_srgb: false } => wgpu::TextureFormat::Rgba8Unorm,
            Self::Rgba8 { is_srgb: true } => wgpu::TextureFormat::Rgba8UnormSrgb,
            Self::Bgra8 { is_srgb: false } => wgpu::TextureFormat::Bgra8Unorm,
            Self::Bgra8 { is_srgb: true } => wgpu::TextureFormat::Bgra8UnormSrgb,
            Self::Rgba16Float => wgpu::TextureFormat::Rgba16Float,
            Self::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
        }
    }

    /// Of a pixel.
    fn n_bytes(self) -> u32 {
        match self {
            Self::Rgba8 { .. } | Self::Bgra8 { .. } => 4,
            Self::Rgba16Float => 8,
            Self::Rgba32Float => 16,
        }
    }
}

/// Fractions of 1 as bytes; NaN becomes 0 in the cast.
fn bytes(pixel: [f32; 4]) -> [u8; 4] {
    pixel.map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// The nearest number of 16 bits, the even one of two.
fn half(value: f32) -> u16 {
    let sign = (value.to_bits() >> 16) as u16 & 0x8000;
    let bits = value.abs().to_bits();
    let magnitude = match bits {
        // NaN, and what is beyond the largest.
        0x7f80_0001.. => 0x7e00,
        0x4780_0000.. => 0x7c00,
        // Of normal numbers the exponent has another offset; rounding may carry into it.
        0x3880_0000.. => ((bits + 0x0fff + (bits >> 13 & 1) - 0x3800_0000) >> 13) as u16,
        // Below, they are multiples of 2^-24.
        _ => (value.abs() * 16_777_216.0).round_ties_even() as u16,
    };
    sign | magnitude
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_the_nearest() {
        let check = |value: f32, expected: u16| assert_eq!(half(value), expected, "{value}");
        check(0.0, 0);
        check(-0.0, 0x8000);
        check(1.0, 0x3c00);
        check(-2.0, 0xc000);
        check(0.1, 0x2e66);
        check(65504.0, 0x7bff);
        check(65519.0, 0x7bff);
        check(65520.0, 0x7c00);
        check(1e9, 0x7c00);
        check(f32::INFINITY, 0x7c00);
        check(f32::NAN, 0x7e00);
        check(6.1035156e-5, 0x0400);
        check(5.9604645e-8, 1);
        check(2.9802322e-8, 0);
        check(8.940697e-8, 2);
        // Halfway between two: the even one.
        check(1.0 + 2.0_f32.powi(-11), 0x3c00);
        check(1.0 + 3.0 * 2.0_f32.powi(-11), 0x3c02);
    }

    #[test]
    fn bytes_are_clamped() {
        assert_eq!(bytes([0.5, 2.0, -1.0, f32::NAN]), [128, 255, 0, 0]);
    }

    #[test]
    fn formats_are_those_told() {
        for format in TextureTarget::FORMATS {
            let of_pixel = PixelFormat::new(format).unwrap();
            assert_eq!(of_pixel.of_wgpu(), format);
            assert_eq!(format.block_copy_size(None), Some(of_pixel.n_bytes()));
        }
        assert_eq!(PixelFormat::new(wgpu::TextureFormat::R8Unorm), None);
    }
}
