// Blinn–Phong (model §6): how much light a normal sends to the viewer. Normals and directions are of one
// space.

// What a colour is multiplied with, and what is added to it.
struct Light {
    diffuse: vec3<f32>,
    specular: vec3<f32>,
}

// The light on a normal of a layer, which is not longer than 1: what it lacks of that faces every light by a
// share, and mirrors none.
fn light_on(layer: u32, normal: vec3<f32>) -> Light {
    var light = Light(vec3(layers[layer].ambient), vec3(0.0));
    let undirected = layers[layer].zero_gradient * max(1.0 - length(normal), 0.0);
    for (var i = 0u; i < frame.n_lights; i++) {
        let n_l = facing(layer, normal, frame.lights[i].to_light.xyz);
        light.diffuse += layers[layer].diffuse * (n_l + undirected) * frame.lights[i].color.rgb;
        if 0.0 < n_l {
            let n_h = facing(layer, normal, frame.lights[i].halfway.xyz);
            let highlight = layers[layer].specular * power(n_h, layers[layer].shininess);
            light.specular += highlight * frame.lights[i].color.rgb;
        }
    }
    return light;
}

fn facing(layer: u32, normal: vec3<f32>, direction: vec3<f32>) -> f32 {
    let product = dot(normal, direction);
    return select(max(product, 0.0), abs(product), layers[layer].is_two_sided == 1u);
}

// `pow` is not defined everywhere for 0.
fn power(base: f32, exponent: f32) -> f32 {
    if base <= 0.0 {
        return select(0.0, 1.0, exponent == 0.0);
    }
    return pow(base, exponent);
}
