// How far back splats are tossed onto each tile: what was hidden in the frame before is mostly hidden still.
//
// Where a tile was saturated, and all around it were, nothing is tossed that begins some sheets behind the last
// of those in which they were. This is a guess, and no more: who splats notices where it is wrong, and the
// frame is drawn once more with all that there is. So the picture has the same bits whatever is guessed.

//#include "shared/step.wgsl"
//#include "shared/frame.wgsl"
//#include "shared/tile_work.wgsl"

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> step: Step;
@group(0) @binding(2) var<storage, read_write> tiles: array<TileWork>;

@compute @workgroup_size(256)
fn tile_limits(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let tile = linear_group(group, n_groups) * 256u + thread;
    if tile < step.n_elements {
        tiles[tile].last_tossed = last_tossed(tile);
    }
}

fn last_tossed(tile: u32) -> u32 {
    if step.follows_last == 0u {
        return NO_SHEET;
    }
    let own = vec2<i32>(vec2(tile % frame.n_tiles.x, tile / frame.n_tiles.x));
    let largest = vec2<i32>(frame.n_tiles) - 1;
    let first = max(own - 1, vec2(0));
    let last = min(own + 1, largest);
    var farthest = 0u;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let other = u32(y) * frame.n_tiles.x + u32(x);
            if tiles[other].state != STATE_SATURATED {
                return NO_SHEET;
            }
            farthest = max(farthest, tiles[other].sheet);
        }
    }
    return u32(max(i32(farthest) + step.sheets_behind, 0));
}
