// Splats as all pixels of a tile need them that find their weights by a table or by what is between faces.

//#include "shared/batch.wgsl"

// A splat as all pixels of the tile need it.
struct Footprint {
    color: vec4<f32>,
    // In pixels from the image's upper left corner.
    center: vec2<f32>,
    // ρ² at which it ends.
    rho_squared_max: f32,
    row_t: f32,
    // The quadratic form in pixels.
    across: f32,
    shear: f32,
    along: f32,
    // Tilted sections: the slab's faces, in index units behind the voxel, and what a pixel adds to them.
    front: f32,
    back: f32,
    tilt: vec2<f32>,
    row: u32,
    layer: u32,
    // Whether the row is one of the merged sections'.
    is_merged: u32,
}

var<workgroup> staged: array<Footprint, BATCH>;

fn is_drawn(splat: Splat, layer: u32, slab: u32) -> bool {
    return is_drawn_in(slab, splat.span, layer, splat.center.z);
}

// Stages the section of a splat in a slab, but for its row of the table.
fn stage_section(splat: Splat, layer: u32, slab: u32, slot: u32) -> Section {
    let section = section_in(slab, splat.span, layer, splat.center.z);
    stage_shape(splat, layer, middle_of(layer, slab), slot);
    staged[slot].layer = layer;
    staged[slot].front = section.faces.x;
    staged[slot].back = section.faces.y;
    staged[slot].is_merged = u32(section.is_merged);
    // The disc in which the slab cuts the ball.
    var nearest = 0.0;
    if layers[layer].is_tilted == 0u {
        nearest = max(max(section.faces.x, -section.faces.y), 0.0);
    }
    staged[slot].rho_squared_max = frame.radius * frame.radius - nearest * nearest;
    return section;
}

// What depends on the depth at which a splat is projected.
fn stage_shape(splat: Splat, layer: u32, depth: f32, slot: u32) {
    let scale = scale_at(layer, depth);
    let stretch = stretch_of(layer, scale);
    let pixels = scale * stretch;
    staged[slot].center = pixel_of(splat.center, scale);
    staged[slot].across = layers[layer].across / (pixels * pixels);
    staged[slot].shear = layers[layer].shear;
    staged[slot].along = layers[layer].along / (pixels * pixels);
    staged[slot].tilt = layers[layer].tilt / pixels;
    staged[slot].color = splat.color / (stretch * stretch);
}
