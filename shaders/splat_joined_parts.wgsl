// What lies between sheets of densities is classified, lit and composited (model §§8, 10), of several layers
// or beside meshes.
//
//   for each layer: its part between the same two sheets
//   put the sum of all behind the pixel, as any sheet, and end rays that meet a surface on the way

//#include "shared/densities_among_others.wgsl"
//#include "shared/density_tile.wgsl"
//#include "shared/parts.wgsl"

const MOST_HELD: u32 = 1u;

@compute @workgroup_size(10, 10)
fn splat_joined_parts(
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    render_tile(local.xy, thread, linear_group(group, n_groups));
}

fn n_held() -> u32 {
    return 1u;
}

fn showing(sheet: u32, next: u32, pixel: Pixel) {
    var sums = vec4(0.0);
    for (var layer = 0u; layer < n_layers(); layer++) {
        if come_to(layer) {
            sums += joining(sums_of_part(layer, sheet, pixel));
        }
    }
    sums = joined(sums);
    if has_surfaces() && any_ends_before(next) {
        held[0] = end_rays(held[0], sums, sheet, next);
    } else {
        held[0] += (1.0 - held[0].a) * resolve(frame.compositing, sums);
    }
}

// What a part adds to the sum of several. In `separate` colours are weighted, and so a mean: voxels add
// theirs however faint they are, and layers do not.
fn joining(sums: vec4<f32>) -> vec4<f32> {
    if n_layers() == 1u || weights_colors(frame.compositing) {
        return sums;
    }
    return vec4(sums.a * min(sums.rgb, vec3(1.0)), sums.a);
}

// What is composited of such a sum.
fn joined(sums: vec4<f32>) -> vec4<f32> {
    if n_layers() == 1u || weights_colors(frame.compositing) || sums.a <= 0.0 {
        return sums;
    }
    return vec4(sums.rgb / sums.a, sums.a);
}

fn shown() -> vec4<f32> {
    return end_rays_before(held[0], NO_SHEET);
}
