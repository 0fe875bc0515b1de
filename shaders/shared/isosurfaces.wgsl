// Surfaces on which densities have given values (model §12), of the layer that the pixel has come to.
//
//   which surface comes next of those whose value lies between the densities at the two nodes in the middle
//   the position at which a cubic has it; whether the region holds that
//   fade out where the volume ends; slopes there, normal, light
//
// A surface takes two elements of `table`: its value and its opacity, then its colour. Values rise.

//#include "shared/light.wgsl"
//#include "shared/part_slopes.wgsl"

const ELEMENTS_OF_SURFACE: u32 = 2u;

// A surface of a layer that the ray passes.
struct Passed {
    // Its number in the order in which the ray would pass all of the layer.
    nth: u32,
    // From 0 at the first node to 1 at the second.
    position: f32,
}

// The position of a surface that there is not.
const BEYOND: f32 = 2.0;

fn is_passed(passed: Passed) -> bool {
    return passed.position < BEYOND;
}

// The next surface that the ray passes within the layer's region, from the `nth` on.
fn passed_from(layer: u32, nth: u32, sheet: u32, pixel: Pixel) -> Passed {
    if min(sheets[FIRST].x, sheets[SECOND].x) <= 0.0 {
        return Passed(nth, BEYOND);
    }
    let ends = vec2(node(FIRST).x, node(SECOND).x);
    for (var number = nth; number < densities[layer].n_shown; number++) {
        let value = number_at(element_of(layer, number)).x;
        if (ends.x < value) == (ends.y < value) {
            continue;
        }
        let position = position_of(value, ends, vec2(slope_along(FIRST), slope_along(SECOND)));
        if frame.has_regions == 0u || is_held(layer, depth_of_first_node(sheet) + position) {
            return Passed(number, position);
        }
    }
    return Passed(nth, BEYOND);
}

// The first element of the `nth` surface on the ray's way.
fn element_of(layer: u32, nth: u32) -> u32 {
    let is_rising = node(FIRST).x < node(SECOND).x;
    let number = select(densities[layer].n_shown - 1u - nth, nth, is_rising);
    return densities[layer].first_shown + number * ELEMENTS_OF_SURFACE;
}

// Puts a surface behind what the pixel has shown so far.
fn put_behind(layer: u32, passed: Passed, pixel: Pixel) {
    let element = element_of(layer, passed.nth);
    let length = mix(sheets[FIRST].x, sheets[SECOND].x, passed.position);
    let opacity = number_at(element).y * counts_at(layer, length);
    var lit = number_at(element + 1u).rgb;
    if layers[layer].is_lit == 1u {
        let start = vec3(node(FIRST).yz, slope_along(FIRST));
        let end = vec3(node(SECOND).yz, slope_along(SECOND));
        let normal = normal_at(layer, slopes_between(start, end), passed.position, pixel);
        let light = light_on(layer, normal);
        lit = min(lit * light.diffuse + light.specular, vec3(1.0));
    }
    held[0] += (1.0 - held[0].a) * opacity * vec4(lit, 1.0);
}

// Whether the region of a layer holds a depth of the pixel's ray.
fn is_held(layer: u32, depth: f32) -> bool {
    let is_in_convex = intervals[layer].x <= depth && depth < intervals[layer].y;
    return is_in_convex != (layers[layer].is_inverted == 1u);
}

// By how much a surface counts where sheets hold so much: volumes end, and surfaces with them.
fn counts_at(layer: u32, length: f32) -> f32 {
    return clamp(4.0 * length / layers[layer].slab_thickness - 1.5, 0.0, 1.0);
}

// Steps of Newton's method that converge, or of halving, which would need as many.
const MOST_STEPS: u32 = 24u;

// How exact positions are.
const EXACT: f32 = 1e-6;

// The position, from 0 to 1, at which the density passes a value between those of its ends, on a way without
// turns (Fritsch & Carlson, SIAM J. Numer. Anal. 17(2), 1980).
fn position_of(value: f32, ends: vec2<f32>, slopes: vec2<f32>) -> f32 {
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
