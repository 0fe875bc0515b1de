// How a sheet's sums become premultiplied colour and opacity (SPEC §3). An opacity below 0, which only the
// normalisation `paper` can sum to, counts as 0.

fn resolve(sums: vec4<f32>) -> vec4<f32> {
    switch frame.compositing {
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
        default: {
            if sums.a <= 0.0 {
                return vec4(0.0);
            }
            return sums * mean_transparency(sums.a);
        }
    }
}
