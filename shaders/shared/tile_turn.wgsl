// A workgroup's turn at a tile: what it takes on, and what it leaves to the next one if the tile pauses.
//
// Whoever includes this declares `frame`, `step`, `tiles` and `tossed_voxels`.

var<workgroup> work: TileWork;
var<workgroup> n_splatted: atomic<u32>;
// Whether any thread's loops ended before they were through: the first of these. There are two, so that splats
// come behind 336 bytes: compilers load four numbers at once only from multiples of 16.
var<workgroup> is_faulty: array<atomic<u32>, 2>;

// How far a turn came, which is the same for all pixels: the first splat and the sheet that are next, and why
// it ended.
struct Reached {
    begin: u32,
    sheet: u32,
    state: u32,
}

// What there is to do on a tile.
fn begin_turn(tile: u32, thread: u32) -> TileWork {
    if thread == 0u {
        work = tiles[tile];
        atomicStore(&n_splatted, 0u);
        atomicStore(&is_faulty[0], 0u);
    }
    return workgroupUniformLoad(&work);
}

fn is_to_do(todo: TileWork) -> bool {
    return todo.state == STATE_PAUSED || todo.state == STATE_UNTOUCHED;
}

// The sheet at which the tile begins, or continues.
fn first_sheet(todo: TileWork) -> u32 {
    if todo.state == STATE_PAUSED || todo.end <= todo.begin {
        return todo.sheet;
    }
    let voxel = tossed_voxels[todo.begin];
    return sheet_of(splat_at(voxel).span, layer_of(voxel));
}

// The sheet behind the last one of which all splats of the tile were tossed.
fn end_of_sheets(todo: TileWork) -> u32 {
    let end = select(todo.last_tossed + 1u, NO_SHEET, todo.last_tossed == NO_SHEET);
    return min(frame.n_sheets, end);
}

// Notes what became of a tile, once all threads are through with it. One without splats stays untouched.
fn end_turn(tile: u32, thread: u32, todo: TileWork, reached: Reached) {
    workgroupBarrier();
    let is_touched = todo.begin < todo.end || end_of_sheets(todo) < frame.n_sheets;
    if thread == 0u && is_touched {
        let n_before = todo.n_splatted + atomicLoad(&n_splatted);
        // Those behind a full tile are counted, and not looked at.
        let n_behind = select(0u, todo.end - reached.begin, reached.state == STATE_SATURATED);
        let state = select(reached.state, STATE_FAULTY, atomicLoad(&is_faulty[0]) == 1u);
        tiles[tile] = TileWork(
            reached.begin,
            todo.end,
            reached.sheet,
            n_before,
            n_behind,
            state,
            todo.last_tossed,
        );
    }
}

// A pixel before the background.
fn over_background(pixel: vec4<f32>) -> vec4<f32> {
    let straight = frame.background;
    let background = vec4(straight.rgb * straight.a, straight.a);
    return pixel + (1.0 - pixel.a) * background;
}
