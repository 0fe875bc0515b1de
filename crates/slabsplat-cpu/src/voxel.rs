//! A relevant voxel, ready to be splatted.

/// A voxel in view space, shaded. Half a cache line, as tiles stream through them.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Voxel {
    /// Right, up, and depth from the grid's centre.
    pub(crate) point: [f32; 3],
    /// Which sheets it goes to: its slice in `axis-aligned`, its [`Span`](crate::image_aligned::Span) in
    /// `image-aligned`.
    pub(crate) sheets: u32,
    /// What a sheet sums, at weight 1.
    pub(crate) color: [f32; 4],
}

const _: () = assert!(size_of::<Voxel>() == 32, "half a cache line");
