// What is stored of a relevant voxel while all stays that decides how it looks. `classify_emit` writes it, or the
// host, where labels or gradients decide beside values.

struct Record {
    // −∇v/|∇v| in world space; zero where there is no gradient.
    normal: vec3<f32>,
    // The voxel's index in memory, x fastest.
    voxel_idx: u32,
    // Red, green, blue before shading, and the weight of the voxel in a sheet: opacity or extinction.
    color: vec4<f32>,
}
