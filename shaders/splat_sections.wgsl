// Splats sections by polynomials of a low degree, where the picture's tolerance permits it.

//#include "shared/radial_sections.wgsl"

const N_QUADS: u32 = 2u;

@compute @workgroup_size(8, 8)
fn splat_sections(
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    render_tile(local.xy, thread, linear_group(group, n_groups));
}
