// Blocks of the toss: each thread has eight voxels in a row of the order from front to back.

const PER_THREAD: u32 = 8u;
const PER_BLOCK: u32 = 2048u;

fn is_hidden(rect: vec2<u32>) -> bool {
    return (rect.y & HIDDEN) != 0u;
}

// Tiles that a voxel is tossed onto.
fn n_tossed(rect: vec2<u32>) -> u32 {
    if is_hidden(rect) {
        return 0u;
    }
    return n_touched(rect);
}

fn n_touched(rect: vec2<u32>) -> u32 {
    let size = rect_size(vec2(rect.x, rect.y & ~HIDDEN));
    return size.x * size.y;
}
