// One word of what every-sample sorts by (paper §4: "with respect to their distance from the viewing plane").
//
// Whole planes of voxels are equally deep in many views, up to rounding, and the order among them shows. So
// depths are rounded to steps of 2^-20 unit, and equals are sorted by their position in the picture. That
// takes more digits than a float has: positions are fixed-point numbers of 64 bits, exact in any order of
// summation, and the list is sorted by one word after the other, the least important first.

//#include "shared/step.wgsl"
//#include "shared/counted.wgsl"
//#include "shared/coords.wgsl"
//#include "shared/record.wgsl"

struct DepthParams {
    // For each axis of the view, right, up, depth, the change along x, y, z of the index space by half a
    // voxel step: the low word, then the high one.
    low: array<vec4<u32>, 3>,
    high: array<vec4<u32>, 3>,
    // Voxels along x, y, z.
    dims: vec3<u32>,
    // Bits of a fraction of a step.
    fraction_bits: u32,
    // What makes every position positive, and rounds it: the low word, then the high one.
    bias: vec2<u32>,
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> params: DepthParams;
// `shift` is the axis, and 4 more for the high word.
@group(0) @binding(1) var<uniform> step: Step;
@group(0) @binding(2) var<storage, read> order: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys: array<u32>;
@group(0) @binding(4) var<storage, read> counts: array<u32>;
@group(0) @binding(5) var<storage, read> records_0: array<Record>;
@group(0) @binding(6) var<storage, read> records_1: array<Record>;
@group(0) @binding(7) var<storage, read> records_2: array<Record>;
@group(0) @binding(8) var<storage, read> records_3: array<Record>;

@compute @workgroup_size(256)
fn depth_key(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let slot = linear_group(group, n_groups) * 256u + thread;
    if n_counted() <= slot {
        return;
    }
    let voxel_idx = voxel_idx_of(order[slot]);
    let coords = coords_of(voxel_idx, params.dims);
    let axis = step.shift & 3u;
    var sum = params.bias;
    for (var i = 0u; i < 3u; i++) {
        // Half steps from the grid's centre.
        let half_steps = 2u * coords[i] + 1u - params.dims[i];
        sum = add(sum, multiply(vec2(params.low[axis][i], params.high[axis][i]), half_steps));
    }
    let f = params.fraction_bits;
    let low = (sum.x >> f) | (sum.y << (32u - f));
    keys[slot] = select(low, sum.y >> f, 4u <= step.shift);
}

fn voxel_idx_of(voxel: u32) -> u32 {
    let local = voxel & ((1u << step.chunk_bits) - 1u);
    switch voxel >> step.chunk_bits {
        case 0u: { return records_0[local].voxel_idx; }
        case 1u: { return records_1[local].voxel_idx; }
        case 2u: { return records_2[local].voxel_idx; }
        default: { return records_3[local].voxel_idx; }
    }
}

// Sums of 64 bits, the low word first.
fn add(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2(low, a.y + b.y + select(0u, 1u, low < a.x));
}

// A 64-bit number times a 32-bit one, both signed, modulo 2^64.
fn multiply(a: vec2<u32>, b: u32) -> vec2<u32> {
    let product = multiply_words(a.x, b);
    let high = product.y + a.y * b;
    // A negative factor stands for itself less 2^32.
    return vec2(product.x, high - select(0u, a.x, (b >> 31u) == 1u));
}

// All 64 bits of the product of two words.
fn multiply_words(a: u32, b: u32) -> vec2<u32> {
    let a_low = a & 0xffffu;
    let a_high = a >> 16u;
    let b_low = b & 0xffffu;
    let b_high = b >> 16u;
    let low = a_low * b_low;
    let middle = a_high * b_low + (low >> 16u);
    let other = a_low * b_high + (middle & 0xffffu);
    let high = a_high * b_high + (middle >> 16u) + (other >> 16u);
    return vec2((other << 16u) | (low & 0xffffu), high);
}
