// Everything about a frame that all layers share. Pixels count from the image's upper left corner.

const MAX_LIGHTS: u32 = 16u;

// A light and a viewer, both infinitely far away (model §6): directions towards the light and half way between
// both, and the light's colour.
struct LightInView {
    to_light: vec4<f32>,
    halfway: vec4<f32>,
    color: vec4<f32>,
}

struct Frame {
    image_size: vec2<u32>,
    n_tiles: vec2<u32>,
    // The optical axis.
    image_center: vec2<f32>,
    is_perspective: u32,
    method: u32,

    compositing: u32,
    // Slabs or slices. Slab n lies between (first_slab + n) and (first_slab + n + 1) thicknesses.
    n_sheets: u32,
    first_slab: i32,
    // How many slabs before a slab a kernel that still reaches into it can begin.
    n_slabs_before: u32,

    n_layers: u32,
    // Whether any layer has a region.
    has_regions: u32,
    // Whether slab faces cut the rays of any footprint at different offsets.
    is_tilted: u32,
    // The kernel's radius in index space.
    radius: f32,

    // What section tables have in common: see `table.wgsl`.
    samples_per_index: f32,
    row_len: u32,
    is_nearest: u32,
    opacity_cutoff: f32,

    // Where a pixel's ray is at depth 0, and how far it moves over one unit of depth, for each pixel that it is
    // from the optical axis. All in thicknesses of a slab.
    ray_start: f32,
    ray_step: f32,
    // Splats after which a tile pauses, so that no dispatch takes too long.
    max_visits: u32,
    n_lights: u32,

    // Straight colour and opacity.
    background: vec4<f32>,
    lights: array<LightInView, MAX_LIGHTS>,
}

const METHOD_SECTIONS: u32 = 0u;
const METHOD_SLICES: u32 = 1u;
const METHOD_VOXELS: u32 = 2u;
// Sections of densities; the lights are those of view space then.
const METHOD_DENSITIES: u32 = 3u;
