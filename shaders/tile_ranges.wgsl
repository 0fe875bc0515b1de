// Where each tile's splats begin and end in the list that is sorted by tile: two binary searches a tile.

//#include "shared/step.wgsl"
//#include "shared/tile_work.wgsl"

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> sorted_tiles: array<u32>;
@group(0) @binding(2) var<storage, read_write> tiles: array<TileWork>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;

@compute @workgroup_size(256)
fn tile_ranges(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let tile = linear_group(group, n_groups) * 256u + thread;
    if tile < step.n_elements {
        let begin = first_not_before(tile);
        let end = first_not_before(tile + 1u);
        let last_tossed = tiles[tile].last_tossed;
        tiles[tile] = TileWork(begin, end, NO_SHEET, 0u, 0u, STATE_UNTOUCHED, last_tossed);
    }
}

fn first_not_before(tile: u32) -> u32 {
    var lo = 0u;
    // There is room for `n_blocks` splats.
    var hi = min(counts[COUNT_SPLATS], step.n_blocks);
    while lo < hi {
        let middle = lo + (hi - lo) / 2u;
        if sorted_tiles[middle] < tile {
            lo = middle + 1u;
        } else {
            hi = middle;
        }
    }
    return lo;
}
