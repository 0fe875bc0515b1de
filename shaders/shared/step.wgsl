// The parameters of one dispatch, beside the frame: which part of the work it does. A dispatch covers a number
// of elements that the host knows; how many of them there really are, only the device may know.

struct Step {
    // The first element of the dispatch.
    first: u32,
    // How many elements there can be at most.
    n_elements: u32,
    // Where `counts` says how many there are; `NO_COUNT` if there are as many as there can be.
    count_slot: u32,
    // Elements are kept in up to four buffers of 2^chunk_bits each.
    chunk_bits: u32,
    // Sorting: the lowest bit of the digit, and how many bits it has.
    shift: u32,
    digit_bits: u32,
    // Sorting: the number of blocks. Tossing and summing up: how many splats there is room for.
    n_blocks: u32,
    // The first block of the dispatch among those of all dispatches.
    first_block: u32,
    // The first sample that the bound part of the volume holds.
    first_sample: u32,
    // The layer that it is about.
    layer: u32,
    // Where surfaces begin: see `surfaces.wgsl`.
    first_surface: u32,
    // Whether tiles are as the last frame left them, and this frame is much like it; and how many sheets further
    // back than there what was hidden then is hidden now.
    follows_last: u32,
    sheets_behind: i32,
}

const NO_COUNT: u32 = 0xffffffffu;

// Slots of `counts`.
const COUNT_VOXELS: u32 = 0u;
const COUNT_SPLATS: u32 = 1u;
// Two words each, the low one first.
const COUNT_SPLATTED: u32 = 2u;
const COUNT_CULLED: u32 = 4u;
const COUNT_TILES: u32 = 6u;
const COUNT_FULL_TILES: u32 = 7u;
// Tiles that need another round.
const COUNT_PAUSED_TILES: u32 = 8u;
// Whether a driver cut a loop short: some stop all loops after 65535 turns.
const COUNT_FAULTS: u32 = 9u;
// 1 if the picture is whole: there was room for all splats, none of those that were not tossed is seen, no tile
// needs another round, no loop was cut.
const COUNT_IS_WHOLE: u32 = 10u;
// Tiles on which splats are seen that were not tossed.
const COUNT_CUT_TILES: u32 = 11u;
// Splats that were not tossed; two words.
const COUNT_HIDDEN: u32 = 12u;
// Relevant voxels of each list that there is.
const COUNT_OF_LISTS: u32 = 14u;

// The number of a workgroup in a dispatch that is wider than one dimension allows.
fn linear_group(group: vec3<u32>, n_groups: vec3<u32>) -> u32 {
    return group.y * n_groups.x + group.x;
}
