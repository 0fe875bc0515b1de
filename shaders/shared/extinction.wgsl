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
