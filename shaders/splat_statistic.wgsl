// One density of a layer that is alone, for all on its ray (model §12): the largest, the least or the mean of
// all sheets.

//#include "shared/density_alone.wgsl"
//#include "shared/density_tile.wgsl"
//#include "shared/statistic.wgsl"

const MOST_HELD: u32 = 1u;

@compute @workgroup_size(10, 10)
fn splat_statistic(
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
    held[0] = found_with_sheet(held[0], 0u, sheet, pixel);
}

fn shown() -> vec4<f32> {
    return shown_by(0u, held[0]);
}
