// Composites whole footprints, one by one: `every-sample`.

//#include "shared/radial_whole.wgsl"

const METHOD: u32 = METHOD_VOXELS;

@compute @workgroup_size(8, 8)
fn splat_voxels(
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    render_tile(local.xy, thread, linear_group(group, n_groups));
}
