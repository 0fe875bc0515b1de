// Shades and projects cells of voxels (model §16), where pixels are larger than these: the twin of the CPU's
// `on_demand.rs`.

//#include "shared/cell_record.wgsl"
//#include "shared/projection.wgsl"
//#include "shared/cell_light.wgsl"

// The cells of a layer, as many as are bound.
@group(0) @binding(4) var<storage, read> records: array<CellRecord>;

@compute @workgroup_size(256)
fn project_cells(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    let record_of_pass = linear_group(group, n_groups) * 256u + thread;
    if !is_listed(record_of_pass) {
        return;
    }
    let record = records[in_chunk(step.first + record_of_pass)];
    let coords = coords_of(record.cell_idx, layers[step.layer].dims);
    let center = in_view(within_ends(coords));
    let span = span_or_slice(coords, center.z, record.extinction);
    if is_placed(record_of_pass, span, center) {
        let color = lit_color(cell_of(record));
        let summed = summed_color(frame.compositing, color, record.extinction);
        put_splat(record_of_pass, center, span, summed);
    }
}

// Where a cell is: the first and the last along an axis lie further out than their indices say, so that the grid
// ends where its voxels do.
fn within_ends(coords: vec3<u32>) -> vec3<f32> {
    let layer = step.layer;
    let is_last = coords + 1u == layers[layer].dims;
    let last = vec3<f32>(coords) + select(vec3(0.0), layers[layer].last_out, is_last);
    return select(last, vec3<f32>(coords) - layers[layer].first_out, coords == vec3(0u));
}

// No lit face is near, as bricks there are drawn by voxels.
fn lit_color(cell: CellValues) -> vec3<f32> {
    if layers[step.layer].is_lit == 0u {
        return cell.color;
    }
    let light = light_on_cell(step.layer, cell);
    return clamp(cell.color * light.diffuse + light.specular, vec3(0.0), vec3(1.0));
}
