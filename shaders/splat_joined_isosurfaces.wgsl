// Surfaces on which the densities of several layers have given values (model §12).
//
//   while the ray passes any between the two nodes in the middle:
//       put the nearest behind the pixel, of two at one depth that of the first layer
//       find the next one of that layer

//#include "shared/densities_among_others.wgsl"
//#include "shared/density_tile.wgsl"
//#include "shared/isosurfaces.wgsl"

const MOST_HELD: u32 = 1u;

@compute @workgroup_size(10, 10)
fn splat_joined_isosurfaces(
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
    // Of each layer the one that the ray passes next.
    var passed: array<Passed, MOST_LAYERS>;
    for (var layer = 0u; layer < n_layers(); layer++) {
        passed[layer] = Passed(0u, BEYOND);
        if come_to(layer) {
            passed[layer] = passed_from(layer, 0u, sheet, pixel);
        }
    }
    loop {
        var nearest = 0u;
        for (var layer = 1u; layer < n_layers(); layer++) {
            if passed[layer].position < passed[nearest].position {
                nearest = layer;
            }
        }
        if !is_passed(passed[nearest]) {
            break;
        }
        come_to(nearest);
        put_behind(nearest, passed[nearest], pixel);
        passed[nearest] = passed_from(nearest, passed[nearest].nth + 1u, sheet, pixel);
    }
}

fn shown() -> vec4<f32> {
    return held[0];
}
