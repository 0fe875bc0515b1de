// Opacity and colour as functions of the sample (model §6), in segments that follow each other without a gap.
//
// A segment covers a run of keys and begins at the sample of its first one. The host has found the keys and
// what the function is there, in 64 bits: a sample is on the same side of every point as on the host. What a
// shader adds is the difference between the sample and that first one, times a slope.
//
// A segment of opacity takes two elements of `transfer`: first key (high word, low word), exponent of
// differences; then opacity, 1 − opacity, and slope. A segment of colour takes three: the same first one,
// then colour, then slope.

const ELEMENTS_OF_OPACITY: u32 = 2u;
const ELEMENTS_OF_COLOR: u32 = 3u;

// The first element of the last segment that does not begin behind a key: one of `n` segments, `stride`
// elements each, from element `first` on. The first segment begins at the least key of all.
fn segment_of(key: vec2<u32>, first: u32, n: u32, stride: u32) -> u32 {
    var lo = 1u;
    var hi = n;
    while lo < hi {
        let middle = (lo + hi) / 2u;
        if is_not_after(transfer[first + middle * stride].xy, key) {
            lo = middle + 1u;
        } else {
            hi = middle;
        }
    }
    return first + (lo - 1u) * stride;
}

// How far a sample lies behind the first one of a segment, over the power of two that the segment names.
fn distance_into(segment: u32, bits: vec2<u32>) -> f32 {
    let start = transfer[segment];
    return scaled_by(difference(bits_of_key(start.xy), bits), bitcast<i32>(start.z));
}

// Opacity, and 1 − opacity, which has digits where opacity has none left.
fn opacity_at(bits: vec2<u32>) -> vec2<f32> {
    let first = volume.n_ranges;
    let segment = segment_of(key_of(bits), first, volume.n_opacities, ELEMENTS_OF_OPACITY);
    let at_start = bitcast<vec3<f32>>(transfer[segment + 1u].xyz);
    let change = at_start.z * distance_into(segment, bits);
    return clamp(at_start.xy + vec2(change, -change), vec2(0.0), vec2(1.0));
}

// The value that a sheet of densities sums, which the segments of opacity say then (model §8).
fn density_at(bits: vec2<u32>) -> f32 {
    let first = volume.n_ranges;
    let segment = segment_of(key_of(bits), first, volume.n_opacities, ELEMENTS_OF_OPACITY);
    let at_start = bitcast<vec3<f32>>(transfer[segment + 1u].xyz);
    return at_start.x + at_start.z * distance_into(segment, bits);
}

fn color_at(bits: vec2<u32>) -> vec3<f32> {
    let first = volume.n_ranges + ELEMENTS_OF_OPACITY * volume.n_opacities;
    let segment = segment_of(key_of(bits), first, volume.n_colors, ELEMENTS_OF_COLOR);
    let at_start = bitcast<vec3<f32>>(transfer[segment + 1u].xyz);
    let slope = bitcast<vec3<f32>>(transfer[segment + 2u].xyz);
    return clamp(at_start + slope * distance_into(segment, bits), vec3(0.0), vec3(1.0));
}
