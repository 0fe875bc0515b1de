// Splats sections that are read from a table, pixel by pixel: where faces cut the rays of a footprint at
// different offsets, where rows between two are not to be blended, or where no polynomial is good enough.

//#include "shared/color_tile.wgsl"
//#include "shared/footprint.wgsl"

const METHOD: u32 = METHOD_SECTIONS;

@compute @workgroup_size(8, 8)
fn splat_table_sections(
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    render_tile(local.xy, thread, linear_group(group, n_groups));
}

// Stages the section of a splat in a slab.
fn stage(splat: Splat, layer: u32, slab: u32, slot: u32) {
    let section = stage_section(splat, layer, slab, slot);
    staged[slot].center -= corner;
    let row = row_at(layer, section);
    staged[slot].row = row.first_element;
    staged[slot].row_t = row.t;
}

// ρ² of a staged splat at a place of the tile.
fn form_at(i: u32, at: vec2<f32>) -> f32 {
    let d = at - staged[i].center;
    let x = d.x + staged[i].shear * d.y;
    return staged[i].across * x * x + staged[i].along * d.y * d.y;
}

fn is_within(i: u32, rho_squared: f32) -> bool {
    return rho_squared < staged[i].rho_squared_max;
}

fn weight_of(i: u32, at: vec2<f32>, rho_squared: f32) -> f32 {
    var row = Row(staged[i].row, staged[i].row_t);
    if frame.is_tilted == 1u {
        let later = dot(staged[i].tilt, at - staged[i].center);
        let faces = vec2(staged[i].front, staged[i].back) + later;
        row = row_at(staged[i].layer, Section(faces, staged[i].is_merged == 1u));
    }
    return weight_at(row, rho_squared);
}
