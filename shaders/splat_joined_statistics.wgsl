// One density of each of several layers, for all on its ray (model §12), and what they show together: layers
// are mixed as in one sheet of `extinction`.

//#include "shared/densities_among_others.wgsl"
//#include "shared/density_tile.wgsl"
//#include "shared/statistic.wgsl"

// No layer hides another, so that each has found something of its own.
const MOST_HELD: u32 = MOST_LAYERS;

@compute @workgroup_size(10, 10)
fn splat_joined_statistics(
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
) {
    render_tile(local.xy, thread, linear_group(group, n_groups));
}

fn n_held() -> u32 {
    return n_layers();
}

fn showing(sheet: u32, next: u32, pixel: Pixel) {
    for (var layer = 0u; layer < n_layers(); layer++) {
        if come_to(layer) {
            held[layer] = found_with_sheet(held[layer], layer, sheet, pixel);
        }
    }
}

fn shown() -> vec4<f32> {
    // Colours, weighted with extinctions, and the sum of these.
    var sums = vec4(0.0);
    var through = 1.0;
    for (var layer = 0u; layer < n_layers(); layer++) {
        let of_layer = shown_by(layer, held[layer]);
        if 0.0 < of_layer.a {
            let extinction = extinction_of(of_layer.a, 1.0 - of_layer.a);
            sums += extinction * vec4(of_layer.rgb / of_layer.a, 1.0);
            through *= 1.0 - of_layer.a;
        }
    }
    if sums.a <= 0.0 {
        return vec4(0.0);
    }
    return (1.0 - through) * vec4(sums.rgb / sums.a, 1.0);
}
