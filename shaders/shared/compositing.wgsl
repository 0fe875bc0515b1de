// The three compositing models (model §3): what a sheet sums of a voxel, and how sums become a pixel. All that shaders know
// of them is here; crates/slabsplat-core/src/compositing.rs says what they mean.

const COMPOSITING_SEPARATE: u32 = 0u;
const COMPOSITING_ASSOCIATED: u32 = 1u;
const COMPOSITING_EXTINCTION: u32 = 2u;
// Or else sheets sum values (model §8).
const SUMS_DENSITIES: u32 = 3u;

// What is summed of an opacity, given both opacity and 1 − opacity.
fn summed_weight(compositing: u32, opacity: vec2<f32>) -> f32 {
    switch compositing {
        case COMPOSITING_SEPARATE, COMPOSITING_ASSOCIATED: {
            return opacity.x;
        }
        case COMPOSITING_EXTINCTION, default: {
            return extinction_of(opacity.x, opacity.y);
        }
    }
}

// What is summed of a colour, and its weight.
fn summed_color(compositing: u32, color: vec3<f32>, weight: f32) -> vec4<f32> {
    switch compositing {
        case COMPOSITING_SEPARATE: {
            return vec4(color, weight);
        }
        case COMPOSITING_ASSOCIATED, COMPOSITING_EXTINCTION, default: {
            return vec4(color * weight, weight);
        }
    }
}

// Whether colours are summed times their weight.
fn weights_colors(compositing: u32) -> bool {
    switch compositing {
        case COMPOSITING_SEPARATE: {
            return false;
        }
        case COMPOSITING_ASSOCIATED, COMPOSITING_EXTINCTION, default: {
            return true;
        }
    }
}

// Whether extinction is summed, which a region may cut anywhere: the two other models cannot split a sheet.
fn sums_extinction(compositing: u32) -> bool {
    switch compositing {
        case COMPOSITING_SEPARATE, COMPOSITING_ASSOCIATED: {
            return false;
        }
        case COMPOSITING_EXTINCTION, default: {
            return true;
        }
    }
}

// A sheet's sums as premultiplied colour and opacity. An opacity below 0, which only the normalisation `paper` can sum to,
// counts as 0.
fn resolve(compositing: u32, sums: vec4<f32>) -> vec4<f32> {
    switch compositing {
        case COMPOSITING_SEPARATE: {
            let opacity = clamp(sums.a, 0.0, 1.0);
            return vec4(opacity * clamp(sums.rgb, vec3(0.0), vec3(1.0)), opacity);
        }
        case COMPOSITING_ASSOCIATED: {
            if sums.a <= 0.0 {
                return vec4(0.0);
            }
            return vec4(sums.rgb / max(sums.a, 1.0), min(sums.a, 1.0));
        }
        case COMPOSITING_EXTINCTION, default: {
            if sums.a <= 0.0 {
                return vec4(0.0);
            }
            return sums * mean_transparency(sums.a);
        }
    }
}

// Logarithm and exponential near 0 and 1, where the built-in ones may be off by 2^-21.

// Opacity from which extinction is cut off, as what is left of 1.
const MIN_TRANSPARENCY: f32 = 1e-6;

// −ln(1 − opacity), given both opacity and 1 − opacity.
fn extinction_of(opacity: f32, transparency: f32) -> f32 {
    if 0.5 < opacity {
        return -log(max(transparency, MIN_TRANSPARENCY));
    }
    // 2·artanh(z), which has a short series.
    let z = opacity / (2.0 - opacity);
    let s = z * z;
    let tail = 1.0 / 7.0 + s * (1.0 / 9.0 + s * (1.0 / 11.0 + s / 13.0));
    return 2.0 * z * (1.0 + s * (1.0 / 3.0 + s * (1.0 / 5.0 + s * tail)));
}

// (1 − e^−τ)/τ for τ > 0.
fn mean_transparency(tau: f32) -> f32 {
    if 0.5 < tau {
        return (1.0 - exp(-tau)) / tau;
    }
    let tail = 1.0 - tau / 5.0 * (1.0 - tau / 6.0 * (1.0 - tau / 7.0 * (1.0 - tau / 8.0)));
    return 1.0 - tau / 2.0 * (1.0 - tau / 3.0 * (1.0 - tau / 4.0 * tail));
}
