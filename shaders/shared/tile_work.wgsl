// What there is to do on a tile, and what became of it.

struct TileWork {
    // Its splats that are still to come are the elements `begin .. end` of the sorted list.
    begin: u32,
    end: u32,
    // The sheet that is next; `NO_SHEET` before the first.
    sheet: u32,
    n_splatted: u32,
    n_culled: u32,
    state: u32,
    // Splats that begin behind this sheet are not tossed: in the frame before they were hidden. `NO_SHEET` if
    // all are.
    last_tossed: u32,
}

const NO_SHEET: u32 = 0xffffffffu;

const STATE_UNTOUCHED: u32 = 0u;
const STATE_PAUSED: u32 = 1u;
const STATE_DONE: u32 = 2u;
// Done before the last sheet, since all pixels were saturated.
const STATE_SATURATED: u32 = 3u;
// The driver cut a loop short.
const STATE_FAULTY: u32 = 4u;
// Splats that were not tossed are seen.
const STATE_CUT: u32 = 5u;
