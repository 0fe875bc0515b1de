//! What is kept of a relevant voxel between frames.

use bytemuck::{Pod, Zeroable};

/// One relevant voxel (§4): where it is, and which way its surface faces.
///
/// The layout is part of the contract with the backends, which copy it to their devices as it is.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct VoxelRecord {
    /// The voxel's place in memory, x fastest.
    pub voxel_idx: u32,
    /// `−∇v/|∇v|` in world space; zero where the gradient is zero.
    pub normal_in_world: [f32; 3],
}

const _: () = assert!(size_of::<VoxelRecord>() == 16, "a relevant voxel takes 16 bytes");
