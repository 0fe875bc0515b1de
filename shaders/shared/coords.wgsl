// Where a voxel is in index space, from its index in memory, x fastest.
fn coords_of(voxel_idx: u32, dims: vec3<u32>) -> vec3<u32> {
    let row = voxel_idx / dims.x;
    return vec3(voxel_idx - row * dims.x, row % dims.y, row / dims.y);
}
