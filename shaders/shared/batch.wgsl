// Splats on their way to the pixels of a tile: a workgroup stages a batch of them at a time, each thread one.
//
// The tile's splats are sorted by the sheet in which they begin. So those that a sheet needs are a run
// of the list, which moves along it with the sheets.
//
// Whoever includes this declares `layers`, `tossed_voxels`, the four buffers of splats, `BATCH`, which is
// how many threads a workgroup has, and `staged`, which has the sheet in which each splat begins.

// What a batch holds of the run that the sheet needs.
struct Batch {
    // Splats that no longer reach into the sheet.
    n_dead: u32,
    // The slot behind the last splat that begins at or before the sheet.
    end: u32,
    // The sheet in which the splat at that slot begins.
    next_sheet: u32,
    // Whether any pixel can still change.
    is_open: u32,
}

var<workgroup> batch: Batch;
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

// What the batch that is staged holds of the sheet's run, and whether any pixel can still change.
fn run_of(sheet: u32, thread: u32, is_open: bool) -> Batch {
    if thread == 0u {
        atomicStore(&any_is_open, 0u);
    }
    workgroupBarrier();
    find_run(sheet, thread);
    return batch_if_open(thread, is_open);
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
    }
    return workgroupUniformLoad(&batch);
}

// Finds the sheet's run among what is staged: sheets rise within it, so the ends of the run are where they pass
// two limits.
fn find_run(sheet: u32, thread: u32) {
    let first_alive = sheet - min(sheet, frame.n_slabs_before);
    let own = staged[thread].sheet;
    // Before the first splat there is nothing, as if it had begun long ago.
    var before_is_dead = true;
    var before_has_begun = true;
    if 0u < thread {
        let before = staged[thread - 1u].sheet;
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
