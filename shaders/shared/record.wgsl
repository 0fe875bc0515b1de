// What is kept of a relevant voxel for as long as the transfer function stays.

struct Record {
    // −∇v/|∇v| in world space; zero where there is no gradient.
    normal: vec3<f32>,
    // The voxel's place in memory, x fastest.
    voxel_idx: u32,
    // Red, green, blue before shading, and the weight of the voxel in a sheet: opacity or extinction.
    color: vec4<f32>,
}
