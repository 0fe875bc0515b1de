// The volume's samples in their own type, packed into words, x fastest.
//
// A sample is read as its bits. From these comes a *key*, which sorts as the numbers do: all that is decided
// by comparing samples is decided exactly, for every type. Only the *difference* of two samples becomes a
// float, and it is exact but for one rounding: a shader has no 64-bit floats, a compiler may reorder sums of
// 32-bit ones, and a device may take subnormal ones for 0.
//
// Whoever includes this declares `samples` and `volume`.

struct VolumeParams {
    // How index-space differences become a world-space gradient, up to a factor: the rows of A^-T.
    gradient_x: vec4<f32>,
    gradient_y: vec4<f32>,
    gradient_z: vec4<f32>,
    // Voxels along x, y, z.
    dims: vec3<u32>,
    sample_type: u32,
    // Iso-ranges, segments of opacity and segments of colour in `transfer`, in this order.
    n_ranges: u32,
    n_opacities: u32,
    n_colors: u32,
    // What a sheet sums, see COMPOSITING_* and SUMS_DENSITIES.
    compositing: u32,
}

const SAMPLE_U8: u32 = 0u;
const SAMPLE_I8: u32 = 1u;
const SAMPLE_U16: u32 = 2u;
const SAMPLE_I16: u32 = 3u;
const SAMPLE_U32: u32 = 4u;
const SAMPLE_I32: u32 = 5u;
const SAMPLE_F32: u32 = 6u;
const SAMPLE_F64: u32 = 7u;

// The bits of a sample: the high word and, for 64 bits, the low one.
fn sample_bits(sample_idx: u32) -> vec2<u32> {
    let local = sample_idx - step.first_sample;
    switch volume.sample_type {
        case SAMPLE_U8: {
            return vec2(extractBits(samples[local >> 2u], (local & 3u) * 8u, 8u), 0u);
        }
        case SAMPLE_I8: {
            let word = bitcast<i32>(samples[local >> 2u]);
            return vec2(bitcast<u32>(extractBits(word, (local & 3u) * 8u, 8u)), 0u);
        }
        case SAMPLE_U16: {
            return vec2(extractBits(samples[local >> 1u], (local & 1u) * 16u, 16u), 0u);
        }
        case SAMPLE_I16: {
            let word = bitcast<i32>(samples[local >> 1u]);
            return vec2(bitcast<u32>(extractBits(word, (local & 1u) * 16u, 16u)), 0u);
        }
        case SAMPLE_F64: {
            return vec2(samples[2u * local + 1u], samples[2u * local]);
        }
        default: {
            return vec2(samples[local], 0u);
        }
    }
}

fn is_float() -> bool {
    return SAMPLE_F32 <= volume.sample_type;
}

fn is_signed_integer() -> bool {
    return volume.sample_type == SAMPLE_I8 || volume.sample_type == SAMPLE_I16
        || volume.sample_type == SAMPLE_I32;
}

// Sorts as the numbers do; that of a NaN lies outside of all ranges.
fn key_of(bits: vec2<u32>) -> vec2<u32> {
    if is_float() {
        let is_negative = (bits.x >> 31u) == 1u;
        return select(vec2(bits.x | 0x80000000u, bits.y), ~bits, is_negative);
    }
    return vec2(select(bits.x, bits.x ^ 0x80000000u, is_signed_integer()), 0u);
}

// The exponent bits of a float, all of them set for infinities and NaN.
fn has_largest_exponent(bits: vec2<u32>) -> bool {
    let mask = select(0x7f800000u, 0x7ff00000u, volume.sample_type == SAMPLE_F64);
    return is_float() && (bits.x & mask) == mask;
}

fn is_nan(bits: vec2<u32>) -> bool {
    let mantissa = select(0x007fffffu, 0x000fffffu, volume.sample_type == SAMPLE_F64);
    let low = select(0u, bits.y, volume.sample_type == SAMPLE_F64);
    return has_largest_exponent(bits) && ((bits.x & mantissa) | low) != 0u;
}

// The bits of the sample that has a key.
fn bits_of_key(key: vec2<u32>) -> vec2<u32> {
    if is_float() {
        let is_negative = (key.x >> 31u) == 0u;
        return select(vec2(key.x & 0x7fffffffu, key.y), ~key, is_negative);
    }
    return vec2(select(key.x, key.x ^ 0x80000000u, is_signed_integer()), 0u);
}

// The number `fraction · 2^exponent`; a fraction is 0, or its size is within 1 to 2, except that integers
// keep theirs and have an exponent of 0.
struct Scaled {
    fraction: f32,
    exponent: i32,
}

// How far `after` lies above `before`; neither is NaN, and of infinite ones the result means nothing, but is
// finite.
fn difference(before: vec2<u32>, after: vec2<u32>) -> Scaled {
    if is_float() {
        return difference_of_floats(before, after);
    }
    // Keys of integers are as far apart as these.
    let low = key_of(before).x;
    let high = key_of(after).x;
    return Scaled(select(-f32(low - high), f32(high - low), low <= high), 0);
}

// A number without its exponent, unless that is so different that nothing is left.
fn scaled_by(number: Scaled, exponent: i32) -> f32 {
    let power = clamp(number.exponent - exponent, -126, 126);
    return number.fraction * bitcast<f32>(u32(power + 127) << 23u);
}

// Below the exponent of every number that is not 0.
const EXPONENT_OF_ZERO: i32 = -10000;

// Both mantissas are brought to one exponent in integers of 64 bits, of which 9 are left over below a
// mantissa of 53 bits: what is shifted out is lost only where the difference is larger by far.
fn difference_of_floats(before: vec2<u32>, after: vec2<u32>) -> Scaled {
    let exponents = vec2(exponent_of(before), exponent_of(after));
    let exponent = max(exponents.x, exponents.y);
    let down = vec2<u32>(vec2(exponent) - exponents);
    let minuend = with_sign(shifted_down(mantissa_of(after), down.y), is_negative(after));
    let subtrahend = with_sign(shifted_down(mantissa_of(before), down.x), !is_negative(before));
    let sum = add_words(minuend, subtrahend);
    let size = with_sign(sum, is_negative(sum));
    if all(size == vec2(0u)) {
        return Scaled(0.0, EXPONENT_OF_ZERO);
    }
    let zeros = select(32u + countLeadingZeros(size.y), countLeadingZeros(size.x), size.x != 0u);
    let fraction = f32(shifted_up(size, zeros).x) * 4.656612873077393e-10;
    return Scaled(select(fraction, -fraction, is_negative(sum)), exponent + 2 - i32(zeros));
}

fn is_negative(words: vec2<u32>) -> bool {
    return (words.x >> 31u) == 1u;
}

// Of floats: a number is ±mantissa · 2^(exponent − 61).
fn exponent_of(bits: vec2<u32>) -> i32 {
    if volume.sample_type == SAMPLE_F64 {
        return max(i32((bits.x >> 20u) & 0x7ffu), 1) - 1023;
    }
    return max(i32((bits.x >> 23u) & 0xffu), 1) - 127;
}

fn mantissa_of(bits: vec2<u32>) -> vec2<u32> {
    if volume.sample_type == SAMPLE_F64 {
        let leading = select(0u, 0x100000u, (bits.x & 0x7ff00000u) != 0u);
        return vec2(((leading | (bits.x & 0xfffffu)) << 9u) | (bits.y >> 23u), bits.y << 9u);
    }
    let leading = select(0u, 0x800000u, (bits.x & 0x7f800000u) != 0u);
    return vec2((leading | (bits.x & 0x7fffffu)) << 6u, 0u);
}

// Integers of 64 bits, the high word first.

fn add_words(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.y + b.y;
    return vec2(a.x + b.x + select(0u, 1u, low < a.y), low);
}

fn with_sign(words: vec2<u32>, is_turned: bool) -> vec2<u32> {
    return select(words, vec2(~words.x + select(0u, 1u, words.y == 0u), ~words.y + 1u), is_turned);
}

fn shifted_down(words: vec2<u32>, n_bits: u32) -> vec2<u32> {
    if n_bits == 0u {
        return words;
    }
    if n_bits < 32u {
        return vec2(words.x >> n_bits, (words.x << (32u - n_bits)) | (words.y >> n_bits));
    }
    return vec2(0u, select(0u, words.x >> (n_bits & 31u), n_bits < 64u));
}

fn shifted_up(words: vec2<u32>, n_bits: u32) -> vec2<u32> {
    if n_bits == 0u {
        return words;
    }
    if n_bits < 32u {
        return vec2((words.x << n_bits) | (words.y >> (32u - n_bits)), words.y << n_bits);
    }
    return vec2(words.y << (n_bits & 31u), 0u);
}
