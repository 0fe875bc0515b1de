// Surface normals from central differences (SPEC §6): one-sided where a neighbour is outside of the grid or
// NaN, zero where both are.

fn difference(a: vec2<u32>, b: vec2<u32>) -> f32 {
    let low = number_of(a);
    let high = number_of(b);
    return (high.x - low.x) + (high.y - low.y);
}

// The derivative along one axis, and whether it is finite.
fn derivative(sample_idx: u32, here: vec2<u32>, coord: u32, n: u32, stride: u32) -> vec2<f32> {
    var before = here;
    var after = here;
    var n_steps = 0.0;
    if 0u < coord {
        let bits = sample_bits(sample_idx - stride);
        if !is_nan(bits) {
            before = bits;
            n_steps += 1.0;
        }
    }
    if coord + 1u < n {
        let bits = sample_bits(sample_idx + stride);
        if !is_nan(bits) {
            after = bits;
            n_steps += 1.0;
        }
    }
    let is_infinite = has_largest_exponent(before) || has_largest_exponent(after);
    if n_steps == 0.0 {
        return vec2(0.0, 1.0);
    }
    return vec2(difference(before, after) / n_steps, select(1.0, 0.0, is_infinite));
}

fn normal_at(voxel_idx: u32, here: vec2<u32>) -> vec3<f32> {
    let nx = volume.dims.x;
    let plane = nx * volume.dims.y;
    let coords = coords_of(voxel_idx, volume.dims);
    let dx = derivative(voxel_idx, here, coords.x, nx, 1u);
    let dy = derivative(voxel_idx, here, coords.y, volume.dims.y, nx);
    let dz = derivative(voxel_idx, here, coords.z, volume.dims.z, plane);
    if dx.y * dy.y * dz.y == 0.0 {
        return vec3(0.0);
    }
    // Scaled before products and the length are taken: squares of tiny differences would underflow.
    var in_index = vec3(dx.x, dy.x, dz.x);
    let steepest = max(abs(in_index.x), max(abs(in_index.y), abs(in_index.z)));
    if steepest == 0.0 {
        return vec3(0.0);
    }
    in_index /= steepest;
    let in_world = vec3(
        dot(volume.gradient_x.xyz, in_index),
        dot(volume.gradient_y.xyz, in_index),
        dot(volume.gradient_z.xyz, in_index),
    );
    let longest = max(abs(in_world.x), max(abs(in_world.y), abs(in_world.z)));
    if longest == 0.0 {
        return vec3(0.0);
    }
    return -normalize(in_world / longest);
}
