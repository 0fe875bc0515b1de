// A stable radix sort, four bits at a time (Satish, Harris & Garland, "Designing Efficient Sorting
// Algorithms for Manycore GPUs", IPDPS 2009). A pass counts the digits of every block of 2048 keys, sums
// the counts up by digit and block, and moves each key to the place that the sums give it. No two
// threads race, so equal keys keep their order and every run gives the same.

const N_DIGITS: u32 = 16u;
const KEYS_PER_THREAD: u32 = 8u;
const KEYS_PER_BLOCK: u32 = 2048u;

fn digit_of(key: u32) -> u32 {
    return (key >> step.shift) & 15u;
}
