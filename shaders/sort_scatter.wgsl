// Sorting, second half of a pass: sorts the keys of a block by the digit, and moves each of them, with the
// value that goes with it, to its slot of the list.
//
// What is sorted is a word for each key: its digit, and its slot in the block. That takes a few passes of
// three bits, as all counts of all threads must fit workgroup memory: a thread has eight words in a row,
// and their slots come from one scan over all threads' counts of all eight digits, two digits to a word.
// Keys that are next to each other then mostly go next to each other, and are written so.

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

// Bits of a word that are the key's slot in the block.
const SLOT_BITS: u32 = 11u;

// Digits by which words are sorted at a time, and pairs of them.
const PART_BITS: u32 = 3u;
const N_PAIRS: u32 = 4u;

var<workgroup> words: array<u32, KEYS_PER_BLOCK>;
// For each pair of digits, every thread's counts, then their sums: the even digit in the lower half of the
// word.
var<workgroup> pair_counts: array<u32, 1024>;
// Where the words of each digit begin, of those that there are.
var<workgroup> starts: array<u32, MAX_DIGITS>;

@compute @workgroup_size(256)
fn sort_scatter(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let block = linear_group(group, n_groups);
    let first = block * KEYS_PER_BLOCK;
    let end = n_counted();
    // Keys that there are not have the last digit, behind all others that have it.
    for (var i = thread; i < KEYS_PER_BLOCK; i += 256u) {
        var digit = n_digits() - 1u;
        if first + i < end {
            digit = digit_of(keys[first + i]);
        }
        words[i] = (digit << SLOT_BITS) | i;
    }
    for (var bit = 0u; bit < step.digit_bits; bit += PART_BITS) {
        sort_words(thread, SLOT_BITS + bit);
    }
    workgroupBarrier();
    for (var i = thread; i < KEYS_PER_BLOCK; i += 256u) {
        let digit = words[i] >> SLOT_BITS;
        if i == 0u || words[max(i, 1u) - 1u] >> SLOT_BITS != digit {
            starts[digit] = i;
        }
    }
    workgroupBarrier();
    for (var i = thread; i < KEYS_PER_BLOCK; i += 256u) {
        let source = first + (words[i] & (KEYS_PER_BLOCK - 1u));
        if source < end {
            let digit = words[i] >> SLOT_BITS;
            let slot = first_of(digit, block) + i - starts[digit];
            sorted_keys[slot] = keys[source];
            sorted_values[slot] = values[source];
        }
    }
}

// Sorts `words` by three bits, from `shift` on; equal ones keep their order.
fn sort_words(thread: u32, shift: u32) {
    workgroupBarrier();
    var own: array<u32, KEYS_PER_THREAD>;
    // Four bits for each digit: a thread has at most 8.
    var n_own = 0u;
    for (var i = 0u; i < KEYS_PER_THREAD; i++) {
        own[i] = words[thread * KEYS_PER_THREAD + i];
        n_own += 1u << (4u * part_of(own[i], shift));
    }
    for (var pair = 0u; pair < N_PAIRS; pair++) {
        let both = n_own >> (8u * pair);
        pair_counts[pair * 256u + thread] = (both & 15u) | ((both & 0xf0u) << 12u);
    }
    let n_all = scan_pairs(thread);
    var n_placed = 0u;
    for (var i = 0u; i < KEYS_PER_THREAD; i++) {
        let part = part_of(own[i], shift);
        let before = (n_placed >> (4u * part)) & 15u;
        n_placed += 1u << (4u * part);
        words[slot_of(part, thread, n_all) + before] = own[i];
    }
}

fn part_of(word: u32, shift: u32) -> u32 {
    return (word >> shift) & 7u;
}

// Makes `pair_counts` an exclusive prefix sum, and gives the sum of all. There are 2048 words, so that no
// half overflows.
fn scan_pairs(thread: u32) -> u32 {
    workgroupBarrier();
    let start = thread * N_PAIRS;
    var sum = 0u;
    for (var i = 0u; i < N_PAIRS; i++) {
        sum += pair_counts[start + i];
    }
    var before = scan_workgroup(thread, sum);
    let all = scan_sums[255];
    for (var i = 0u; i < N_PAIRS; i++) {
        let count = pair_counts[start + i];
        pair_counts[start + i] = before;
        before += count;
    }
    workgroupBarrier();
    return all;
}

// Where a thread's words of a digit begin: behind all lesser digits, and those of the threads before it.
fn slot_of(digit: u32, thread: u32, n_all: u32) -> u32 {
    let pair = (digit >> 1u) * 256u;
    let before_pair = pair_counts[pair];
    let is_odd = digit & 1u;
    // An odd digit comes behind the even one of its pair.
    var n_even = 0u;
    if is_odd == 1u {
        var behind_pair = n_all;
        if pair + 256u < N_PAIRS * 256u {
            behind_pair = pair_counts[pair + 256u];
        }
        n_even = (behind_pair - before_pair) & 0xffffu;
    }
    let of_threads = ((pair_counts[pair + thread] - before_pair) >> (16u * is_odd)) & 0xffffu;
    return (before_pair & 0xffffu) + (before_pair >> 16u) + n_even + of_threads;
}

fn first_of(digit: u32, block: u32) -> u32 {
    let sum_idx = digit * step.n_blocks + block;
    return digit_sums[sum_idx] + totals[sum_idx / KEYS_PER_BLOCK];
}
