// Blinn–Phong on cells, whose voxels face many ways (model §16): the twin of the CPU's `cell_light.rs`, which
// says where the formulas are from.

//#include "shared/cell_record.wgsl"

// The least of what is divided by: where there is no direction at all, all that depends on one is 0 times
// something finite.
const LEAST: f32 = 1e-12;

// What there is of directions among a cell's voxels.
struct Facing {
    // The share that has one, and one over it.
    directed: f32,
    per_directed: f32,
    // How much they are alike, 0 … 1.
    alike: f32,
}

fn facing_of(cell: CellValues) -> Facing {
    let length = length(cell.normal);
    // Rounding may have made a normal longer than what has one.
    let directed = max(1.0 - cell.undirected, length);
    let per_directed = 1.0 / max(directed, LEAST);
    return Facing(min(directed, 1.0), per_directed, length * per_directed);
}

// The light on a cell of a layer.
fn light_on_cell(layer: u32, cell: CellValues) -> Light {
    let facing = facing_of(cell);
    var light = Light(vec3(layers[layer].ambient), vec3(0.0));
    let undirected = layers[layer].zero_gradient * cell.undirected;
    for (var i = 0u; i < frame.n_lights; i++) {
        let color = frame.lights[i].color.rgb;
        let sides = sides_towards(layer, cell, facing, frame.lights[i].to_light.xyz);
        light.diffuse += layers[layer].diffuse * (facing.directed * sides.x + undirected) * color;
        let highlight = highlight_of(layer, cell, facing, frame.lights[i].halfway.xyz);
        light.specular += layers[layer].specular * facing.directed * sides.y * highlight * color;
    }
    return light;
}

// The mean of max(n·l, 0), or of |n·l| where light is two-sided, and the share that faces it.
fn sides_towards(layer: u32, cell: CellValues, facing: Facing, to_light: vec3<f32>) -> vec2<f32> {
    let mean = clamp(dot(cell.normal, to_light) * facing.per_directed, -1.0, 1.0);
    var variance: f32;
    if cell.has_moments {
        variance = max(square_along(cell, to_light) * facing.per_directed - mean * mean, 0.0);
    } else {
        let alike = facing.alike * facing.alike;
        variance = (1.0 - alike) / (3.0 - alike) * (1.0 - mean * mean);
    }
    let beyond = 0.75 * variance * variance / max(variance + 0.5 * mean * mean, LEAST);
    let both = sqrt(max(mean * mean + beyond, LEAST));
    let one = 0.5 * (both + mean);
    return select(vec2(one, one / both), vec2(both, 1.0), layers[layer].is_two_sided == 1u);
}

// The mean of highlights of what faces the light, broader as its normals differ.
fn highlight_of(layer: u32, cell: CellValues, facing: Facing, halfway: vec3<f32>) -> f32 {
    let shininess = layers[layer].shininess;
    let alike = facing.alike;
    let mean = dot(cell.normal, halfway) * facing.per_directed;
    let product = clamp(mean / max(alike, LEAST), -1.0, 1.0);
    let cosine = select(product, abs(product), layers[layer].is_two_sided == 1u);
    let exponent = alike / max(alike + shininess * (1.0 - alike), LEAST) * shininess;
    let of_one = power(max(cosine, 0.0), exponent);
    let of_many = exp(exponent * (cosine - 1.0));
    let mixed = alike * alike * of_one + (1.0 - alike * alike) * of_many;
    return (1.0 + exponent) / (1.0 + shininess) * mixed;
}
