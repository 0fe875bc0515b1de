//! What is kept of a relevant voxel between frames.

/// One relevant voxel (§4): where it is, and which way its surface faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelRecord {
    /// The voxel's place in memory, x fastest.
    pub voxel_idx: u32,
    /// `−∇v/|∇v|` in world space; zero where the gradient is zero.
    pub normal_in_world: [f32; 3],
}

const _: () = assert!(size_of::<VoxelRecord>() == 16, "a relevant voxel takes 16 bytes");
