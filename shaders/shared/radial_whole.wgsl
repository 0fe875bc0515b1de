// Whole footprints by polynomials.

//#include "shared/color_tile.wgsl"
//#include "shared/radial_footprint.wgsl"

const N_QUADS: u32 = 3u;

// Index units behind everything.
const FAR_BEHIND: f32 = 1e9;

// Stages the splat at a place of the list; 1 if the sheet holds it.
fn stage(place: u32, end: u32, sheet: u32, thread: u32) -> u32 {
    stage_nothing(thread);
    if end <= place {
        return 0u;
    }
    let voxel = tossed_voxels[place];
    let splat = splat_at(voxel);
    let layer = layer_of(voxel);
    staged[thread].sheet = splat.sheet;
    staged[thread].layer = layer;
    if splat.sheet != sheet {
        return 0u;
    }
    stage_place(splat, layer, splat.center.z, thread);
    let row = Row(layers[layer].first_element, 0.0);
    stage_coefficients(row, vec2(-FAR_BEHIND, FAR_BEHIND), thread);
    return 1u;
}
