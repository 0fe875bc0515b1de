// Surface normals from central differences (model §6): one-sided where a neighbour is outside of the grid or
// NaN, zero where both are.

struct Derivative {
    change: Scaled,
    is_finite: bool,
}

// The derivative along one axis.
fn derivative(sample_idx: u32, here: vec2<u32>, coord: u32, n: u32, stride: u32) -> Derivative {
    var before = here;
    var after = here;
    var n_steps = 0;
    if 0u < coord {
        let bits = sample_bits(sample_idx - stride);
        if !is_nan(bits) {
            before = bits;
            n_steps++;
        }
    }
    if coord + 1u < n {
        let bits = sample_bits(sample_idx + stride);
        if !is_nan(bits) {
            after = bits;
            n_steps++;
        }
    }
    if n_steps == 0 {
        return Derivative(Scaled(0.0, EXPONENT_OF_ZERO), true);
    }
    let is_finite = !has_largest_exponent(before) && !has_largest_exponent(after);
    let over_steps = difference(before, after);
    // Half of it if there are two steps.
    return Derivative(Scaled(over_steps.fraction, over_steps.exponent + 1 - n_steps), is_finite);
}

fn normal_at(voxel_idx: u32, here: vec2<u32>) -> vec3<f32> {
    let nx = volume.dims.x;
    let plane = nx * volume.dims.y;
    let coords = coords_of(voxel_idx, volume.dims);
    let dx = derivative(voxel_idx, here, coords.x, nx, 1u);
    let dy = derivative(voxel_idx, here, coords.y, volume.dims.y, nx);
    let dz = derivative(voxel_idx, here, coords.z, volume.dims.z, plane);
    if !(dx.is_finite && dy.is_finite && dz.is_finite) {
        return vec3(0.0);
    }
    // Scaled before products and the length are taken: squares of tiny differences would underflow.
    let exponent = max(dx.change.exponent, max(dy.change.exponent, dz.change.exponent));
    var in_index = vec3(
        scaled_by(dx.change, exponent),
        scaled_by(dy.change, exponent),
        scaled_by(dz.change, exponent),
    );
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
