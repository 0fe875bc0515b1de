// Slabs parallel to the image (paper §3.2).

fn front_of(slab: u32) -> f32 {
    return f32(frame.first_slab + i32(slab)) * frame.slab_thickness;
}

fn middle_of(slab: u32) -> f32 {
    return (f32(frame.first_slab + i32(slab)) + 0.5) * frame.slab_thickness;
}

// The first and the last slab that the kernel of a voxel at a depth meets.
fn slabs_of(depth: f32) -> vec2<u32> {
    let near = floor((depth - frame.half_depth) / frame.slab_thickness);
    let far = ceil((depth + frame.half_depth) / frame.slab_thickness) - 1.0;
    let last_slab = i32(frame.n_sheets) - 1;
    let first = clamp(i32(near) - frame.first_slab, 0, last_slab);
    let last = clamp(i32(far) - frame.first_slab, first, last_slab);
    return vec2(u32(first), u32(last));
}
