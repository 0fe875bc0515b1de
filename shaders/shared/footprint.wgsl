// Splats as all pixels of a tile need them that find their weights by a table or by what is between faces.

//#include "shared/batch.wgsl"

// A splat as all pixels of the tile need it.
struct Footprint {
    color: vec4<f32>,
    // In pixels from the image's upper left corner.
    center: vec2<f32>,
    // ρ² at which it ends; negative if it is not to be seen. Then nothing else need be set, and may
    // be anything.
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
    // The sheet in which the splat begins.
    sheet: u32,
    layer: u32,
}

var<workgroup> staged: array<Footprint, BATCH>;

// Stages the section of a splat, but for its row of the table; 1 if the slab holds it.
fn stage_section(splat: Splat, layer: u32, slab: u32, thread: u32) -> u32 {
    let depth = splat.center.z;
    if !is_met(depth, layer, slab) {
        return 0u;
    }
    stage_shape(splat, layer, middle_of(layer, slab), thread);
    let from_voxel = faces_behind(depth, layer, slab);
    staged[thread].front = from_voxel.x;
    staged[thread].back = from_voxel.y;
    // The disc in which the slab cuts the ball.
    var nearest = 0.0;
    if layers[layer].is_tilted == 0u {
        nearest = max(max(from_voxel.x, -from_voxel.y), 0.0);
    }
    staged[thread].rho_squared_max = frame.radius * frame.radius - nearest * nearest;
    return 1u;
}

// What depends on the depth at which a splat is projected.
fn stage_shape(splat: Splat, layer: u32, depth: f32, thread: u32) {
    let scale = scale_at(layer, depth);
    let stretch = stretch_of(layer, scale);
    let pixels = scale * stretch;
    staged[thread].center = pixel_of(splat.center, scale);
    staged[thread].across = layers[layer].across / (pixels * pixels);
    staged[thread].shear = layers[layer].shear;
    staged[thread].along = layers[layer].along / (pixels * pixels);
    staged[thread].tilt = layers[layer].tilt / pixels;
    staged[thread].color = splat.color / (stretch * stretch);
}
