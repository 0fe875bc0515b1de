// What a layer's sheets of densities are made of and shown by (model §§8, 12), beside `Frame` and `Layer`.

struct Densities {
    // What is shown of them: MODE_*.
    mode: u32,
    // The first element of `table` that says by what: see `cells.wgsl`, or `isosurfaces.wgsl`.
    first_shown: u32,
    // How many cells, or surfaces, there are.
    n_shown: u32,
    // Whether the kernel is a product; if not, the table is read by cubics: see `density_weight.wgsl`.
    is_product: u32,
    // The least and the largest of what is summed.
    values: vec2<f32>,
    // A slope from which on surfaces are lit in full, per `unit`.
    faint: f32,
    // What the kernel is just within its radius, as a weight per index unit of ray.
    rim: f32,
    // The coefficients of a kernel that is a product: across the ray, and along it.
    across: array<vec4<f32>, 3>,
    along: array<vec4<f32>, 3>,
    // What a sheet counts as that holds next to nothing, in a maximum or a minimum. What is worse does not count.
    worst: f32,
    // One over how much better it must be to count in full.
    per_rise: f32,
    padding: vec2<u32>,
}

const MODE_COMPOSITED: u32 = 0u;
const MODE_MAXIMUM: u32 = 1u;
const MODE_MINIMUM: u32 = 2u;
const MODE_AVERAGE: u32 = 3u;
const MODE_ISOSURFACES: u32 = 4u;
