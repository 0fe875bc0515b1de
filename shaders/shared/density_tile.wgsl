// Sheets of densities over a tile, from the eye on (model §8): a workgroup renders a tile of 8x8 pixels with
// a border of one, a thread a pixel.
//
//   for each sheet that any of the tile's splats reaches into, and three behind the last:
//       for each batch of splats from the first that still reaches into it:
//           every thread stages one splat, if the sheet holds it: where it lies there
//           every thread adds all staged splats to its pixel: how much of the ray, and that times the values
//       for each layer: the density, and how it changes from pixel to pixel; put that with the five sheets before
//       show what lies between the two sheets in the middle
//
// The splats of all layers are in one list, and those that begin in one sheet come layer by layer. So a pixel
// has the sums of one layer in registers, and puts them aside a few times a sheet.
//
// Only sums go through workgroup memory, for what a pixel's neighbours make of them. A tile that has visited
// many splats pauses, as systems reset devices that do not answer for seconds. What continues it sums the
// last five sheets once more, which is cheaper than to store them.
//
// Whoever includes this
// - includes `density_alone.wgsl` or `densities_among_others.wgsl`, which say how many layers there may be, retain
//   their sheets, and know where rays end,
// - declares `MOST_HELD` and `n_held`, how many elements a pixel holds of what it has found so far, and can at
//   most; they are `held`, 0 at first, and the last channel of the first is the pixel's opacity, or 0,
// - shows what lies between sheets: `showing` puts it behind a pixel, and `shown` makes of what the pixel holds its
//   premultiplied colour and opacity.

//#include "shared/step.wgsl"
//#include "shared/frame.wgsl"
//#include "shared/layer.wgsl"
//#include "shared/splat.wgsl"
//#include "shared/pixels.wgsl"
//#include "shared/slabs.wgsl"
//#include "shared/tile.wgsl"
//#include "shared/tile_work.wgsl"
//#include "shared/tile_turn.wgsl"
//#include "shared/footprint.wgsl"
//#include "shared/compositing.wgsl"
//#include "shared/region.wgsl"
//#include "shared/densities.wgsl"
//#include "shared/density_weight.wgsl"
//#include "shared/sheets.wgsl"

@group(0) @binding(0) var<uniform> frame: Frame;
// The tiles `first .. first + n_elements`; the first pixel that is bound is that of row `first_sample`.
@group(0) @binding(1) var<uniform> step: Step;
@group(0) @binding(2) var<uniform> layers: array<Layer, MAX_LAYERS>;
@group(0) @binding(3) var<uniform> densities: array<Densities, MOST_LAYERS>;
@group(0) @binding(4) var<storage, read> tossed_voxels: array<u32>;
@group(0) @binding(5) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read_write> tiles: array<TileWork>;
// All pixels that are bound; of those that pause, as often as there are elements to be held.
@group(0) @binding(7) var<storage, read_write> pixels: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> splats_0: array<Splat>;
@group(0) @binding(9) var<storage, read> splats_1: array<Splat>;
@group(0) @binding(10) var<storage, read> splats_2: array<Splat>;
@group(0) @binding(11) var<storage, read> splats_3: array<Splat>;

const SIDE: u32 = TILE_SIDE + 2u;
const BATCH: u32 = 100u;

// Of a layer, for each pixel of the tile and its border: how much of the ray, and that times the values.
var<workgroup> sums: array<vec2<f32>, BATCH>;
// The same of all layers for this thread's pixel, while they are summed.
var<private> sums_of_layers: array<vec2<f32>, MOST_LAYERS>;
// Splats that this thread staged for the sheet, and whether it added all that were staged. They are not in
// `Summed`: a struct of which one member may differ between threads decides no barrier in a browser.
var<private> n_staged: u32;
var<private> is_whole: bool;
// Where the pixel's ray is in the convex set of each layer's region.
var<private> intervals: array<vec2<f32>, MOST_LAYERS>;
// What the pixel has found so far.
var<private> held: array<vec4<f32>, MOST_HELD>;

// A pixel, as far as it is the same for all sheets.
struct Pixel {
    // Its centre.
    at: vec2<f32>,
    // Its index in the tile with its border, row by row.
    thread: u32,
    // Whether it is of the image, and not of a border.
    is_shown: bool,
}

fn render_tile(local: vec2<u32>, thread: u32, tile_of_pass: u32) {
    if step.n_elements <= tile_of_pass {
        return;
    }
    let tile = step.first + tile_of_pass;
    let todo = begin_turn(tile, thread);
    if !is_to_do(todo) {
        return;
    }
    // One further down and right than it is, so that it is never negative.
    let moved = vec2(tile % frame.n_tiles.x, tile / frame.n_tiles.x) * TILE_SIDE + local;
    let is_border = any(local == vec2(0u)) || any(local == vec2(SIDE - 1u));
    let pixel = Pixel(
        vec2<f32>(moved) - 0.5,
        thread,
        !is_border && all(moved <= frame.image_size),
    );
    let pixel_idx = (moved.y - 1u - step.first_sample) * frame.image_size.x + moved.x - 1u;
    for (var layer = 0u; layer < n_layers(); layer++) {
        intervals[layer] = interval_of(layer, pixel.at);
    }
    if pixel.is_shown {
        if todo.state == STATE_PAUSED {
            continue_pixel(pixel_idx);
        }
        begin_rays(tile, (local.y - 1u) * TILE_SIDE + local.x - 1u, todo);
    }
    let reached = through_sheets(todo, pixel);
    if pixel.is_shown {
        if reached.state == STATE_PAUSED {
            pause_pixel(pixel_idx);
        } else {
            pixels[pixel_idx] = over_background(shown());
        }
    }
    end_turn(tile, thread, todo, reached);
}

fn continue_pixel(pixel_idx: u32) {
    for (var i = 0u; i < n_held(); i++) {
        held[i] = pixels[i * n_pixels() + pixel_idx];
    }
}

fn pause_pixel(pixel_idx: u32) {
    for (var i = 0u; i < n_held(); i++) {
        pixels[i * n_pixels() + pixel_idx] = held[i];
    }
}

// Those that are bound: whole rows of tiles, or as many as the image has left.
fn n_pixels() -> u32 {
    let n_rows = step.n_elements / frame.n_tiles.x * TILE_SIDE;
    return min(n_rows, frame.image_size.y - step.first_sample) * frame.image_size.x;
}

// Sheets that are summed once more where a tile is continued: all but the last of those that a pixel retains.
const N_AGAIN: u32 = N_SHEETS - 1u;

// Sheets behind the last that holds anything, until what lies before them all is shown.
const N_BEHIND: u32 = N_SHEETS - SECOND;

fn through_sheets(todo: TileWork, pixel: Pixel) -> Reached {
    var is_open = pixel.is_shown && held[0].a < frame.opacity_cutoff;
    // The run that the sheet needs begins here; and where it began for the sheets that are summed again.
    var begin = todo.begin;
    var begins: array<u32, N_AGAIN>;
    for (var i = 0u; i < N_AGAIN; i++) {
        begins[i] = begin;
    }
    // What lies before this sheet was shown already.
    let first_shown = first_sheet(todo);
    var sheet = first_shown;
    if todo.state == STATE_PAUSED {
        sheet -= min(sheet, N_AGAIN);
    }
    // How many sheets on end hold nothing, up to the last one.
    var n_empty = N_SHEETS;
    var n_visits = 0u;
    let end_sheet = end_of_sheets(todo);
    let is_limited = end_sheet < frame.n_sheets;
    var last_sheet = sheet;
    while (begin < todo.end && sheet < end_sheet) || (n_empty < N_BEHIND && !is_limited) {
        // Every round gets further by a sheet.
        if first_shown < sheet && frame.max_visits < n_visits {
            return Reached(begins[0], sheet, STATE_PAUSED);
        }
        for (var i = 0u; i + 1u < N_AGAIN; i++) {
            begins[i] = begins[i + 1u];
        }
        begins[N_AGAIN - 1u] = begin;
        for (var layer = 0u; layer < n_layers(); layer++) {
            sums_of_layers[layer] = vec2(0.0);
        }
        n_staged = 0u;
        is_whole = true;
        var summed = Summed(begin, 0u, sheet + 1u, true);
        if begin < todo.end && sheet < end_sheet {
            summed = sum_sheet(begin, todo.end, sheet, pixel, is_open);
        }
        if !is_whole {
            atomicStore(&is_faulty[0], 1u);
        }
        if !summed.is_open {
            return Reached(begin, sheet, STATE_SATURATED);
        }
        if first_shown <= sheet {
            atomicAdd(&n_splatted, n_staged);
        }
        begin = summed.begin;
        begin_sheet();
        if 0u < summed.n_alive {
            n_empty = 0u;
            push_densities(sheet, pixel);
        } else {
            n_empty++;
            for (var layer = 0u; layer < n_layers(); layer++) {
                push_sheet(layer, vec4(0.0));
            }
        }
        let next = select(sheet + 1u, summed.next_sheet, N_SHEETS <= n_empty);
        if is_open && first_shown <= sheet {
            showing(sheet, next, pixel);
            is_open = held[0].a < frame.opacity_cutoff;
        }
        n_visits += summed.n_alive + 1u;
        last_sheet = sheet;
        sheet = next;
    }
    if (begin < todo.end && sheet < end_sheet) || (n_empty < N_BEHIND && !is_limited) {
        atomicStore(&is_faulty[0], 1u);
    }
    if is_limited {
        // What lies before the last sheets is not shown, as it may change with those behind.
        let state = select(STATE_SATURATED, STATE_CUT, is_any_open(pixel.thread, is_open));
        return Reached(begin, last_sheet, state);
    }
    return Reached(begin, sheet, STATE_DONE);
}

// What a sheet holds of the tile's splats: the same for all pixels.
struct Summed {
    // The slot of the first splat that still reaches into the sheet.
    begin: u32,
    // Splats that do.
    n_alive: u32,
    // The sheet in which the first splat behind them begins.
    next_sheet: u32,
    // Whether any pixel can still change; if not, nothing was summed.
    is_open: bool,
}

fn sum_sheet(begin: u32, end: u32, sheet: u32, pixel: Pixel, is_open: bool) -> Summed {
    var summed = Summed(begin, 0u, NO_SHEET, true);
    // The layer of what is being summed.
    var layer = 0u;
    var sum = vec2(0.0);
    // The slot of the batch.
    var first = begin;
    var is_last = false;
    loop {
        workgroupBarrier();
        let candidate = look_at(first + pixel.thread, end, sheet, pixel.thread);
        let now = run_of(sheet, pixel.thread, candidate, is_open);
        if now.is_open == 0u {
            summed.is_open = false;
            return summed;
        }
        if candidate.is_drawn {
            let slot = n_drawn_before(pixel.thread);
            stage_section(candidate.splat, candidate.layer, sheet, slot);
            n_staged++;
        }
        workgroupBarrier();
        var i = 0u;
        while i < now.n_drawn {
            if 1u < MOST_LAYERS && staged_layer(i) != layer {
                sums_of_layers[layer] = sum;
                layer = staged_layer(i);
                sum = sums_of_layers[layer];
            }
            sum += staged[i].color.wx * weight_at(i, pixel.at);
            i++;
        }
        is_whole = is_whole && now.n_drawn <= i;
        if 0u < now.n_dead {
            summed.begin = first + now.n_dead;
        }
        summed.n_alive += now.end - now.n_dead;
        first += BATCH;
        summed.next_sheet = now.next_sheet;
        is_last = now.end < BATCH || end <= first;
        if is_last {
            break;
        }
    }
    sums_of_layers[layer] = sum;
    is_whole = is_whole && is_last;
    return summed;
}

// Puts what was summed with the five sheets before. Layers take turns at the sums that neighbours see: those
// of all together would not fit into the memory of a workgroup.
fn push_densities(sheet: u32, pixel: Pixel) {
    for (var layer = 0u; layer < n_layers(); layer++) {
        let own = sums_of_layers[layer];
        let limits = densities[layer].values * own.x;
        let limited = vec2(own.x, clamp(own.y, limits.x, limits.y));
        if 0u < layer {
            workgroupBarrier();
        }
        sums[pixel.thread] = select(vec2(0.0), limited, 0.0 < own.x);
        workgroupBarrier();
        push_sheet(layer, density_of(layer, sheet, pixel));
    }
}

// An element of `table` that holds numbers.
fn number_at(element: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(table[element]);
}

// What a sheet of a layer is to a pixel, from the sums of the pixel and of its neighbours.
fn density_of(layer: u32, sheet: u32, pixel: Pixel) -> vec4<f32> {
    if !pixel.is_shown {
        return vec4(0.0);
    }
    let idx = pixel.thread;
    let here = sums[idx];
    var density = 0.0;
    if 0.0 < here.x {
        density = here.y / here.x;
    }
    let per_pixel = scale_at(layer, middle_of(layer, sheet));
    let right = difference(here.x, density, sums[idx + 1u], sums[idx - 1u]);
    let up = difference(here.x, density, sums[idx - SIDE], sums[idx + SIDE]);
    return vec4(here.x, density, per_pixel * right, per_pixel * up);
}

// The change of the density from one neighbour to here and from here to the other one, weighted by how much
// of each there is. It is taken from sums: densities would be rounded once more, and neighbours are nearly
// alike.
fn difference(length: f32, density: f32, after: vec2<f32>, before: vec2<f32>) -> f32 {
    let both = max(after.x + before.x, length);
    if both <= 0.0 {
        return 0.0;
    }
    return ((after.y - after.x * density) - (before.y - before.x * density)) / both;
}

// The first node's depth, where `sheet` is the last of the six, in thicknesses of a sheet.
fn depth_of_first_node(sheet: u32) -> f32 {
    return f32(frame.first_slab + i32(sheet) - i32(N_SHEETS - 1u - FIRST)) + 0.5;
}
