// Sections of voxels by polynomials, for slabs whose faces cut all rays of a footprint alike.

//#include "shared/color_tile.wgsl"
//#include "shared/radial_footprint.wgsl"

const METHOD: u32 = METHOD_SECTIONS;

// Stages the section of the splat at a place of the list; 1 if the slab holds it.
fn stage(place: u32, end: u32, slab: u32, thread: u32) -> u32 {
    stage_nothing(thread);
    if end <= place {
        return 0u;
    }
    let voxel = tossed_voxels[place];
    let splat = splat_at(voxel);
    let layer = layer_of(voxel);
    staged[thread].sheet = splat.sheet;
    staged[thread].layer = layer;
    let depth = splat.center.z;
    if slab < splat.sheet || !is_met(depth, layer, slab) {
        return 0u;
    }
    let faces = faces_behind(depth, layer, slab);
    stage_place(splat, layer, middle_of(layer, slab), thread);
    stage_coefficients(row_at(layer, faces.x, faces.y), faces, thread);
    return 1u;
}
