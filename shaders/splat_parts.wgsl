// What lies between sheets of densities is classified, lit and composited (model §8), of a layer that is
// alone.

//#include "shared/density_alone.wgsl"
//#include "shared/density_tile.wgsl"
//#include "shared/parts.wgsl"

const MOST_HELD: u32 = 1u;

@compute @workgroup_size(10, 10)
fn splat_parts(
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
    let sums = sums_of_part(0u, sheet, pixel);
    held[0] += (1.0 - held[0].a) * resolve(frame.compositing, sums);
}

fn shown() -> vec4<f32> {
    return held[0];
}
