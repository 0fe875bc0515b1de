// Sorting, first half of a pass: how often each digit occurs in each block.

//#include "shared/step.wgsl"
//#include "shared/counted.wgsl"
//#include "shared/digits.wgsl"

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> keys: array<u32>;
// For each digit, the count of every block.
@group(0) @binding(2) var<storage, read_write> digit_counts: array<u32>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;

var<workgroup> n_of_digit: array<atomic<u32>, MAX_DIGITS>;

@compute @workgroup_size(256)
fn sort_count(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    atomicStore(&n_of_digit[thread], 0u);
    workgroupBarrier();
    let block = linear_group(group, n_groups);
    let end = min((block + 1u) * KEYS_PER_BLOCK, n_counted());
    for (var i = block * KEYS_PER_BLOCK + thread; i < end; i += 256u) {
        atomicAdd(&n_of_digit[digit_of(keys[i])], 1u);
    }
    workgroupBarrier();
    if thread < n_digits() && block < step.n_blocks {
        digit_counts[thread * step.n_blocks + block] = atomicLoad(&n_of_digit[thread]);
    }
}
