// Whole footprints by polynomials.

//#include "shared/color_tile.wgsl"
//#include "shared/radial_footprint.wgsl"

const N_QUADS: u32 = 3u;

fn is_drawn(splat: Splat, layer: u32, sheet: u32) -> bool {
    return splat.span == sheet;
}

// Stages a splat.
fn stage(splat: Splat, layer: u32, sheet: u32, slot: u32) {
    stage_place(splat, layer, splat.center.z, slot);
    let row = Row(layers[layer].first_element, 0.0);
    stage_coefficients(row, vec2(-FAR_BEHIND, FAR_BEHIND), slot);
}
