// Blocks of the toss: each thread has eight voxels in a row of the order from front to back.

const PER_THREAD: u32 = 8u;
const PER_BLOCK: u32 = 2048u;

fn n_touched(rect: vec2<u32>) -> u32 {
    let size = rect_size(rect);
    return size.x * size.y;
}
