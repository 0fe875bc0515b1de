// Splats on their way to the pixels of a tile: a workgroup stages a batch of them at a time, each thread one.
//
// The tile's splats are sorted by the sheet in which they begin. So those that a sheet needs are a run
// of the list, which moves along it with the sheets.
//
// Whoever includes this declares `tossed_voxels`, the four buffers of splats, `n_culled`, and `BATCH`, which
// is how many threads a workgroup has.

// A splat as all pixels of the tile need it.
struct Footprint {
    color: vec4<f32>,
    // In pixels from the image's upper left corner.
    center: vec2<f32>,
    // ρ² at which it ends; negative if it is not to be seen, and the rest is not set then.
    rho_squared_max: f32,
    row_t: f32,
    // The quadratic form in pixels.
    across: f32,
    lean: f32,
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

// What a batch holds of the run that the sheet needs.
struct Batch {
    // Splats that no longer reach into the sheet.
    n_dead: u32,
    // The place behind the last splat that begins at or before the sheet.
    end: u32,
    // The sheet in which the splat at that place begins.
    next_sheet: u32,
    // Whether any pixel can still change.
    is_open: u32,
}

var<workgroup> staged: array<Footprint, BATCH>;
var<workgroup> batch: Batch;

// The layer of a voxel: the last one that does not begin behind it.
fn layer_of(voxel: u32) -> u32 {
    var layer = 0u;
    while layer + 1u < frame.n_layers && layers[layer + 1u].first_voxel <= voxel {
        layer++;
    }
    return layer;
}

fn splat_at(voxel: u32) -> Splat {
    let local = voxel & ((1u << step.chunk_bits) - 1u);
    switch voxel >> step.chunk_bits {
        case 0u: { return splats_0[local]; }
        case 1u: { return splats_1[local]; }
        case 2u: { return splats_2[local]; }
        default: { return splats_3[local]; }
    }
}

// Stages the section of a splat, but for its row of the table; 1 if the slab holds it.
fn stage_section(splat: Splat, layer: u32, slab: u32, thread: u32) -> u32 {
    let faces = vec2(front_of(layer, slab), front_of(layer, slab + 1u));
    let depth = splat.center.z;
    let half_depth = layers[layer].half_depth;
    if depth + half_depth <= faces.x || faces.y <= depth - half_depth {
        return 0u;
    }
    stage_shape(splat, layer, middle_of(layer, slab), thread);
    let from_voxel = (faces - depth) * layers[layer].index_per_depth;
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
    let stretch = stretch_of(scale);
    let pixels = scale * stretch;
    staged[thread].center = pixel_of(splat.center, scale);
    staged[thread].across = layers[layer].across / (pixels * pixels);
    staged[thread].lean = layers[layer].lean;
    staged[thread].along = layers[layer].along / (pixels * pixels);
    staged[thread].tilt = layers[layer].tilt / pixels;
    staged[thread].color = splat.color / (stretch * stretch);
}

// Finds what the batch holds of the sheet's run: sheets rise within it, so the ends of the run are where they
// pass two limits.
fn find_run(sheet: u32, thread: u32, is_open: bool) {
    let first_alive = sheet - min(sheet, frame.n_slabs_before);
    let own = staged[thread].sheet;
    // Before the first splat there is nothing, as if it had begun long ago.
    var before_is_dead = true;
    var before_has_begun = true;
    if 0u < thread {
        let before = staged[thread - 1u].sheet;
        before_is_dead = before < first_alive;
        before_has_begun = before <= sheet;
    }
    if first_alive <= own && before_is_dead {
        batch.n_dead = thread;
    }
    if sheet < own && before_has_begun {
        batch.end = thread;
        batch.next_sheet = own;
    }
    if thread == BATCH - 1u {
        if own < first_alive {
            batch.n_dead = BATCH;
        }
        if own <= sheet {
            batch.end = BATCH;
            batch.next_sheet = NO_SHEET;
        }
    }
    if is_open {
        batch.is_open = 1u;
    }
}

// Counts what is left from a place of the list on, now that all pixels are saturated.
fn cull(first: u32, end: u32, sheet: u32, thread: u32) {
    var n = 0u;
    for (var place = first + thread; place < end; place += BATCH) {
        if frame.method == METHOD_SECTIONS || frame.method == METHOD_DENSITIES {
            let voxel = tossed_voxels[place];
            let layer = layer_of(voxel);
            let slabs = slabs_of(layer, splat_at(voxel).center.z);
            let next = max(max(slabs.x, layers[layer].first_drawn), sheet);
            n += max(slabs.y + 1u, next) - next;
        } else {
            n += 1u;
        }
    }
    atomicAdd(&n_culled, n);
}
