// Densities of several layers, and of any beside meshes.
//
// The last six sheets of every layer are a ring in a thread's own memory, from which those of the layer that
// is about to be shown are taken to registers. Drivers reserve that memory for all threads that a device can
// run at a time, 1.5 KB each for so many layers as there may be: hence there are at most so many. What goes
// through the caches are the rings of the layers that there are, 10 KB of a workgroup each.

//#include "shared/surfaces.wgsl"

const MOST_LAYERS: u32 = 16u;

// Of each layer, the last sheet at `last_slot`.
var<private> rings: array<array<vec4<f32>, N_SHEETS>, MOST_LAYERS>;
var<private> last_slot: u32;

fn n_layers() -> u32 {
    return frame.n_layers;
}

fn staged_layer(i: u32) -> u32 {
    return staged[i].layer;
}

// Makes room for a sheet of every layer.
fn begin_sheet() {
    last_slot = (last_slot + 1u) % N_SHEETS;
}

fn push_sheet(layer: u32, sheet: vec4<f32>) {
    rings[layer][last_slot] = sheet;
}

// Takes the sheets of a layer; whether either of the two in the middle holds anything.
fn come_to(layer: u32) -> bool {
    for (var i = 0u; i < N_SHEETS; i++) {
        sheets[i] = rings[layer][(last_slot + 1u + i) % N_SHEETS];
    }
    return 0.0 < max(sheets[FIRST].x, sheets[SECOND].x);
}

// Those of a pixel of a tile that begins or continues: what they have met before it paused the pixel holds
// already. Rays that meet something before the first sheet end there.
fn begin_rays(tile: u32, pixel: u32, todo: TileWork) {
    rays = rays_of(tile, pixel);
    if todo.state == STATE_PAUSED {
        skip_rays(todo.sheet);
    }
    held[0] = end_rays_before(held[0], first_sheet(todo));
}
