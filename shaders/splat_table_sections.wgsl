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

// Stages the section of the splat at a place of the list; 1 if the slab holds it.
fn stage(place: u32, end: u32, slab: u32, thread: u32) -> u32 {
    staged[thread].sheet = NO_SHEET;
    // What is not to be seen has a ρ² of 0 everywhere: before it is written, workgroup memory may hold
    // anything, and so could make a ρ² of less.
    staged[thread].rho_squared_max = -1.0;
    staged[thread].across = 0.0;
    staged[thread].along = 0.0;
    if end <= place {
        return 0u;
    }
    let voxel = tossed_voxels[place];
    let splat = splat_at(voxel);
    let layer = layer_of(voxel);
    staged[thread].sheet = splat.sheet;
    staged[thread].layer = layer;
    if slab < splat.sheet || stage_section(splat, layer, slab, thread) == 0u {
        return 0u;
    }
    staged[thread].center -= corner;
    let row = row_at(layer, staged[thread].front, staged[thread].back);
    staged[thread].row = row.first_element;
    staged[thread].row_t = row.t;
    return 1u;
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
        row = row_at(staged[i].layer, staged[i].front + later, staged[i].back + later);
    }
    return weight_at(row, rho_squared);
}
