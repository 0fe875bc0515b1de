// The image cut into square tiles.

const TILE_SIDE: u32 = 8u;

// A rectangle of tiles in two words: the first row and column, then the last, rows in the upper half.
const NO_TILES: vec2<u32> = vec2(0xffffffffu, 0u);

// Set in the second word of the rectangle of what is hidden on all its tiles.
const HIDDEN: u32 = 0x80000000u;

// Columns and rows of a rectangle of tiles; none if it is empty.
fn rect_size(rect: vec2<u32>) -> vec2<u32> {
    if all(rect == NO_TILES) {
        return vec2(0u);
    }
    let first = vec2(rect.x & 0xffffu, rect.x >> 16u);
    let last = vec2(rect.y & 0xffffu, rect.y >> 16u);
    return last - first + 1u;
}
