// Slabs parallel to the image (paper §3.2), in `unit`s of a layer; and in which of them a voxel is drawn (model
// §7): the twin of the CPU's `span.rs` and `cut.rs`.
//
// A span is the index of a voxel's first slab, and in its lowest bits how many slabs there are behind that. The
// first of its sections holds all of the kernel before it, too, and the last all behind it. Of a voxel that
// has all its sections that number is `ALL`: what slabs cut is then found by their faces.

const SPAN_BITS: u32 = 10u;
const ALL: u32 = 1023u;

// Index units behind everything.
const FAR_BEHIND: f32 = 1e9;

// What of a voxel's kernel is drawn in a slab.
struct Section {
    // Index units from the voxel to the faces that cut it, along the ray through it.
    faces: vec2<f32>,
    // Whether other faces were skipped.
    is_merged: bool,
}

fn front_of(layer: u32, slab: u32) -> f32 {
    return f32(frame.first_slab + i32(slab)) * layers[layer].slab_thickness;
}

fn middle_of(layer: u32, slab: u32) -> f32 {
    return (f32(frame.first_slab + i32(slab)) + 0.5) * layers[layer].slab_thickness;
}

// The first and the last slab that the kernel of a voxel at a depth meets.
fn slabs_of(layer: u32, depth: f32) -> vec2<u32> {
    let half_depth = layers[layer].half_depth;
    let near = floor((depth - half_depth) / layers[layer].slab_thickness);
    let far = ceil((depth + half_depth) / layers[layer].slab_thickness) - 1.0;
    let last_slab = i32(frame.n_sheets) - 1;
    let first = clamp(i32(near) - frame.first_slab, 0, last_slab);
    let last = clamp(i32(far) - frame.first_slab, first, last_slab);
    return vec2(u32(first), u32(last));
}

// Index units from a voxel at a depth to a slab's faces, along the ray through it.
fn faces_behind(depth: f32, layer: u32, slab: u32) -> vec2<f32> {
    let faces = vec2(front_of(layer, slab), front_of(layer, slab + 1u));
    return (faces - depth) * layers[layer].index_per_depth;
}

// Whether the kernel of a voxel at a depth reaches into a slab.
fn is_met(depth: f32, layer: u32, slab: u32) -> bool {
    let half_depth = layers[layer].half_depth;
    let faces = vec2(front_of(layer, slab), front_of(layer, slab + 1u));
    return faces.x < depth + half_depth && depth - half_depth < faces.y;
}

fn first_slab_of(span: u32) -> u32 {
    return span >> SPAN_BITS;
}

// The last slab in which a voxel at a depth is drawn.
fn last_slab_of(span: u32, layer: u32, depth: f32) -> u32 {
    let n_more = span & ALL;
    if n_more == ALL {
        return slabs_of(layer, depth).y;
    }
    return min(first_slab_of(span) + n_more, frame.n_sheets - 1u);
}

// Whether a voxel at a depth is drawn in a slab.
fn is_drawn_in(slab: u32, span: u32, layer: u32, depth: f32) -> bool {
    let first = first_slab_of(span);
    let n_more = span & ALL;
    if n_more == ALL {
        return first <= slab && is_met(depth, layer, slab);
    }
    // A slab before the first wraps around.
    return slab - first <= n_more;
}

// The section of a voxel at a depth in a slab in which it is drawn.
fn section_in(slab: u32, span: u32, layer: u32, depth: f32) -> Section {
    var faces = faces_behind(depth, layer, slab);
    let n_more = span & ALL;
    if n_more == ALL {
        return Section(faces, false);
    }
    let nth = slab - first_slab_of(span);
    if nth == 0u {
        faces.x = -FAR_BEHIND;
    }
    if nth == n_more {
        faces.y = FAR_BEHIND;
    }
    return Section(faces, nth == 0u || nth == n_more);
}

// The sheet in which a voxel begins, or a slice.
fn sheet_of(span: u32, layer: u32) -> u32 {
    if frame.method == METHOD_SECTIONS || frame.method == METHOD_DENSITIES {
        return max(first_slab_of(span), layers[layer].first_drawn);
    }
    return span;
}
