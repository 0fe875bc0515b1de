// Where what is splatted lies (model §5), the tiles that it touches, and the sheet in which it begins: the twin
// of the CPU's `project.rs` and `toss.rs`.
//
// Whoever includes this declares `records`, an element of which is a voxel or a cell of a layer.

//#include "shared/step.wgsl"
//#include "shared/frame.wgsl"
//#include "shared/layer.wgsl"
//#include "shared/coords.wgsl"
//#include "shared/splat.wgsl"
//#include "shared/pixels.wgsl"
//#include "shared/slabs.wgsl"
//#include "shared/spans.wgsl"
//#include "shared/tile.wgsl"
//#include "shared/tile_work.wgsl"
//#include "shared/compositing.wgsl"
//#include "shared/region.wgsl"
//#include "shared/light.wgsl"

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> layers: array<Layer, MAX_LAYERS>;
@group(0) @binding(2) var<uniform> step: Step;
@group(0) @binding(3) var<storage, read> table: array<vec4<u32>>;
// The splats of all layers, as many as are bound.
@group(0) @binding(5) var<storage, read_write> splats: array<Splat>;
// By voxel: what the list is sorted by, the voxel itself, and the tiles that it touches.
@group(0) @binding(6) var<storage, read_write> keys: array<u32>;
@group(0) @binding(7) var<storage, read_write> order: array<u32>;
@group(0) @binding(8) var<storage, read_write> rects: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read_write> counts: array<u32>;
@group(0) @binding(10) var<storage, read> tiles: array<TileWork>;

// Whether there is a record for a thread. Behind the records of a layer there is room for some more, which the
// next one leaves.
fn is_listed(record_of_pass: u32) -> bool {
    let record_idx = step.first + record_of_pass;
    if record_idx == 0u {
        begin_counts();
    }
    if step.n_elements <= record_of_pass {
        return false;
    }
    let is_there = record_idx < counts[step.count_slot];
    if !is_there && 1u < frame.n_layers {
        let voxel = layers[step.layer].first_voxel + record_idx;
        keys[voxel] = 0u;
        order[voxel] = voxel;
        rects[voxel] = NO_TILES;
    }
    return is_there;
}

// By one thread of each layer, one layer after the other: how many voxels there are so far.
fn begin_counts() {
    if step.layer == 0u {
        counts[COUNT_FAULTS] = 0u;
        counts[COUNT_HIDDEN] = 0u;
        counts[COUNT_HIDDEN + 1u] = 0u;
        counts[COUNT_VOXELS] = counts[step.count_slot];
    } else {
        counts[COUNT_VOXELS] += counts[step.count_slot];
    }
}

// The index among those that are bound.
fn in_chunk(idx: u32) -> u32 {
    return idx & ((1u << step.chunk_bits) - 1u);
}

// Puts a record into its sheet and onto its tiles; whether it was hidden on all of them.
fn is_placed(record_of_pass: u32, span: u32, center: vec3<f32>) -> bool {
    let voxel = layers[step.layer].first_voxel + step.first + record_of_pass;
    let sheet = sheet_of(span, step.layer);
    let rect = rect_of(center, span);
    let is_hidden = is_hidden_on(rect, sheet);
    keys[voxel] = sheet;
    order[voxel] = voxel;
    rects[voxel] = vec2(rect.x, rect.y | select(0u, HIDDEN, is_hidden));
    return !is_hidden;
}

// Writes the splat of a record.
fn put_splat(record_of_pass: u32, center: vec3<f32>, span: u32, color: vec4<f32>) {
    let voxel = layers[step.layer].first_voxel + step.first + record_of_pass;
    splats[in_chunk(voxel)] = Splat(center, span, color);
}

// Tiles that are looked at, as most voxels touch no more.
const MOST_LOOKED_AT: u32 = 16u;

// Whether what begins in a sheet was hidden on all tiles of a rectangle in the frame before.
fn is_hidden_on(rect: vec2<u32>, sheet: u32) -> bool {
    let size = rect_size(rect);
    let n = size.x * size.y;
    if n == 0u || MOST_LOOKED_AT < n {
        return false;
    }
    let first_tile = (rect.x >> 16u) * frame.n_tiles.x + (rect.x & 0xffffu);
    for (var i = 0u; i < n; i++) {
        let tile = first_tile + i / size.x * frame.n_tiles.x + i % size.x;
        if sheet <= tiles[tile].last_tossed {
            return false;
        }
    }
    return true;
}

// A point of index space in view space.
fn in_view(at: vec3<f32>) -> vec3<f32> {
    let layer = step.layer;
    let from_center = at - layers[layer].center_in_index;
    return vec3(
        dot(layers[layer].right.xyz, from_center) + layers[layer].right.w,
        dot(layers[layer].up.xyz, from_center) + layers[layer].up.w,
        dot(layers[layer].depth.xyz, from_center) + layers[layer].depth.w,
    );
}

// The slabs of a record at a depth that sums so much, or its slice.
fn span_or_slice(coords: vec3<u32>, depth: f32, summed: f32) -> u32 {
    let layer = step.layer;
    switch frame.method {
        case METHOD_SECTIONS, METHOD_DENSITIES: {
            return span_of(layer, depth, summed);
        }
        case METHOD_SLICES: {
            let axis = layers[layer].slice_axis;
            let slice = coords[axis & 3u];
            return select(slice, frame.n_sheets - 1u - slice, 4u <= axis);
        }
        default: {
            return 0u;
        }
    }
}

// The rectangle of pixels that a whole kernel covers at a depth, as its least and its largest corner.
fn bounds_at(center: vec3<f32>, depth: f32) -> vec4<f32> {
    let scale = scale_at(step.layer, depth);
    let pixels = scale * stretch_of(step.layer, scale);
    let half = layers[step.layer].half_extent * (pixels * frame.radius);
    let at = pixel_of(center, scale);
    return vec4(at - half, at + half);
}

// A section's position and size change monotonically with its slab's depth, so that the first and the last
// section bound all of them.
fn rect_of(center: vec3<f32>, span: u32) -> vec2<u32> {
    if frame.method == METHOD_SECTIONS || frame.method == METHOD_DENSITIES {
        let first = sheet_of(span, step.layer);
        let last = last_slab_of(span, step.layer, center.z);
        if last < first || is_beyond(step.layer, center) {
            return NO_TILES;
        }
        let near = bounds_at(center, middle_of(step.layer, first));
        let far = bounds_at(center, middle_of(step.layer, last));
        // Slopes of densities are differences to the next pixels, beside the tile too.
        let beside = select(0.0, 1.0, frame.method == METHOD_DENSITIES);
        return tiles_within(min(near.xy, far.xy) - beside, max(near.zw, far.zw) + beside);
    }
    if center.z < layers[step.layer].near {
        return NO_TILES;
    }
    let bounds = bounds_at(center, center.z);
    return tiles_within(bounds.xy, bounds.zw);
}

// The tiles that have pixel centres within two corners.
fn tiles_within(least: vec2<f32>, largest: vec2<f32>) -> vec2<u32> {
    // Pixel p has its centre at p + ½. What lies outside of the image is cut off before it is a number.
    let end = vec2<f32>(frame.n_tiles * TILE_SIDE);
    let first = vec2<u32>(clamp(ceil(least - 0.5), vec2(0.0), end));
    let behind = vec2<u32>(clamp(floor(largest + 0.5), vec2(0.0), end));
    if any(behind <= first) {
        return NO_TILES;
    }
    let first_tile = first / TILE_SIDE;
    let last_tile = (behind - 1u) / TILE_SIDE;
    return vec2((first_tile.y << 16u) | first_tile.x, (last_tile.y << 16u) | last_tile.x);
}
