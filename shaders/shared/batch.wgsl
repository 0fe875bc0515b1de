// Splats on their way to the pixels of a tile: a workgroup looks at a batch of them at a time, each thread at one,
// and stages those that the sheet holds, one behind the other.
//
// The tile's splats are sorted by the sheet in which they begin. So those that a sheet may hold are a run
// of the list, which moves along it with the sheets.
//
// Whoever includes this declares `layers`, `tossed_voxels`, the four buffers of splats, `BATCH`, which is
// how many threads a workgroup has, and says by `is_drawn` whether a sheet holds a splat that begins at or before it.

// A splat that a thread looks at.
struct Candidate {
    splat: Splat,
    layer: u32,
    // Whether the sheet holds it.
    is_drawn: bool,
}

// What a batch holds of the run that the sheet needs.
struct Batch {
    // Splats that no longer reach into the sheet.
    n_dead: u32,
    // The slot behind the last splat that begins at or before the sheet.
    end: u32,
    // Splats between these that the sheet holds.
    n_drawn: u32,
    // The sheet in which the splat at that slot begins.
    next_sheet: u32,
    // Whether any pixel can still change.
    is_open: u32,
}

var<workgroup> batch: Batch;
// By thread: the sheet in which the splat that it looks at begins.
var<workgroup> begins: array<u32, BATCH>;
// A bit for every thread, set if the sheet holds the splat that it looks at.
var<workgroup> are_drawn: array<atomic<u32>, 4>;
// The same, while threads say of their pixels whether they can.
var<workgroup> any_is_open: atomic<u32>;

// The layer of a voxel: the last one that does not begin behind it.
fn layer_of(voxel: u32) -> u32 {
    var layer = 0u;
    while layer + 1u < frame.n_layers && layers[layer + 1u].first_voxel <= voxel {
        layer++;
    }
    return layer;
}

fn splat_at(voxel: u32) -> Splat {
    let local = voxel & ((1u << step.chunk_bits) - 1u);
    switch voxel >> step.chunk_bits {
        case 0u: { return splats_0[local]; }
        case 1u: { return splats_1[local]; }
        case 2u: { return splats_2[local]; }
        default: { return splats_3[local]; }
    }
}

// The splat at a place of the list, which ends behind the last one.
fn look_at(place: u32, end: u32, sheet: u32, thread: u32) -> Candidate {
    begins[thread] = NO_SHEET;
    if end <= place {
        return Candidate(Splat(vec3(0.0), 0u, vec4(0.0)), 0u, false);
    }
    let voxel = tossed_voxels[place];
    let splat = splat_at(voxel);
    let layer = layer_of(voxel);
    let begin = sheet_of(splat.span, layer);
    begins[thread] = begin;
    let is_of_run = begin <= sheet && first_alive_in(sheet) <= begin;
    return Candidate(splat, layer, is_of_run && is_drawn(splat, layer, sheet));
}

// The first sheet in which a splat may begin that a sheet holds.
fn first_alive_in(sheet: u32) -> u32 {
    return sheet - min(sheet, frame.n_slabs_before);
}

// What the batch that is looked at holds of the sheet's run, and whether any pixel can still change.
fn run_of(sheet: u32, thread: u32, candidate: Candidate, is_open: bool) -> Batch {
    if thread == 0u {
        atomicStore(&any_is_open, 0u);
    }
    if thread < 4u {
        atomicStore(&are_drawn[thread], 0u);
    }
    workgroupBarrier();
    if candidate.is_drawn {
        atomicOr(&are_drawn[thread / 32u], 1u << (thread % 32u));
    }
    find_run(sheet, thread);
    return batch_if_open(thread, is_open);
}

// How many splats that the sheet holds are looked at by threads before this one.
fn n_drawn_before(thread: u32) -> u32 {
    var n = 0u;
    for (var i = 0u; i < thread / 32u; i++) {
        n += countOneBits(atomicLoad(&are_drawn[i]));
    }
    let before = (1u << (thread % 32u)) - 1u;
    return n + countOneBits(atomicLoad(&are_drawn[thread / 32u]) & before);
}

// Whether any pixel can still change.
fn is_any_open(thread: u32, is_open: bool) -> bool {
    workgroupBarrier();
    if thread == 0u {
        atomicStore(&any_is_open, 0u);
    }
    workgroupBarrier();
    return batch_if_open(thread, is_open).is_open == 1u;
}

// The batch, with what all threads say of their pixels.
fn batch_if_open(thread: u32, is_open: bool) -> Batch {
    if is_open {
        atomicStore(&any_is_open, 1u);
    }
    workgroupBarrier();
    if thread == 0u {
        batch.is_open = atomicLoad(&any_is_open);
        batch.n_drawn = n_drawn_before(BATCH);
    }
    return workgroupUniformLoad(&batch);
}

// Finds the sheet's run among what is looked at: sheets rise within it, so the ends of the run are where they
// pass two limits.
fn find_run(sheet: u32, thread: u32) {
    let first_alive = first_alive_in(sheet);
    let own = begins[thread];
    // Before the first splat there is nothing, as if it had begun long ago.
    var before_is_dead = true;
    var before_has_begun = true;
    if 0u < thread {
        let before = begins[thread - 1u];
        before_is_dead = before < first_alive;
        before_has_begun = before <= sheet;
    }
    if first_alive <= own && before_is_dead {
        batch.n_dead = thread;
    }
    if sheet < own && before_has_begun {
        batch.end = thread;
        batch.next_sheet = own;
    }
    if thread == BATCH - 1u {
        if own < first_alive {
            batch.n_dead = BATCH;
        }
        if own <= sheet {
            batch.end = BATCH;
            batch.next_sheet = NO_SHEET;
        }
    }
}
