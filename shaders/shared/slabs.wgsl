// Slabs parallel to the image (paper §3.2), in `unit`s of a layer.

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
