// A stable radix sort, up to eight bits at a time (Satish, Harris & Garland, "Designing Efficient Sorting
// Algorithms for Manycore GPUs", IPDPS 2009). A pass counts the digits of every block of 2048 keys, sums
// the counts up by digit and block, sorts each block by the digit, and moves its keys to the slots that
// the sums give them: neighbours mostly to neighbours. No two threads race, so equal keys keep their order
// and every run gives the same.

const MAX_DIGITS: u32 = 256u;
const KEYS_PER_THREAD: u32 = 8u;
const KEYS_PER_BLOCK: u32 = 2048u;

fn n_digits() -> u32 {
    return 1u << step.digit_bits;
}

fn digit_of(key: u32) -> u32 {
    return extractBits(key, step.shift, step.digit_bits);
}
