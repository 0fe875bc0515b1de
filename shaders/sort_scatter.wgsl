// Sorting, second half of a pass: moves every key, and the value that goes with it, to its place by the
// digit. A thread has eight keys in a row; their places within the block come from one scan over all
// threads' counts of all digits, two digits to a word.

//#include "shared/step.wgsl"
//#include "shared/scan.wgsl"
//#include "shared/counted.wgsl"
//#include "shared/digits.wgsl"

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> keys: array<u32>;
@group(0) @binding(2) var<storage, read> values: array<u32>;
// For each digit and block, how many keys come before its first.
@group(0) @binding(3) var<storage, read> digit_sums: array<u32>;
@group(0) @binding(4) var<storage, read> totals: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(6) var<storage, read_write> sorted_values: array<u32>;
@group(0) @binding(7) var<storage, read> counts: array<u32>;

// For each pair of digits, every thread's counts: the even digit in the lower half of the word.
var<workgroup> pair_counts: array<u32, 2048>;

@compute @workgroup_size(256)
fn sort_scatter(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let block = linear_group(group, n_groups);
    let start = block * KEYS_PER_BLOCK + thread * KEYS_PER_THREAD;
    let end = min(start + KEYS_PER_THREAD, n_counted());
    // Four bits for each digit hold 0 … 15; a thread has at most 8 keys.
    var own = vec2(0u);
    for (var i = start; i < end; i++) {
        let digit = digit_of(keys[i]);
        own[digit >> 3u] += 1u << ((digit & 7u) * 4u);
    }
    for (var pair = 0u; pair < 8u; pair++) {
        let both = own[pair >> 2u] >> ((pair & 3u) * 8u);
        pair_counts[pair * 256u + thread] = (both & 15u) | ((both & 0xf0u) << 12u);
    }
    scan_pairs(thread);
    var placed = vec2(0u);
    for (var i = start; i < end; i++) {
        let key = keys[i];
        let digit = digit_of(key);
        let shift = (digit & 7u) * 4u;
        let place = first_of(digit, block) + rank_in_block(digit, thread)
            + ((placed[digit >> 3u] >> shift) & 15u);
        placed[digit >> 3u] += 1u << shift;
        sorted_keys[place] = key;
        sorted_values[place] = values[i];
    }
}

// Makes `pair_counts` an exclusive prefix sum. At most 2048 keys are counted, so that no half overflows.
fn scan_pairs(thread: u32) {
    workgroupBarrier();
    let start = thread * 8u;
    var sum = 0u;
    for (var i = 0u; i < 8u; i++) {
        sum += pair_counts[start + i];
    }
    var before = scan_workgroup(thread, sum);
    for (var i = 0u; i < 8u; i++) {
        let count = pair_counts[start + i];
        pair_counts[start + i] = before;
        before += count;
    }
    workgroupBarrier();
}

// How many keys of the block with that digit belong to threads before this one.
fn rank_in_block(digit: u32, thread: u32) -> u32 {
    let pair = (digit >> 1u) * 256u;
    let both = pair_counts[pair + thread] - pair_counts[pair];
    return (both >> ((digit & 1u) * 16u)) & 0xffffu;
}

fn first_of(digit: u32, block: u32) -> u32 {
    let sum_idx = digit * step.n_blocks + block;
    return digit_sums[sum_idx] + totals[sum_idx / KEYS_PER_BLOCK];
}
