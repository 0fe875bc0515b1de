// The bucket toss (paper §7), second pass: writes every voxel once for every tile that it touches, with
// the tile as what is sorted by next. The sort keeps the order from front to back within a tile.

//#include "shared/step.wgsl"
//#include "shared/scan.wgsl"
//#include "shared/frame.wgsl"
//#include "shared/counted_atomically.wgsl"
//#include "shared/tile.wgsl"
//#include "shared/toss.wgsl"

@group(0) @binding(0) var<uniform> frame: Frame;
// There is room for `n_blocks` splats.
@group(0) @binding(1) var<uniform> step: Step;
@group(0) @binding(2) var<storage, read> order: array<u32>;
@group(0) @binding(3) var<storage, read> rects: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> block_sums: array<u32>;
@group(0) @binding(5) var<storage, read> totals: array<u32>;
@group(0) @binding(6) var<storage, read_write> tossed_tiles: array<u32>;
@group(0) @binding(7) var<storage, read_write> tossed_voxels: array<u32>;
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;

@compute @workgroup_size(256)
fn toss_emit(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let block = linear_group(group, n_groups);
    let start = block * PER_BLOCK + thread * PER_THREAD;
    let end = min(start + PER_THREAD, n_counted());
    var n = 0u;
    for (var i = start; i < end; i++) {
        n = saturating_sum(n, n_tossed(rects[order[i]]));
    }
    let before = scan_workgroup(thread, n);
    if end <= start {
        return;
    }
    let before_block = saturating_sum(block_sums[block], totals[block / PER_BLOCK]);
    var slot = saturating_sum(before_block, before);
    for (var i = start; i < end; i++) {
        slot = emit(order[i], slot);
    }
    if slot != saturating_sum(saturating_sum(before_block, before), n) {
        atomicStore(&counts[COUNT_FAULTS], 1u);
    }
}

// Writes a voxel's tiles from `slot` on, and gives the slot behind them.
fn emit(voxel: u32, first_slot: u32) -> u32 {
    let rect = rects[voxel];
    if is_hidden(rect) {
        return first_slot;
    }
    let size = rect_size(rect);
    let first_tile = (rect.x >> 16u) * frame.n_tiles.x + (rect.x & 0xffffu);
    var slot = first_slot;
    for (var y = 0u; y < size.y; y++) {
        for (var x = 0u; x < size.x; x++) {
            if slot < step.n_blocks {
                tossed_tiles[slot] = first_tile + y * frame.n_tiles.x + x;
                tossed_voxels[slot] = voxel;
            }
            slot = saturating_sum(slot, 1u);
        }
    }
    return slot;
}
