// The volume's samples in their own type, packed into words, x fastest.
//
// A sample is read as its bits. From these come a *key*, which sorts as the numbers do, so that
// membership in an iso-range is exact for every type; and a *number*, the sum of two floats, which has
// 48 bits of precision.
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
    // Floating-point samples are multiplied by this, which brings those that matter near 1.
    number_scale: f32,
    // Iso-ranges, opacity points and colour points in `transfer`, in this order.
    n_ranges: u32,
    n_opacities: u32,
    n_colors: u32,
    // Whether values fall where samples rise.
    is_falling: u32,
    // What a sheet sums, see COMPOSITING_*.
    compositing: u32,
    // Exponent that is taken from 64-bit samples.
    exponent: i32,
    padding: u32,
}

const SAMPLE_U8: u32 = 0u;
const SAMPLE_I8: u32 = 1u;
const SAMPLE_U16: u32 = 2u;
const SAMPLE_I16: u32 = 3u;
const SAMPLE_U32: u32 = 4u;
const SAMPLE_I32: u32 = 5u;
const SAMPLE_F32: u32 = 6u;
const SAMPLE_F64: u32 = 7u;

// Further from 0 than any finite number, after scaling.
const BEYOND_ALL: f32 = 3e38;

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

// The sample as the sum of two floats, scaled; an infinite one lies beyond all finite ones.
fn number_of(bits: vec2<u32>) -> vec2<f32> {
    if has_largest_exponent(bits) {
        return vec2(select(BEYOND_ALL, -BEYOND_ALL, (bits.x >> 31u) == 1u), 0.0);
    }
    switch volume.sample_type {
        case SAMPLE_U32: {
            return vec2(f32(bits.x & 0xffffff00u), f32(bits.x & 0xffu));
        }
        case SAMPLE_F32: {
            let number = bitcast<f32>(bits.x) * volume.number_scale;
            return vec2(clamp(number, -BEYOND_ALL, BEYOND_ALL), 0.0);
        }
        case SAMPLE_F64: {
            return number_of_f64(bits);
        }
        case SAMPLE_U8, SAMPLE_U16: {
            return vec2(f32(bits.x), 0.0);
        }
        default: {
            let number = bitcast<i32>(bits.x);
            return vec2(f32(number & ~0xff), f32(number & 0xff));
        }
    }
}

// 52 bits of mantissa, of which the first float takes 23 and the second 29.
fn number_of_f64(bits: vec2<u32>) -> vec2<f32> {
    let field = i32((bits.x >> 20u) & 0x7ffu);
    if field == 0 {
        return number_of_denormal(bits);
    }
    let exponent = field - 1023 - volume.exponent;
    if exponent < -120 {
        return vec2(0.0);
    }
    let sign = bits.x & 0x80000000u;
    if 126 < exponent {
        return vec2(select(BEYOND_ALL, -BEYOND_ALL, sign != 0u), 0.0);
    }
    let mantissa = ((bits.x & 0xfffffu) << 3u) | (bits.y >> 29u);
    let power = u32(exponent + 127) << 23u;
    let high = bitcast<f32>(sign | power | mantissa);
    let unit = bitcast<f32>(sign | power);
    let low = f32(bits.y & 0x1fffffffu) * unit * 2.220446e-16;
    return vec2(high, low);
}

// Below 2^-1022, which is not 0 beside numbers of that size only.
fn number_of_denormal(bits: vec2<u32>) -> vec2<f32> {
    if -1022 < volume.exponent {
        return vec2(0.0);
    }
    let sign = select(1.0, -1.0, (bits.x >> 31u) == 1u);
    let high = f32(bits.x & 0xfffffu) * 9.536743e-7;
    return sign * vec2(high, f32(bits.y) * 2.220446e-16);
}
