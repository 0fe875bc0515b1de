// Splatting and compositing: a workgroup renders a tile, a thread a pixel, sheet by sheet from the eye. The
// pixel's sheet and the composited pixel stay in registers.
//
//   for each sheet that any of the tile's splats reaches into, until all pixels are saturated:
//       for each batch of 64 splats from the first that still reaches into it:
//           every thread stages one splat: where it lies in this sheet, and its row of the table
//           every thread adds all staged splats to its pixel
//       put the sheet behind the pixel
//
// The tile's splats are sorted by the sheet in which they begin. So those that a sheet needs are a run
// of the list, which moves along it with the sheets. `every-sample` has no sheets: there, all splats of the
// list form one run, and each is put behind the pixel by itself.
//
// The splats of all layers are in one list. Those that begin in one sheet come layer by layer, and layers of
// one region follow each other: so a pixel has sums of one region at a time. Where the next splat has another
// region, they are multiplied by their region's share of the sheet, and put aside.
//
// Where opaque surfaces are, rays of a pixel's samples end on their way from sheet to sheet, also between
// those that any splat reaches into, and behind them.
//
// A tile that has visited many splats pauses after a sheet, and the next dispatch continues it: systems
// reset devices that do not answer for seconds.

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
//#include "shared/footprint.wgsl"
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

@compute @workgroup_size(8, 8)
fn splat(
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let place = linear_group(group, n_groups);
    if step.n_elements <= place {
        return;
    }
    let tile = step.first + place;
    let todo = begin_turn(tile, thread);
    if !is_to_do(todo) {
        return;
    }
    let at = vec2(tile % frame.n_tiles.x, tile / frame.n_tiles.x) * TILE_SIDE + local.xy;
    let is_inside = all(at < frame.image_size);
    let pixel_idx = (at.y - step.first_sample) * frame.image_size.x + at.x;
    var pixel = vec4(0.0);
    rays = rays_of(tile, thread);
    if is_inside && todo.state == STATE_PAUSED {
        pixel = pixels[pixel_idx];
        skip_rays(todo.sheet);
    }
    let done = composite(todo, pixel, thread, at, is_inside);
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
    at: vec2<u32>,
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
    var interval = interval_of(0u, vec2<f32>(at) + 0.5);
    while begin < todo.end && sheet < frame.n_sheets {
        if frame.max_visits < n_visits {
            atomicAdd(&n_splatted, n_staged);
            return Composited(pixel, Reached(begin, sheet, STATE_PAUSED));
        }
        var sums = vec4(0.0);
        // Of other regions, cut.
        var joined = vec4(0.0);
        var n_alive = 0u;
        // The place of the batch.
        var first = begin;
        var next_sheet = NO_SHEET;
        var is_last = false;
        loop {
            workgroupBarrier();
            let is_staged = stage(first + thread, todo.end, sheet, thread);
            if thread == 0u {
                batch.is_open = 0u;
            }
            workgroupBarrier();
            find_run(sheet, thread, is_open);
            let now = workgroupUniformLoad(&batch);
            if now.is_open == 0u {
                cull(first, todo.end, sheet, thread);
                atomicAdd(&n_splatted, n_staged);
                return Composited(pixel, Reached(first, sheet, STATE_FULL));
            }
            n_staged += is_staged;
            if is_open {
                var i = now.n_dead;
                while i < now.end {
                    if frame.has_regions == 1u {
                        let next = layers[staged[i].layer].region;
                        if next != region {
                            joined += sums * share_of(region, interval, sheet);
                            sums = vec4(0.0);
                            region = next;
                            interval = interval_of(region, vec2<f32>(at) + 0.5);
                        }
                    }
                    let splat = weighted(i, vec2<f32>(at) + 0.5);
                    if frame.method == METHOD_VOXELS {
                        pixel += (1.0 - pixel.a) * resolve(frame.compositing, splat);
                    } else {
                        sums += splat;
                    }
                    i++;
                }
                is_whole = is_whole && now.end <= i;
            }
            if 0u < now.n_dead {
                begin = first + now.n_dead;
            }
            if frame.method == METHOD_VOXELS {
                is_open = is_inside && pixel.a < frame.opacity_cutoff;
                begin = first + now.end;
            }
            n_alive += now.end - now.n_dead;
            first += BATCH;
            next_sheet = now.next_sheet;
            is_last = now.end < BATCH || todo.end <= first
                || (frame.method == METHOD_VOXELS && frame.max_visits < n_visits + n_alive);
            if is_last {
                break;
            }
        }
        is_whole = is_whole && is_last;
        if frame.has_regions == 1u {
            sums = joined + sums * share_of(region, interval, sheet);
        }
        next_sheet = select(next_sheet, sheet + 1u, 0u < n_alive);
        if has_surfaces() && any_ends_before(next_sheet) {
            pixel = end_rays(pixel, sums, sheet, next_sheet);
        } else {
            pixel += (1.0 - pixel.a) * resolve(frame.compositing, sums);
        }
        is_open = is_inside && pixel.a < frame.opacity_cutoff;
        n_visits += n_alive + 1u;
        if frame.method != METHOD_VOXELS {
            sheet = next_sheet;
        }
    }
    if !is_whole || (begin < todo.end && sheet < frame.n_sheets) {
        atomicStore(&is_faulty, 1u);
    }
    atomicAdd(&n_splatted, n_staged);
    return Composited(pixel, Reached(begin, sheet, STATE_DONE));
}

// Stages the splat at a place of the list; 1 if the sheet holds it.
fn stage(place: u32, end: u32, sheet: u32, thread: u32) -> u32 {
    staged[thread].sheet = NO_SHEET;
    staged[thread].rho_squared_max = -1.0;
    if end <= place {
        return 0u;
    }
    let voxel = tossed_voxels[place];
    let splat = splat_at(voxel);
    let layer = layer_of(voxel);
    staged[thread].sheet = splat.sheet;
    staged[thread].layer = layer;
    if sheet < splat.sheet {
        return 0u;
    }
    if frame.method == METHOD_SECTIONS {
        if stage_section(splat, layer, sheet, thread) == 0u {
            return 0u;
        }
        let row = row_at(layer, staged[thread].front, staged[thread].back);
        staged[thread].row = row.first_element;
        staged[thread].row_t = row.t;
        return 1u;
    }
    if frame.method == METHOD_SLICES && splat.sheet < sheet {
        return 0u;
    }
    stage_shape(splat, layer, splat.center.z, thread);
    staged[thread].rho_squared_max = frame.radius * frame.radius;
    staged[thread].row = 0u;
    staged[thread].row_t = 0.0;
    return 1u;
}

// The staged splat at a pixel's centre.
fn weighted(i: u32, at: vec2<f32>) -> vec4<f32> {
    // Nothing else of a splat that is not to be seen was staged.
    if staged[i].rho_squared_max <= 0.0 {
        return vec4(0.0);
    }
    let d = at - staged[i].center;
    let x = d.x + staged[i].lean * d.y;
    let rho_squared = staged[i].across * x * x + staged[i].along * d.y * d.y;
    if staged[i].rho_squared_max <= rho_squared {
        return vec4(0.0);
    }
    var row = Row(staged[i].row, staged[i].row_t);
    if frame.is_tilted == 1u && frame.method == METHOD_SECTIONS {
        let later = dot(staged[i].tilt, d);
        row = row_at(staged[i].layer, staged[i].front + later, staged[i].back + later);
    }
    return staged[i].color * weight_at(row, rho_squared);
}
