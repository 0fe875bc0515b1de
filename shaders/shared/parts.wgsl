// The part of a ray between the two nodes in the middle (model §8), of the layer that the pixel has come to.
//
//   mean opacity and colour, and where they lie
//   at four positions of what is seen of it: slopes, normal, light
//   cut it by the layer's region

//#include "shared/light.wgsl"
//#include "shared/cells.wgsl"
//#include "shared/part_means.wgsl"
//#include "shared/part_slopes.wgsl"

// What a part sums to, as a sheet does.
fn sums_of_part(layer: u32, sheet: u32, pixel: Pixel) -> vec4<f32> {
    let length = 0.5 * (sheets[FIRST].x + sheets[SECOND].x);
    if length <= 0.0 {
        return vec4(0.0);
    }
    let ends = part_ends(vec4(node(FIRST), 0.0), vec4(node(SECOND), 0.0));
    let mean = mean_between(layer, ends.start.x, ends.end.x);
    if mean.weight <= 0.0 {
        return vec4(0.0);
    }
    let weight = length * mean.weight;
    var lit = mean.color;
    if layers[layer].is_lit == 1u {
        let light = mean_light(layer, mean.position, weight, sheet, pixel);
        lit = min(lit * light.diffuse + light.specular, vec3(1.0));
    }
    let of_colors = select(length, weight, weights_colors(frame.compositing));
    var sums = vec4(of_colors * lit, weight);
    if frame.has_regions == 1u {
        let is_split = sums_extinction(frame.compositing);
        sums *= share_behind(layer, intervals[layer], depth_of_first_node(sheet), is_split);
    }
    return sums;
}

// What a part begins and ends with, of the density and its slopes.
struct Ends {
    start: vec4<f32>,
    end: vec4<f32>,
}

// From the node of the sheet that holds more, as far towards the other one as that one holds of it.
fn part_ends(first: vec4<f32>, second: vec4<f32>) -> Ends {
    let change = second - first;
    return Ends(
        second - share_of_sheet(FIRST, SECOND) * change,
        first + share_of_sheet(SECOND, FIRST) * change,
    );
}

// The mean of four positions of what is seen, weighted with how much light goes through the quarters before
// them.
fn mean_light(layer: u32, position: f32, weight: f32, sheet: u32, pixel: Pixel) -> Light {
    let first = vec4(node(FIRST), slope_along(FIRST));
    let second = vec4(node(SECOND), slope_along(SECOND));
    let ends = part_ends(first, second);
    let slopes = slopes_between(ends.start.yzw, ends.end.yzw);
    let q = select(1.0, exp(-0.25 * weight), sums_extinction(frame.compositing));
    // It lies evenly around its middle, as far as the part reaches on both sides.
    let extent = 2.0 * min(position, 1.0 - position);
    var seen = 1.0 / ((1.0 + q) * (1.0 + q * q));
    var mean = Light(vec3(0.0), vec3(0.0));
    for (var quarter = 0u; quarter < 4u; quarter++) {
        let t = position + extent * (0.25 * f32(quarter) - 0.375);
        let light = light_on(layer, lit_normal(layer, slopes, t, sheet, pixel));
        mean.diffuse += seen * light.diffuse;
        mean.specular += seen * light.specular;
        seen *= q;
    }
    return mean;
}

// The normal at a position of a part, or near a lit face of the region that of the face.
fn lit_normal(layer: u32, slopes: Slopes, t: f32, sheet: u32, pixel: Pixel) -> vec3<f32> {
    let normal = normal_at(layer, slopes, t, pixel);
    if layers[layer].has_lit_faces == 0u {
        return normal;
    }
    let depth = depth_of_first_node(sheet) + t;
    let aside = from_axis(pixel) * (frame.ray_start + frame.ray_step * depth);
    let face = face_near(layer, vec3(aside, depth) * layers[layer].slab_thickness);
    let of_face = plane_of(layer, face.plane).xyz * outwards(layer);
    return of_face * face.share + normal * (1.0 - face.share);
}
