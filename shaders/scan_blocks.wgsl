// The first half of a prefix sum of any length: each workgroup sums up a block of 2048 elements in
// place, exclusively, and writes the block's total. `scan_totals` then sums up the totals; an element's
// sum is its own and that of its block.

//#include "shared/step.wgsl"
//#include "shared/scan.wgsl"

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read_write> elements: array<u32>;
@group(0) @binding(2) var<storage, read_write> totals: array<u32>;

const PER_THREAD: u32 = 8u;

@compute @workgroup_size(256)
fn scan_blocks(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let block = linear_group(group, n_groups);
    let start = (block * 256u + thread) * PER_THREAD;
    var sums: array<u32, PER_THREAD>;
    var sum = 0u;
    for (var i = 0u; i < PER_THREAD; i++) {
        sums[i] = sum;
        if start + i < step.n_elements {
            sum = saturating_sum(sum, elements[start + i]);
        }
    }
    let before = scan_workgroup(thread, sum);
    for (var i = 0u; i < PER_THREAD; i++) {
        if start + i < step.n_elements {
            elements[start + i] = saturating_sum(before, sums[i]);
        }
    }
    if thread == 255u && block * 256u * PER_THREAD < step.n_elements {
        totals[block] = scan_sums[255];
    }
}
