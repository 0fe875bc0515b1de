// Which slab faces split a voxel's kernel (model §7): the twin of the CPU's `span_finder.rs`.
//
// `table` has an element for each of a layer's splits, from the first on:
//
//   x: the most extinction of the voxels that it is for, unless one before is; they rise, and the last has no bound
//   y: the share of the kernel's half-depth within which faces split it
//   z: how many times as thick the slab is in whose middle a whole voxel goes, or 1
//
// Whoever includes this declares `table`, which holds other things too, and so is of words.

const NO_SPLITS: u32 = 0xffffffffu;
const N_SPLITS: u32 = 35u;

// How many slabs before a face a whole voxel counts as on it.
const ON_FACE: f32 = 0.0009765625;

// The span of a voxel at a depth that sums so much extinction, or whatever the compositing sums.
fn span_of(layer: u32, depth: f32, summed: f32) -> u32 {
    let split = split_of(layer, summed);
    let half_depth = split.y * layers[layer].half_depth;
    let thickness = layers[layer].slab_thickness;
    let on_face = select(0.0, ON_FACE, half_depth == 0.0);
    let near = floor((depth - half_depth) / thickness + on_face);
    let n_more = max(ceil((depth + half_depth) / thickness) - 1.0 - near, 0.0);
    // A voxel that has as many slabs as a span can hold is drawn in all that it meets, to be sure.
    if 1.0 <= split.y || f32(ALL) <= n_more {
        return (slabs_of(layer, depth).x << SPAN_BITS) | ALL;
    }
    let middle = floor(near / split.z) * split.z + 0.5 * split.z;
    let first = select(near, middle, 1.0 < split.z);
    let idx = clamp(i32(first) - frame.first_slab, 0, i32(frame.n_sheets) - 1);
    return (u32(idx) << SPAN_BITS) | u32(n_more);
}

fn split_of(layer: u32, summed: f32) -> vec4<f32> {
    if layers[layer].first_split == NO_SPLITS {
        return vec4(0.0, 1.0, 1.0, 0.0);
    }
    var first = layers[layer].first_split;
    var last = first + N_SPLITS - 1u;
    while first < last {
        let middle = (first + last) / 2u;
        if bitcast<f32>(table[middle].x) < summed {
            first = middle + 1u;
        } else {
            last = middle;
        }
    }
    return bitcast<vec4<f32>>(table[first]);
}
