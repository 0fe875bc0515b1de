// Opacity and colour as functions of the sample, linear between points (SPEC §6).
//
// A point is an element of `transfer`: its position as the bits of two floats, then opacity and 1 −
// opacity; for colours the position is followed by two unused words, and a second element holds red,
// green, blue. Positions are in the samples' numbers, rising; where values fall with samples the host has
// turned the points around.

fn point_position(element: u32) -> vec2<f32> {
    return bitcast<vec2<f32>>(transfer[element].xy);
}

// How far `number` lies behind a point. Two numbers that are close differ without rounding.
fn distance_behind(number: vec2<f32>, position: vec2<f32>) -> f32 {
    return (number.x - position.x) + (number.y - position.y);
}

// Of two points at one position the later one in *values* counts there.
fn is_passed(number: vec2<f32>, position: vec2<f32>) -> bool {
    let behind = distance_behind(number, position);
    return 0.0 < behind || (behind == 0.0 && volume.is_falling == 0u);
}

// The point at or before a number, and how far it is to the next: a place among `n` points that start at
// element `first` and take `stride` elements each.
struct Place {
    before: u32,
    after: u32,
    t: f32,
}

fn place_of(number: vec2<f32>, first: u32, n: u32, stride: u32) -> Place {
    var lo = 0u;
    var hi = n;
    while lo < hi {
        let middle = (lo + hi) / 2u;
        if is_passed(number, point_position(first + middle * stride)) {
            lo = middle + 1u;
        } else {
            hi = middle;
        }
    }
    let before = first + (max(lo, 1u) - 1u) * stride;
    let after = first + min(lo, n - 1u) * stride;
    var t = 0.0;
    if before != after {
        let start = point_position(before);
        t = distance_behind(number, start) / distance_behind(point_position(after), start);
    }
    return Place(before, after, t);
}

// Opacity, and 1 − opacity, which has digits where opacity has none left.
fn opacity_at(number: vec2<f32>) -> vec2<f32> {
    let place = place_of(number, volume.n_ranges, volume.n_opacities, 1u);
    let before = bitcast<vec2<f32>>(transfer[place.before].zw);
    let after = bitcast<vec2<f32>>(transfer[place.after].zw);
    return before + (after - before) * place.t;
}

fn color_at(number: vec2<f32>) -> vec3<f32> {
    let place = place_of(number, volume.n_ranges + volume.n_opacities, volume.n_colors, 2u);
    let before = bitcast<vec3<f32>>(transfer[place.before + 1u].xyz);
    let after = bitcast<vec3<f32>>(transfer[place.after + 1u].xyz);
    return before + (after - before) * place.t;
}
