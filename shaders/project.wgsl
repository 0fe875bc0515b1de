// Shades every relevant voxel (model §6) and projects it: the twin of the CPU's `shade.rs`, too.

//#include "shared/record.wgsl"
//#include "shared/projection.wgsl"

// The layer's records, as many as are bound.
@group(0) @binding(4) var<storage, read> records: array<Record>;

@compute @workgroup_size(256)
fn project(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let record_of_pass = linear_group(group, n_groups) * 256u + thread;
    if !is_listed(record_of_pass) {
        return;
    }
    let record = records[in_chunk(step.first + record_of_pass)];
    let coords = coords_of(record.voxel_idx, layers[step.layer].dims);
    let center = in_view(vec3<f32>(coords));
    let span = span_or_slice(coords, center.z, record.color.a);
    if is_placed(record_of_pass, span, center) {
        put_splat(record_of_pass, center, span, splat_color(record, center));
    }
}

// The voxel's colour and weight in the form that the compositing sums.
fn splat_color(record: Record, center: vec3<f32>) -> vec4<f32> {
    if frame.method == METHOD_DENSITIES {
        return record.color;
    }
    var color = record.color.rgb;
    if layers[step.layer].is_lit == 1u {
        color = light_up(color, normal_by_faces(step.layer, center, record.normal));
    }
    return summed_color(frame.compositing, color, record.color.a);
}

fn light_up(color: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let light = light_on(step.layer, normal);
    return clamp(color * light.diffuse + light.specular, vec3(0.0), vec3(1.0));
}
