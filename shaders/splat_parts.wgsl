// What lies between sheets of densities is classified, lit and composited (model §8).
//
//   mean opacity and colour of the part between the two nodes in the middle, and where it lies
//   at four places of what is seen of it: slopes, normal, light
//   put it behind the pixel, as any sheet

//#include "shared/density_tile.wgsl"
//#include "shared/light.wgsl"
//#include "shared/cells.wgsl"
//#include "shared/part_means.wgsl"
//#include "shared/part_slopes.wgsl"

@compute @workgroup_size(10, 10)
fn splat_parts(
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    render_tile(local.xy, thread, linear_group(group, n_groups));
}

fn showing(color: vec4<f32>, sheet: u32, pixel: Pixel) -> vec4<f32> {
    let length = 0.5 * (sheets[FIRST].x + sheets[SECOND].x);
    if length <= 0.0 {
        return color;
    }
    let ends = part_ends(vec4(node(FIRST), 0.0), vec4(node(SECOND), 0.0));
    let mean = mean_between(ends.start.x, ends.end.x);
    if mean.weight <= 0.0 {
        return color;
    }
    let weight = length * mean.weight;
    var lit = mean.color;
    if layers[0].is_lit == 1u {
        let light = mean_light(mean.place, weight, sheet, pixel);
        lit = min(lit * light.diffuse + light.specular, vec3(1.0));
    }
    let of_colors = select(length, weight, weights_colors(frame.compositing));
    var sums = vec4(of_colors * lit, weight);
    if frame.has_regions == 1u {
        let is_split = sums_extinction(frame.compositing);
        sums *= share_behind(0u, pixel.interval, depth_of_first_node(sheet), is_split);
    }
    return color + (1.0 - color.a) * resolve(frame.compositing, sums);
}

fn shown(color: vec4<f32>) -> vec4<f32> {
    return color;
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

// The mean of four places of what is seen, weighted with how much light goes through the quarters before them.
fn mean_light(place: f32, weight: f32, sheet: u32, pixel: Pixel) -> Light {
    let first = vec4(node(FIRST), slope_along(FIRST));
    let second = vec4(node(SECOND), slope_along(SECOND));
    let ends = part_ends(first, second);
    let slopes = slopes_between(ends.start.yzw, ends.end.yzw);
    let q = select(1.0, exp(-0.25 * weight), sums_extinction(frame.compositing));
    // It lies evenly around its middle, as far as the part goes on both sides.
    let extent = 2.0 * min(place, 1.0 - place);
    var seen = 1.0 / ((1.0 + q) * (1.0 + q * q));
    var mean = Light(vec3(0.0), vec3(0.0));
    for (var quarter = 0u; quarter < 4u; quarter++) {
        let t = place + extent * (0.25 * f32(quarter) - 0.375);
        let light = light_on(0u, lit_normal(slopes, t, sheet, pixel));
        mean.diffuse += seen * light.diffuse;
        mean.specular += seen * light.specular;
        seen *= q;
    }
    return mean;
}

// The normal at a place of a part, or near a lit face of the region that of the face.
fn lit_normal(slopes: Slopes, t: f32, sheet: u32, pixel: Pixel) -> vec3<f32> {
    let normal = normal_at(slopes, t, pixel);
    if layers[0].has_lit_faces == 0u {
        return normal;
    }
    let depth = depth_of_first_node(sheet) + t;
    let aside = from_axis(pixel) * (frame.ray_start + frame.ray_step * depth);
    let face = face_near(0u, vec3(aside, depth) * layers[0].slab_thickness);
    return plane_of(0u, face.plane).xyz * (outwards(0u) * face.share) + normal * (1.0 - face.share);
}
