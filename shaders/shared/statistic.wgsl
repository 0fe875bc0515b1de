// One density for all on a ray (model §12): the largest, the least or the mean of all sheets, of the layer
// that the pixel has come to.
//
// Until the last sheet a pixel holds what was found, how much of it, which is 1, or for a mean the length
// that it was taken over, and by how much it counts.

//#include "shared/cells.wgsl"

// A sheet counts in full that holds this part of its thickness.
const FULL_PART: f32 = 1.0 / 16.0;

// What was found, with the first of the two sheets in the middle.
fn found_with_sheet(found: vec4<f32>, layer: u32, sheet: u32, pixel: Pixel) -> vec4<f32> {
    let length = sheets[FIRST].x;
    let is_mean = densities[layer].mode == MODE_AVERAGE;
    var share = 1.0;
    if frame.has_regions == 1u {
        let front = depth_of_first_node(sheet) - 0.5;
        share = share_behind(layer, intervals[layer], front, is_mean);
    }
    if length * share <= 0.0 {
        return found;
    }
    let weight = min(length / (FULL_PART * layers[layer].slab_thickness), 1.0);
    if is_mean {
        let much = found.y + length * share;
        let mean = mix(found.x, sheets[FIRST].y, length * share / much);
        return vec4(mean, much, max(found.z, weight), 0.0);
    }
    let is_largest = densities[layer].mode == MODE_MAXIMUM;
    let up = select(-1.0, 1.0, is_largest);
    let worst = densities[layer].worst;
    let better_by = peak(is_largest) - worst;
    let counting = weight * clamp(better_by * up * densities[layer].per_rise, 0.0, 1.0);
    if counting <= 0.0 {
        return found;
    }
    let value = worst + counting * better_by;
    let better = select(min(found.x, value), max(found.x, value), is_largest);
    return vec4(select(better, value, found.y == 0.0), 1.0, max(found.z, counting), 0.0);
}

// The most that the parabola through the first node and those beside it comes to within half a sheet; or the
// least.
fn peak(is_largest: bool) -> f32 {
    let up = select(-1.0, 1.0, is_largest);
    let here = node(FIRST).x;
    let before = share_of_sheet(FIRST - 1u, FIRST) * (node(FIRST - 1u).x - here);
    let behind = share_of_sheet(FIRST + 1u, FIRST) * (node(FIRST + 1u).x - here);
    let bend = (before + behind) * (0.5 * up);
    let slope = abs(behind - before) * 0.5;
    if bend < 0.0 && slope <= -bend {
        return here - up * slope * slope * 0.25 / bend;
    }
    return here + up * (slope * 0.5 + bend * 0.25);
}

// Opacity and colour of a layer at what was found, as far as it counts.
fn shown_by(layer: u32, found: vec4<f32>) -> vec4<f32> {
    var density = found.x;
    if densities[layer].mode != MODE_AVERAGE && 0.0 < found.z && found.z < 1.0 {
        // Or the rim would have the colour of the worst.
        let worst = densities[layer].worst;
        density = worst + (density - worst) / found.z;
    }
    let cell = cell_at(layer, cell_of(layer, density));
    let t = clamp((density - cell.start) / cell.width, 0.0, 1.0);
    let opacity = weight_in(cell, t);
    return found.z * vec4(opacity * color_in(cell, t), opacity);
}
