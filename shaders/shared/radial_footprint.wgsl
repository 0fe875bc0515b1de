// Splats as all pixels of a tile need them that find their weights by a polynomial in x = 2·(ρ/R)² − 1, −1
// in the middle of the kernel and 1 at its rim: the twin of the CPU's `footprints/weights.rs`. There is no
// load that depends on the pixel.
//
// Pixels are counted from the corner of the tile, so that products of their places are small and keep their
// digits.
//
// `table` has rows of coefficients, see `crates/slabsplat-gpu/src/section_table.rs`. A row that lies
// between two is blended when the splat is staged, once for all pixels.
//
// Whoever includes this declares `N_QUADS`, how many elements of coefficients a splat has: two for powers
// up to the seventh, or three for powers up to the tenth and the chord.

//#include "shared/batch.wgsl"

const N_COEFFICIENT_QUADS: u32 = N_QUADS * BATCH;

struct RadialFootprint {
    color: vec4<f32>,
    // √(1 + x) along the minor axis: across.x·X + across.y·Y + across.z; and `x` at which the splat ends.
    across: vec4<f32>,
    // The same across that: along.x·Y + along.y.
    along: vec2<f32>,
    layer: u32,
    // Compilers load four numbers at once only from multiples of 16 bytes.
    padding: u32,
}

var<workgroup> staged: array<RadialFootprint, BATCH>;
var<workgroup> coefficients: array<vec4<f32>, N_COEFFICIENT_QUADS>;
// Where the slab's faces are behind the voxel, in units of chords: in these the ray at `x` leaves the
// kernel √(1 − x) behind its nearest point.
var<workgroup> chord_faces: array<vec2<f32>, BATCH>;

// Stages where a splat lies that is projected at a depth, and what it looks like.
fn stage_place(splat: Splat, layer: u32, depth: f32, slot: u32) {
    let scale = scale_at(layer, depth);
    let stretch = stretch_of(layer, scale);
    let per_pixel = sqrt(2.0) / (frame.radius * scale * stretch);
    let across = sqrt(layers[layer].across) * per_pixel;
    let along = sqrt(layers[layer].along) * per_pixel;
    let center = pixel_of(splat.center, scale) - corner;
    let shear = layers[layer].shear;
    staged[slot].across.x = across;
    staged[slot].across.y = across * shear;
    staged[slot].across.z = -across * (center.x + shear * center.y);
    staged[slot].along = along * vec2(1.0, -center.y);
    staged[slot].color = splat.color / (stretch * stretch);
    staged[slot].layer = layer;
}

// Stages the coefficients of a row, and where its splat ends.
fn stage_coefficients(row: Row, faces: vec2<f32>, slot: u32) {
    for (var i = 0u; i < N_QUADS; i++) {
        let near = bitcast<vec4<f32>>(table[row.first_element + i]);
        let next = bitcast<vec4<f32>>(table[row.first_element + frame.row_len + i]);
        coefficients[N_QUADS * slot + i] = mix(near, next, row.t);
    }
    let units = sqrt(2.0) / frame.radius;
    if N_QUADS == 3u {
        chord_faces[slot] = faces * units;
    }
    // The disc in which the slab cuts the ball.
    let nearest = max(max(faces.x, -faces.y), 0.0) * units;
    staged[slot].across.w = 1.0 - nearest * nearest;
}

// `x` of a staged splat at a place of the tile.
fn form_at(i: u32, at: vec2<f32>) -> f32 {
    let across = staged[i % BATCH].across;
    let along = staged[i % BATCH].along;
    let u = across.x * at.x + (across.y * at.y + across.z);
    let v = along.x * at.y + along.y;
    return u * u + (v * v - 1.0);
}

fn is_within(i: u32, form: f32) -> bool {
    return form < staged[i % BATCH].across.w;
}

fn weight_of(i: u32, at: vec2<f32>, form: f32) -> f32 {
    let low = coefficients[N_QUADS * (i % BATCH)];
    let high = coefficients[N_QUADS * (i % BATCH) + 1u];
    if N_QUADS == 2u {
        return four_and(low, four(high, form), form);
    }
    // The last is that of the chord.
    let highest = coefficients[N_QUADS * (i % BATCH) + N_QUADS - 1u];
    let upper = four_and(high, highest.x + form * (highest.y + form * highest.z), form);
    let faces = chord_faces[i % BATCH];
    let end = sqrt(1.0 - form);
    let chord = min(end, faces.y) - max(-end, faces.x);
    return four_and(low, upper, form) + highest.w * chord;
}

fn four(c: vec4<f32>, x: f32) -> f32 {
    return c.x + x * (c.y + x * (c.z + x * c.w));
}

// The same, and `rest`·x⁴.
fn four_and(c: vec4<f32>, rest: f32, x: f32) -> f32 {
    return c.x + x * (c.y + x * (c.z + x * (c.w + x * rest)));
}
