// Everything about a frame that all voxels share. Lengths are in `unit`s of the grid, depths count from
// its centre, pixels from the image's upper left corner.

struct Frame {
    // Index space to view space: the rows for right, up and depth; in `w` the centre of the grid there.
    right: vec4<f32>,
    up: vec4<f32>,
    depth: vec4<f32>,
    // The grid's centre in index space.
    center_in_index: vec3<f32>,
    // Pixels per unit; in a perspective view, times the distance from the eye's plane.
    pixels_per_unit: f32,
    // Voxels along x, y, z.
    dims: vec3<u32>,
    is_perspective: u32,
    image_size: vec2<u32>,
    n_tiles: vec2<u32>,
    // The optical axis.
    image_center: vec2<f32>,
    // Depth of the grid's centre from the eye's plane.
    eye_distance: f32,
    // Least depth at which a whole footprint is drawn.
    near: f32,

    // The kernel's radius in index space, and half its thickness along the view.
    radius: f32,
    half_depth: f32,
    // Index-space length of a ray over one unit of depth.
    index_per_depth: f32,
    // Whether slab faces cut the rays of a footprint at different offsets.
    is_tilted: u32,
    // ρ² = across·(X + lean·Y)² + along·Y², y running downwards.
    across: f32,
    lean: f32,
    along: f32,
    opacity_cutoff: f32,
    // By how many index units a face is cut later, per unit to the right and downwards.
    tilt: vec2<f32>,
    // Half the width and height of the ellipse ρ = 1.
    half_extent: vec2<f32>,

    method: u32,
    compositing: u32,
    // Slabs or slices. Slab n lies between (first_slab + n) and (first_slab + n + 1) thicknesses.
    n_sheets: u32,
    // The first slab that is drawn.
    first_drawn: u32,
    slab_thickness: f32,
    first_slab: i32,
    // How many slabs before a slab a kernel that still reaches into it can begin.
    n_slabs_before: u32,
    // The axis across the slices, plus 4 if the last slice is nearest.
    slice_axis: u32,

    // The section table: see `table.wgsl`.
    samples_per_index: f32,
    rows_per_index: f32,
    last_row: f32,
    row_len: u32,
    is_mirrored: u32,
    is_nearest: u32,

    // Blinn–Phong (model §6).
    is_lit: u32,
    is_two_sided: u32,
    to_light: vec3<f32>,
    ambient: f32,
    halfway: vec3<f32>,
    diffuse: f32,
    specular: f32,
    shininess: f32,
    // Splats after which a tile pauses, so that no dispatch takes too long.
    max_visits: u32,
    padding: u32,

    // Straight colour and opacity.
    background: vec4<f32>,
}

const METHOD_SECTIONS: u32 = 0u;
const METHOD_SLICES: u32 = 1u;
const METHOD_VOXELS: u32 = 2u;
