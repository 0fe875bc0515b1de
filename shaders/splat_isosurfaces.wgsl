// Surfaces on which the densities of a layer that is alone have given values (model §12).
//
//   for each that the ray passes between the two nodes in the middle: put it behind the pixel

//#include "shared/density_alone.wgsl"
//#include "shared/density_tile.wgsl"
//#include "shared/isosurfaces.wgsl"

const MOST_HELD: u32 = 1u;

@compute @workgroup_size(10, 10)
fn splat_isosurfaces(
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
    var passed = passed_from(0u, 0u, sheet, pixel);
    while is_passed(passed) {
        put_behind(0u, passed, pixel);
        passed = passed_from(0u, passed.nth + 1u, sheet, pixel);
    }
}

fn shown() -> vec4<f32> {
    return held[0];
}
