// A voxel that was shaded and projected, ready to be splatted.

struct Splat {
    // Right, up and depth.
    center: vec3<f32>,
    // The slabs in which it is drawn, a span of `slabs.wgsl`, or its slice; every-sample has no sheets.
    span: u32,
    // What a sheet sums (model §3).
    color: vec4<f32>,
}
