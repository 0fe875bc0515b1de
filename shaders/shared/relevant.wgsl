// Which voxels are relevant. Both passes of the classification ask, and must get the same answer.
//
// Whoever includes this declares `transfer`, whose first `n_ranges` elements are the ends of iso-ranges as
// keys: the least one (high word, low word), then the largest.

const PER_THREAD: u32 = 8u;
const PER_BLOCK: u32 = 2048u;

fn is_not_after(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.x < b.x || (a.x == b.x && a.y <= b.y);
}

fn is_relevant(bits: vec2<u32>) -> bool {
    let key = key_of(bits);
    for (var i = 0u; i < volume.n_ranges; i++) {
        let range = transfer[i];
        if is_not_after(range.xy, key) && is_not_after(key, range.zw) {
            return true;
        }
    }
    return false;
}
