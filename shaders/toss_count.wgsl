// The bucket toss (paper §7), first pass: how many tiles the voxels of each block of 2048 touch, in the
// order from front to back.

//#include "shared/step.wgsl"
//#include "shared/scan.wgsl"
//#include "shared/counted.wgsl"
//#include "shared/tile.wgsl"
//#include "shared/toss.wgsl"

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> order: array<u32>;
@group(0) @binding(2) var<storage, read> rects: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> block_counts: array<u32>;
@group(0) @binding(4) var<storage, read> counts: array<u32>;

@compute @workgroup_size(256)
fn toss_count(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let block = linear_group(group, n_groups);
    let end = min((block + 1u) * PER_BLOCK, n_counted());
    var n = 0u;
    for (var i = block * PER_BLOCK + thread; i < end; i += 256u) {
        n = saturating_sum(n, n_touched(rects[order[i]]));
    }
    _ = scan_workgroup(thread, n);
    if thread == 0u && block < step.n_blocks {
        block_counts[block] = scan_sums[255];
    }
}
