// Sections of voxels by polynomials, for slabs whose faces cut all rays of a footprint alike.

//#include "shared/color_tile.wgsl"
//#include "shared/radial_footprint.wgsl"

const METHOD: u32 = METHOD_SECTIONS;

fn is_drawn(splat: Splat, layer: u32, slab: u32) -> bool {
    return is_drawn_in(slab, splat.span, layer, splat.center.z);
}

// Stages the section of a splat in a slab.
fn stage(splat: Splat, layer: u32, slab: u32, slot: u32) {
    let section = section_in(slab, splat.span, layer, splat.center.z);
    stage_place(splat, layer, middle_of(layer, slab), slot);
    stage_coefficients(row_at(layer, section), section.faces, slot);
}
