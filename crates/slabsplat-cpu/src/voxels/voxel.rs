//! A relevant voxel, ready to be splatted.

/// A voxel in view space, shaded; `S` says which sheets it goes to. Half a cache line, as tiles stream
/// through them.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Voxel<S> {
    /// Right, up, and depth from the centre of what is seen.
    pub(crate) point: [f32; 3],
    /// A [`Span`](crate::sections::span::Span) of slabs, a slice, or nothing where each voxel is a sheet of
    /// its own.
    pub(crate) sheets: S,
    /// What a sheet sums, at weight 1.
    pub(crate) color: [f32; 4],
}

const _: () = assert!(size_of::<Voxel<u32>>() == 32, "half a cache line");
