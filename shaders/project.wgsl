// Shades every relevant voxel (model §6), projects it (model §5), and finds the tiles that it touches and the
// sheet in which it begins: the twin of the CPU's `shade.rs`, `project.rs` and `toss.rs`.

//#include "shared/step.wgsl"
//#include "shared/frame.wgsl"
//#include "shared/coords.wgsl"
//#include "shared/record.wgsl"
//#include "shared/splat.wgsl"
//#include "shared/pixels.wgsl"
//#include "shared/slabs.wgsl"
//#include "shared/tile.wgsl"
//#include "shared/compositing.wgsl"

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> step: Step;
@group(0) @binding(2) var<storage, read> records: array<Record>;
@group(0) @binding(3) var<storage, read_write> splats: array<Splat>;
// By voxel: what the list is sorted by, the voxel itself, and the tiles that it touches.
@group(0) @binding(4) var<storage, read_write> keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> order: array<u32>;
@group(0) @binding(6) var<storage, read_write> rects: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(256)
fn project(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let local = linear_group(group, n_groups) * 256u + thread;
    let voxel = step.first + local;
    if voxel == 0u {
        counts[COUNT_FAULTS] = 0u;
    }
    if step.n_elements <= local || counts[COUNT_VOXELS] <= voxel {
        return;
    }
    let record = records[local];
    let center = in_view(record.voxel_idx);
    let sheet = sheet_of(record.voxel_idx, center.z);
    splats[local] = Splat(center, sheet, splat_color(record));
    keys[voxel] = sheet;
    order[voxel] = voxel;
    rects[voxel] = rect_of(center, sheet);
}

fn in_view(voxel_idx: u32) -> vec3<f32> {
    let from_center = vec3<f32>(coords_of(voxel_idx, frame.dims)) - frame.center_in_index;
    return vec3(
        dot(frame.right.xyz, from_center) + frame.right.w,
        dot(frame.up.xyz, from_center) + frame.up.w,
        dot(frame.depth.xyz, from_center) + frame.depth.w,
    );
}

fn sheet_of(voxel_idx: u32, depth: f32) -> u32 {
    switch frame.method {
        case METHOD_SECTIONS: {
            return max(slabs_of(depth).x, frame.first_drawn);
        }
        case METHOD_SLICES: {
            let slice = coords_of(voxel_idx, frame.dims)[frame.slice_axis & 3u];
            return select(slice, frame.n_sheets - 1u - slice, 4u <= frame.slice_axis);
        }
        default: {
            return 0u;
        }
    }
}

// The rectangle of pixels that a whole kernel covers at a depth, as its least and its largest corner.
fn bounds_at(center: vec3<f32>, depth: f32) -> vec4<f32> {
    let scale = scale_at(depth);
    let half = frame.half_extent * (scale * stretch_of(scale) * frame.radius);
    let at = pixel_of(center, scale);
    return vec4(at - half, at + half);
}

// A section's place and size change monotonically with its slab's depth, so that the first and the last
// section bound all of them.
fn rect_of(center: vec3<f32>, sheet: u32) -> vec2<u32> {
    if frame.method == METHOD_SECTIONS {
        let last = slabs_of(center.z).y;
        if last < sheet {
            return NO_TILES;
        }
        let near = bounds_at(center, middle_of(sheet));
        let far = bounds_at(center, middle_of(last));
        return tiles_within(min(near.xy, far.xy), max(near.zw, far.zw));
    }
    if center.z < frame.near {
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

// The voxel's colour and weight in the form that the compositing sums.
fn splat_color(record: Record) -> vec4<f32> {
    let color = light_up(record.color.rgb, record.normal);
    return summed_color(frame.compositing, color, record.color.a);
}

fn light_up(color: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    if frame.is_lit == 0u {
        return color;
    }
    if all(normal == vec3(0.0)) {
        return min(color * frame.ambient, vec3(1.0));
    }
    let n_l = facing(normal, frame.to_light);
    var highlight = 0.0;
    if 0.0 < n_l {
        highlight = frame.specular * power(facing(normal, frame.halfway), frame.shininess);
    }
    return clamp(color * (frame.ambient + frame.diffuse * n_l) + highlight, vec3(0.0), vec3(1.0));
}

fn facing(normal: vec3<f32>, direction: vec3<f32>) -> f32 {
    let product = dot(normal, direction);
    return select(max(product, 0.0), abs(product), frame.is_two_sided == 1u);
}

// `pow` is not defined everywhere for 0.
fn power(base: f32, exponent: f32) -> f32 {
    if base <= 0.0 {
        return select(0.0, 1.0, exponent == 0.0);
    }
    return pow(base, exponent);
}
