//! From view space to pixels: where a splat lies, and the ellipse that it covers.

use slabsplat_backend::LayerPlan;
use slabsplat_core::View;
use slabsplat_kernel::FootprintShape;

/// Everything about pixels that all splats of a frame share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Raster {
    view: View,
    pub(crate) shape: FootprintShape,
    /// Where the optical axis is, in pixels from the corner of the image's border.
    center: [f32; 2],
    /// The kernel's radius in index space.
    pub(crate) radius: f32,
    /// Half the thickness of a voxel's kernel along the viewing direction, in world units.
    pub(crate) half_depth: f32,
    /// Least depth at which anything is drawn.
    pub(crate) near: f32,
    /// Index-space length of a ray over one world unit of depth.
    pub(crate) index_per_depth: f32,
    /// Whether slab faces cut the rays of a footprint at different offsets.
    pub(crate) is_tilted: bool,
    /// Whether the axes of footprints are not those of the image.
    pub(crate) is_sheared: bool,
}

/// The footprint in pixels, at one depth; y runs downwards.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PixelShape {
    /// `2·(ρ/R)² = across·(X + shear·Y)² + along·Y²`, 0 at the centre and 2 at the kernel's edge.
    pub(crate) across: f32,
    pub(crate) shear: f32,
    pub(crate) along: f32,
    /// By how many index units a slab face is cut later, per pixel.
    pub(crate) tilt: [f32; 2],
    /// Half the width and height of the ellipse `ρ = 1`.
    pub(crate) half_extent: [f32; 2],
    /// Where its farthest point is, from the centre.
    pub(crate) farthest: [f32; 2],
    /// Half the width and height of what a plane through the centre, parallel to slabs, has of it.
    pub(crate) half_across: [f32; 2],
    /// Pixels per world unit.
    pub(crate) scale: f32,
    /// What weights are multiplied with: 1, or less if the footprint is stretched.
    pub(crate) gain: f32,
}

/// The rectangles around footprints of one shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FootprintBounds {
    center: [f32; 2],
    scale: f32,
    half_extent: [f32; 2],
}

impl FootprintBounds {
    /// The pixels that the footprint of a point in view space covers: the least and the largest corner.
    #[inline(always)]
    pub(crate) fn at(&self, [right, up, _]: [f32; 3]) -> [[f32; 2]; 2] {
        let Self { center, scale, half_extent: [width, height] } = *self;
        let [x, y] = [center[0] + right * scale, center[1] - up * scale];
        [[x - width, y - height], [x + width, y + height]]
    }
}

impl Raster {
    /// For tiles of which `border` pixels on each side are their neighbours'.
    pub(crate) fn new(layer: &LayerPlan<'_>, border: usize) -> Self {
        let LayerPlan { view, shape, radius, half_depth, .. } = *layer;
        Self {
            view,
            shape,
            center: view.image_size().map(|side| 0.5 * side as f32 + border as f32),
            radius: radius as f32,
            half_depth: half_depth as f32,
            near: view.near_depth() as f32,
            index_per_depth: shape.index_per_depth as f32,
            is_tilted: shape.is_tilted(radius),
            is_sheared: shape.is_sheared(),
        }
    }

    /// The footprint at a depth from the centre, which must not lie before `near`.
    #[inline]
    pub(crate) fn shape_at(&self, depth: f64) -> PixelShape {
        self.shape_like(&self.shape, depth)
    }

    /// A footprint of another shape, at a depth.
    pub(crate) fn shape_like(&self, shape: &FootprintShape, depth: f64) -> PixelShape {
        let scale = self.view.pixels_per_world(depth);
        let stretch = self.view.stretch(scale);
        let pixels = scale * stretch;
        let FootprintShape { across, shear, along, half_extent, farthest, .. } = *shape;
        let [right, up] = shape.tilt.map(|c| (c / pixels) as f32);
        let radius_in_pixels = f64::from(self.radius) * pixels;
        let form = 2.0 / (radius_in_pixels * radius_in_pixels);
        let half_across = [0, 1].map(|axis| {
            let [extent, farthest] = [half_extent[axis], farthest[axis]];
            ((extent - farthest) * (extent + farthest)).max(0.0).sqrt()
        });
        let [far_right, far_up] = farthest.map(|c| (c * pixels) as f32);
        PixelShape {
            across: (form * across) as f32,
            shear: -shear as f32,
            along: (form * along) as f32,
            tilt: [right, -up],
            half_extent: half_extent.map(|c| (c * pixels) as f32),
            farthest: [far_right, -far_up],
            half_across: half_across.map(|c| (c * pixels) as f32),
            scale: scale as f32,
            gain: (1.0 / (stretch * stretch)) as f32,
        }
    }

    /// Where the optical axis is, in pixels from the corner of the image's border.
    pub(crate) fn center(&self) -> [f32; 2] {
        self.center
    }

    /// Where a point of view space lies, in pixels from the corner of the image's border.
    #[inline(always)]
    pub(crate) fn pixel_of(&self, shape: &PixelShape, [right, up, _]: [f32; 3]) -> [f32; 2] {
        [self.center[0] + right * shape.scale, self.center[1] - up * shape.scale]
    }

    /// The rectangle around whole footprints of a shape.
    #[inline(always)]
    pub(crate) fn bounds(&self, shape: &PixelShape) -> FootprintBounds {
        let [half_width, half_height] = shape.half_extent;
        FootprintBounds {
            center: self.center,
            scale: shape.scale,
            half_extent: [half_width * self.radius, half_height * self.radius],
        }
    }
}
