// The bucket toss (paper §7), first pass: onto how many tiles the voxels of each block of 2048 are tossed, in
// the order from front to back.

//#include "shared/step.wgsl"
//#include "shared/scan.wgsl"
//#include "shared/counted_atomically.wgsl"
//#include "shared/tile.wgsl"
//#include "shared/toss.wgsl"

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> order: array<u32>;
@group(0) @binding(2) var<storage, read> rects: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> block_counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> counts: array<atomic<u32>>;

var<workgroup> n_hidden: atomic<u32>;

@compute @workgroup_size(256)
fn toss_count(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    if thread == 0u {
        atomicStore(&n_hidden, 0u);
    }
    workgroupBarrier();
    let block = linear_group(group, n_groups);
    let end = min((block + 1u) * PER_BLOCK, n_counted());
    var n = 0u;
    var n_hidden_here = 0u;
    for (var i = block * PER_BLOCK + thread; i < end; i += 256u) {
        let rect = rects[order[i]];
        n = saturating_sum(n, n_tossed(rect));
        n_hidden_here += n_touched(rect) - n_tossed(rect);
    }
    if 0u < n_hidden_here {
        atomicAdd(&n_hidden, n_hidden_here);
    }
    _ = scan_workgroup(thread, n);
    if thread == 0u && block < step.n_blocks {
        block_counts[block] = scan_sums[255];
        count_hidden(atomicLoad(&n_hidden));
    }
}

fn count_hidden(n: u32) {
    let before = atomicAdd(&counts[COUNT_HIDDEN], n);
    if before + n < before {
        atomicAdd(&counts[COUNT_HIDDEN + 1u], 1u);
    }
}
