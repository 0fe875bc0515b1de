// Splatting and compositing: a workgroup renders a tile, a thread a pixel, sheet by sheet from the eye. The
// pixel's sheet and the composited pixel stay in registers.
//
//   for each sheet that any of the tile's splats reaches into, until all pixels are saturated:
//       for each batch of 64 splats from the first that still reaches into it:
//           every thread stages one splat, if the sheet holds it: where it lies there, and what weighs it
//           every thread adds all staged splats to its pixel
//       put the sheet behind the pixel
//
// The tile's splats are sorted by the sheet in which they begin. So those that a sheet needs are a run
// of the list, which moves along it with the sheets. `every-sample` has no sheets: there, all splats of the
// list form one run, and each is put behind the pixel by itself.
//
// How splats are staged, and how much they weigh at a pixel, is said by a stage for each kind of them: one
// stage for all would ask at every pixel which kind it is.
//
// The splats of all layers are in one list. Those that begin in one sheet come layer by layer, and layers of
// one region follow each other: so a pixel has sums of one region at a time. Where the next splat has another
// region, they are multiplied by their region's share of the sheet, and put aside. All of them together are
// multiplied by the share of the part of the frame that is drawn.
//
// Where opaque surfaces are, rays of a pixel's samples end on their way from sheet to sheet, also between
// those that any splat reaches into, and behind them.
//
// A tile that has visited many splats pauses after a sheet, and the next dispatch continues it: systems
// reset devices that do not answer for seconds.
//
// Whoever includes this declares `METHOD`, stages splats by `stage`, says by `is_drawn` which a sheet holds, and by
// `form_at`, `is_within` and `weight_of` what they weigh.

//#include "shared/step.wgsl"
//#include "shared/frame.wgsl"
//#include "shared/layer.wgsl"
//#include "shared/splat.wgsl"
//#include "shared/pixels.wgsl"
//#include "shared/slabs.wgsl"
//#include "shared/table.wgsl"
//#include "shared/tile.wgsl"
//#include "shared/tile_work.wgsl"
//#include "shared/tile_turn.wgsl"
//#include "shared/compositing.wgsl"
//#include "shared/region.wgsl"
//#include "shared/surfaces.wgsl"

@group(0) @binding(0) var<uniform> frame: Frame;
// The tiles `first .. first + n_elements`; the first pixel that is bound is that of row `first_sample`.
@group(0) @binding(1) var<uniform> step: Step;
@group(0) @binding(2) var<uniform> layers: array<Layer, MAX_LAYERS>;
@group(0) @binding(3) var<storage, read> tossed_voxels: array<u32>;
@group(0) @binding(4) var<storage, read> table: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> tiles: array<TileWork>;
@group(0) @binding(6) var<storage, read_write> pixels: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> splats_0: array<Splat>;
@group(0) @binding(8) var<storage, read> splats_1: array<Splat>;
@group(0) @binding(9) var<storage, read> splats_2: array<Splat>;
@group(0) @binding(10) var<storage, read> splats_3: array<Splat>;

const BATCH: u32 = 64u;

// Of the tile, in pixels from the image's upper left corner. Places on the tile are counted from it.
var<private> corner: vec2<f32>;

fn render_tile(local: vec2<u32>, thread: u32, tile_of_pass: u32) {
    if step.n_elements <= tile_of_pass {
        return;
    }
    let tile = step.first + tile_of_pass;
    let todo = begin_turn(tile, thread);
    if !is_to_do(todo) {
        return;
    }
    let first_pixel = vec2(tile % frame.n_tiles.x, tile / frame.n_tiles.x) * TILE_SIDE;
    corner = vec2<f32>(first_pixel);
    let own = first_pixel + local;
    let is_inside = all(own < frame.image_size);
    let pixel_idx = (own.y - step.first_sample) * frame.image_size.x + own.x;
    var pixel = vec4(0.0);
    rays = rays_of(tile, thread);
    if is_inside && todo.state == STATE_PAUSED {
        pixel = pixels[pixel_idx];
        skip_rays(todo.sheet);
    }
    let done = composite(todo, pixel, thread, vec2<f32>(local) + 0.5, is_inside);
    if is_inside {
        pixels[pixel_idx] = done.pixel;
        if done.reached.state != STATE_PAUSED {
            let last = end_rays_before(done.pixel, NO_SHEET);
            pixels[pixel_idx] = over_background(last);
        }
    }
    end_turn(tile, thread, todo, done.reached);
}

struct Composited {
    pixel: vec4<f32>,
    reached: Reached,
}

// The tile's sheets, front to back.
fn composite(
    todo: TileWork,
    pixel_before: vec4<f32>,
    thread: u32,
    at: vec2<f32>,
    is_inside: bool,
) -> Composited {
    // The run that the sheet needs begins here.
    var begin = todo.begin;
    var sheet = first_sheet(todo);
    var pixel = end_rays_before(pixel_before, sheet);
    var is_open = is_inside && pixel.a < frame.opacity_cutoff;
    var n_staged = 0u;
    var n_visits = 0u;
    var is_whole = true;
    // The region of what is being summed, and where the ray is in it.
    var region = 0u;
    var interval = interval_of(0u, corner + at);
    let has_regions = frame.has_regions == 1u;
    let compositing = frame.compositing;
    let end_sheet = end_of_sheets(todo);
    var last_sheet = sheet;
    while begin < todo.end && sheet < end_sheet {
        if frame.max_visits < n_visits {
            atomicAdd(&n_splatted, n_staged);
            return Composited(pixel, Reached(begin, sheet, STATE_PAUSED));
        }
        var sums = vec4(0.0);
        // Of other regions, cut.
        var joined = vec4(0.0);
        var n_alive = 0u;
        // The slot of the batch.
        var first = begin;
        var next_sheet = NO_SHEET;
        var is_last = false;
        loop {
            workgroupBarrier();
            let candidate = look_at(first + thread, todo.end, sheet, thread);
            let now = run_of(sheet, thread, candidate, is_open);
            if now.is_open == 0u {
                atomicAdd(&n_splatted, n_staged);
                return Composited(pixel, Reached(first, sheet, STATE_SATURATED));
            }
            if candidate.is_drawn {
                stage(candidate.splat, candidate.layer, sheet, n_drawn_before(thread));
                n_staged++;
            }
            workgroupBarrier();
            if is_open {
                var i = 0u;
                while i < now.n_drawn {
                    var end = now.n_drawn;
                    if has_regions {
                        let next = layers[staged[i].layer].region;
                        if next != region {
                            joined += sums * share_of(region, interval, sheet);
                            sums = vec4(0.0);
                            region = next;
                            interval = interval_of(region, corner + at);
                        }
                        end = end_of_region(i, now.n_drawn);
                    }
                    // The innermost loop. What is staged is a power of two, so that an index modulo that is
                    // itself, and compilers know how large it is: then they put offsets into loads.
                    while i < end {
                        let form = form_at(i, at);
                        if is_within(i, form) {
                            let splat = staged[i % BATCH].color * weight_of(i, at, form);
                            if METHOD == METHOD_VOXELS {
                                pixel += (1.0 - pixel.a) * resolve(compositing, splat);
                            } else {
                                sums += splat;
                            }
                        }
                        i++;
                    }
                }
                is_whole = is_whole && now.n_drawn <= i;
            }
            if 0u < now.n_dead {
                begin = first + now.n_dead;
            }
            if METHOD == METHOD_VOXELS {
                is_open = is_inside && pixel.a < frame.opacity_cutoff;
                begin = first + now.end;
            }
            n_alive += now.end - now.n_dead;
            first += BATCH;
            next_sheet = now.next_sheet;
            is_last = now.end < BATCH || todo.end <= first
                || (METHOD == METHOD_VOXELS && frame.max_visits < n_visits + n_alive);
            if is_last {
                break;
            }
        }
        is_whole = is_whole && is_last;
        if has_regions {
            sums = joined + sums * share_of(region, interval, sheet);
        }
        if METHOD == METHOD_SECTIONS {
            sums *= share_in_part(corner + at, sheet);
        }
        next_sheet = select(next_sheet, sheet + 1u, 0u < n_alive);
        if has_surfaces() && any_ends_before(next_sheet) {
            pixel = end_rays(pixel, sums, sheet, next_sheet);
        } else {
            pixel += (1.0 - pixel.a) * resolve(compositing, sums);
        }
        is_open = is_inside && pixel.a < frame.opacity_cutoff;
        n_visits += n_alive + 1u;
        last_sheet = sheet;
        if METHOD != METHOD_VOXELS {
            sheet = next_sheet;
        }
    }
    if !is_whole || (begin < todo.end && sheet < end_sheet) {
        atomicStore(&is_faulty[0], 1u);
    }
    atomicAdd(&n_splatted, n_staged);
    if end_sheet < frame.n_sheets {
        let state = select(STATE_SATURATED, STATE_CUT, is_any_open(thread, is_open));
        return Composited(pixel, Reached(begin, last_sheet, state));
    }
    return Composited(pixel, Reached(begin, sheet, STATE_DONE));
}

// Where the run of one region ends among staged splats.
fn end_of_region(begin: u32, most: u32) -> u32 {
    let region = layers[staged[begin].layer].region;
    var end = begin + 1u;
    while end < most && layers[staged[end].layer].region == region {
        end++;
    }
    return end;
}
