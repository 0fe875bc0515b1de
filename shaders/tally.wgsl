// Sums up what the tiles report. One workgroup; each number of splats takes two words.

//#include "shared/step.wgsl"
//#include "shared/tile_work.wgsl"

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> tiles: array<TileWork>;
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

// Splatted: low and high word; culled: low and high word.
var<workgroup> n_splats: array<vec4<u32>, 256>;
// Tiles with splats, saturated tiles, paused tiles, faulty tiles.
var<workgroup> n_tiles: array<vec4<u32>, 256>;
var<workgroup> cut_tiles: array<u32, 256>;

fn add(sum: vec2<u32>, n: vec2<u32>) -> vec2<u32> {
    let low = sum.x + n.x;
    return vec2(low, sum.y + n.y + select(0u, 1u, low < sum.x));
}

@compute @workgroup_size(256)
fn tally(@builtin(local_invocation_index) thread: u32) {
    var splatted = vec2(0u);
    var culled = vec2(0u);
    var n = vec4(0u);
    var n_cut_tiles = 0u;
    for (var i = thread; i < step.n_elements; i += 256u) {
        let tile = tiles[i];
        splatted = add(splatted, vec2(tile.n_splatted, 0u));
        culled = add(culled, vec2(tile.n_culled, 0u));
        n += vec4<u32>(vec4(
            tile.state != STATE_UNTOUCHED,
            tile.state == STATE_SATURATED,
            tile.state == STATE_PAUSED,
            tile.state == STATE_FAULTY,
        ));
        n_cut_tiles += u32(tile.state == STATE_CUT);
    }
    cut_tiles[thread] = n_cut_tiles;
    n_splats[thread] = vec4(splatted, culled);
    n_tiles[thread] = n;
    workgroupBarrier();
    if thread != 0u {
        return;
    }
    for (var i = 1u; i < 256u; i++) {
        splatted = add(splatted, n_splats[i].xy);
        culled = add(culled, n_splats[i].zw);
        n += n_tiles[i];
        n_cut_tiles += cut_tiles[i];
    }
    culled = add(culled, vec2(counts[COUNT_HIDDEN], counts[COUNT_HIDDEN + 1u]));
    counts[COUNT_SPLATTED] = splatted.x;
    counts[COUNT_SPLATTED + 1u] = splatted.y;
    counts[COUNT_CULLED] = culled.x;
    counts[COUNT_CULLED + 1u] = culled.y;
    counts[COUNT_TILES] = n.x;
    counts[COUNT_FULL_TILES] = n.y;
    counts[COUNT_PAUSED_TILES] = n.z;
    let n_faults = max(counts[COUNT_FAULTS], n.w);
    counts[COUNT_FAULTS] = n_faults;
    counts[COUNT_CUT_TILES] = n_cut_tiles;
    let has_room = counts[COUNT_SPLATS] <= step.n_blocks;
    let is_whole = has_room && n_cut_tiles == 0u && n.z == 0u && n_faults == 0u;
    counts[COUNT_IS_WHOLE] = select(0u, 1u, is_whole);
}
