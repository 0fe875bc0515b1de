// Everything about a layer that all its voxels share. Lengths are in `unit`s of its grid, depths count from the
// centre of all layers.
//
// Layers are a uniform, as storage buffers are all taken: hence there are at most so many.

const MAX_LAYERS: u32 = 64u;

struct Layer {
    // Index space to view space: the rows for right, up and depth; in `w` the centre of the grid there.
    right: vec4<f32>,
    up: vec4<f32>,
    depth: vec4<f32>,
    // The grid's centre in index space.
    center_in_index: vec3<f32>,
    // Pixels per unit; in a perspective view, times the distance from the eye's plane.
    pixels_per_unit: f32,
    // Voxels, or cells of them, along x, y, z.
    dims: vec3<u32>,
    // The number of its first voxel among those of all layers.
    first_voxel: u32,

    // Blinn–Phong (model §6); the lights are the frame's.
    ambient: f32,
    diffuse: f32,
    specular: f32,
    shininess: f32,
    is_lit: u32,
    is_two_sided: u32,

    // Depth of the centre of all layers from the eye's plane.
    eye_distance: f32,
    // Least depth at which a whole footprint is drawn.
    near: f32,
    // Half the kernel's thickness along the view.
    half_depth: f32,
    // Index-space length of a ray over one unit of depth.
    index_per_depth: f32,
    // By how many index units a face is cut later, per unit to the right and downwards.
    tilt: vec2<f32>,
    // Half the width and height of the ellipse ρ = 1.
    half_extent: vec2<f32>,
    // ρ² = across·(X + shear·Y)² + along·Y², y running downwards.
    across: f32,
    shear: f32,
    along: f32,

    slab_thickness: f32,
    // The first slab that is drawn.
    first_drawn: u32,
    // The axis across the slices, plus 4 if the last slice is nearest.
    slice_axis: u32,
    // Whether slab faces cut the rays of a footprint at different offsets.
    is_tilted: u32,

    // The section table: see `table.wgsl`.
    first_element: u32,
    rows_per_index: f32,
    last_row: f32,
    is_mirrored: u32,

    // The region: see `region.wgsl`. The first layer that has the same one, which is its name.
    region: u32,
    first_plane: u32,
    n_planes: u32,
    // Whether it is the complement of what lies behind all planes.
    is_inverted: u32,
    // Whether its faces are lit as surfaces.
    has_lit_faces: u32,

    // Blinn–Phong, too: the share of diffuse light on what has no gradient.
    zero_gradient: f32,
    // The square of the least by which footprints are widened: 1 of voxels; see `pixels.wgsl`.
    least_stretch_squared: f32,
    // Of cells, how much further out than their indices say the first and the last along each axis lie; and what
    // a cell adds to the variance of its voxels' footprints, over that of its own kernel: 0 of voxels.
    first_out: vec3<f32>,
    spread: f32,
    last_out: vec3<f32>,
    // Planes behind those of the region: of the part of the frame that is drawn, the same of all layers.
    n_part_planes: u32,

    // Where its splits are in `table`: see `spans.wgsl`.
    first_split: u32,
    // The table of sections with all that lies before or behind a face.
    first_merged_element: u32,
    merged_rows_per_index: f32,
    last_merged_row: f32,
}
