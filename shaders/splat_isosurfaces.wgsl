// Surfaces on which densities have given values (model §12).
//
//   for each value that lies between the densities at the two nodes in the middle, in the ray's order:
//       the place at which a cubic has it
//       fade out where the volume ends; look whether the region holds the place
//       slopes there, normal, light
//       put it behind what the pixel has shown so far
//
// A surface takes two elements of `table`: its value and its opacity, then its colour. Values rise.

//#include "shared/density_tile.wgsl"
//#include "shared/light.wgsl"
//#include "shared/part_slopes.wgsl"

@compute @workgroup_size(10, 10)
fn splat_isosurfaces(
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    render_tile(local.xy, thread, linear_group(group, n_groups));
}

const ELEMENTS_OF_SURFACE: u32 = 2u;

fn showing(color: vec4<f32>, sheet: u32, pixel: Pixel) -> vec4<f32> {
    let lengths = vec2(sheets[FIRST].x, sheets[SECOND].x);
    if min(lengths.x, lengths.y) <= 0.0 {
        return color;
    }
    let start = node(FIRST);
    let end = node(SECOND);
    let is_rising = start.x < end.x;
    var laid = color;
    for (var nth = 0u; nth < densities.n_shown; nth++) {
        let number = select(densities.n_shown - 1u - nth, nth, is_rising);
        let surface = densities.first_shown + number * ELEMENTS_OF_SURFACE;
        let value = table[surface].x;
        if (start.x < value) == (end.x < value) {
            continue;
        }
        let along = vec2(slope_along(FIRST), slope_along(SECOND));
        let t = place_of(value, vec2(start.x, end.x), along);
        if frame.has_regions == 1u && !is_held(depth_of_first_node(sheet) + t, pixel) {
            continue;
        }
        let opacity = table[surface].y * counts_at(mix(lengths.x, lengths.y, t));
        var lit = table[surface + 1u].rgb;
        if layers[0].is_lit == 1u {
            let slopes = slopes_between(vec3(start.yz, along.x), vec3(end.yz, along.y));
            let light = light_on(0u, normal_at(slopes, t, pixel));
            lit = min(lit * light.diffuse + light.specular, vec3(1.0));
        }
        laid += (1.0 - laid.a) * opacity * vec4(lit, 1.0);
    }
    return laid;
}

fn shown(color: vec4<f32>) -> vec4<f32> {
    return color;
}

// Whether the region holds a depth of the pixel's ray.
fn is_held(depth: f32, pixel: Pixel) -> bool {
    let is_in_convex = pixel.interval.x <= depth && depth < pixel.interval.y;
    return is_in_convex != (layers[0].is_inverted == 1u);
}

// By how much a surface counts where sheets hold so much: volumes end, and surfaces with them.
fn counts_at(length: f32) -> f32 {
    return clamp(4.0 * length / layers[0].slab_thickness - 1.5, 0.0, 1.0);
}

// Steps of Newton's method that converge, or of halving, which would need as many.
const MOST_STEPS: u32 = 24u;

// How exact places are.
const EXACT: f32 = 1e-6;

// The place, from 0 to 1, at which the density passes a value between those of its ends, on a way without
// turns (Fritsch & Carlson, SIAM J. Numer. Anal. 17(2), 1980).
fn place_of(value: f32, ends: vec2<f32>, slopes: vec2<f32>) -> f32 {
    let change = ends.y - ends.x;
    let bends = clamp(slopes / change, vec2(0.0), vec2(3.0)) - 1.0;
    let part = clamp((value - ends.x) / change, 0.0, 1.0);
    var least = 0.0;
    var most = 1.0;
    var t = part;
    for (var i = 0u; i < MOST_STEPS; i++) {
        let left = 1.0 - t;
        let risen = t + t * left * (left * bends.x - t * bends.y);
        if risen < part {
            least = t;
        } else {
            most = t;
        }
        let slope = 1.0 + bends.x * left * (1.0 - 3.0 * t) - bends.y * t * (2.0 - 3.0 * t);
        let newton = t + (part - risen) / slope;
        let is_between = least < newton && newton < most;
        let next = select(0.5 * (least + most), newton, is_between);
        let way = abs(next - t);
        t = next;
        if way < EXACT {
            break;
        }
    }
    return t;
}
