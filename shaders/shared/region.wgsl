// Where a layer is seen (model §11): behind all of some planes, or not behind all of them. And the part of a
// frame that is drawn (model §17), behind planes of which some belong to it.
//
// A plane takes two elements of `table`: its normal in view space and its distance from the centre of all
// layers; then its normal in the world, and how far before it a voxel may be that adds to anything behind it.
// Distances are in thicknesses of a slab, which all layers share. Planes of the part follow those of each
// layer's region; instead of the normal in the world they have whether they belong to it.
//
// Whoever includes this declares `table`, which holds other things too, and so is of words.

const ELEMENTS_OF_PLANE: u32 = 2u;

// Depths beyond everything.
const NEAREST: f32 = -1e30;
const FARTHEST: f32 = 1e30;

// A ray that crosses a plane more slowly, in thicknesses a thickness, never does.
const LEAST_APPROACH: f32 = 1e-12;

fn plane_of(layer: u32, n: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(table[layers[layer].first_plane + ELEMENTS_OF_PLANE * n]);
}

// The normal in the world, and how far from the plane a voxel may be that it still cuts.
fn face_of(layer: u32, n: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(table[layers[layer].first_plane + ELEMENTS_OF_PLANE * n + 1u]);
}

// Where the ray of a pixel is in the convex set, from the first depth to the second: nowhere if it ends before
// it begins.
fn interval_of(layer: u32, at: vec2<f32>) -> vec2<f32> {
    let from_axis = beside_axis(at);
    var interval = vec2(NEAREST, FARTHEST);
    for (var n = 0u; n < layers[layer].n_planes; n++) {
        interval = behind_plane(interval, plane_of(layer, n), from_axis, true);
    }
    return interval;
}

fn beside_axis(at: vec2<f32>) -> vec2<f32> {
    return vec2(at.x - frame.image_center.x, frame.image_center.y - at.y);
}

// What of an interval of a pixel's ray is behind a plane, or in it, if it `is_held`.
fn behind_plane(
    interval: vec2<f32>,
    plane: vec4<f32>,
    from_axis: vec2<f32>,
    is_held: bool,
) -> vec2<f32> {
    let across = dot(plane.xy, from_axis);
    // approach·z ≤ left
    let approach = across * frame.ray_step + plane.z;
    let left = plane.w - across * frame.ray_start;
    var behind = interval;
    if LEAST_APPROACH < approach {
        behind.y = min(behind.y, left / approach);
    } else if approach < -LEAST_APPROACH {
        behind.x = max(behind.x, left / approach);
    } else if left < 0.0 || (left == 0.0 && !is_held) {
        behind.y = NEAREST;
    }
    return behind;
}

// Where the ray of a pixel is in the part of the frame that is drawn: at its first depth, but not at its last
// one. What lies before the eye belongs to the part in which the eye is.
fn part_interval(at: vec2<f32>) -> vec2<f32> {
    let from_axis = beside_axis(at);
    var interval = vec2(NEAREST, FARTHEST);
    for (var n = 0u; n < layers[0].n_part_planes; n++) {
        let idx = layers[0].n_planes + n;
        interval = behind_plane(interval, plane_of(0u, idx), from_axis, face_of(0u, idx).x == 1.0);
    }
    if frame.is_perspective == 1u {
        let eye = -layers[0].eye_distance / layers[0].slab_thickness;
        if interval.y <= eye {
            return vec2(FARTHEST, NEAREST);
        }
        interval.x = select(interval.x, NEAREST, interval.x <= eye);
    }
    return interval;
}

// What part of a slab lies in the part that is drawn.
fn share_in_part(at: vec2<f32>, slab: u32) -> f32 {
    if layers[0].n_part_planes == 0u {
        return 1.0;
    }
    let front = f32(frame.first_slab + i32(slab));
    return share_within(part_interval(at), front, sums_extinction(frame.compositing));
}

// What part of a slab lies in the region of a layer, given where the ray is in its convex set.
fn share_of(layer: u32, interval: vec2<f32>, slab: u32) -> f32 {
    let front = f32(frame.first_slab + i32(slab));
    return share_behind(layer, interval, front, sums_extinction(frame.compositing));
}

// What part of one thickness behind a depth lies there; all of it or nothing, if only its middle decides.
fn share_behind(layer: u32, interval: vec2<f32>, front: f32, is_split: bool) -> f32 {
    let share = share_within(interval, front, is_split);
    return select(share, 1.0 - share, layers[layer].is_inverted == 1u);
}

// The same of an interval.
fn share_within(interval: vec2<f32>, front: f32, is_split: bool) -> f32 {
    if is_split {
        return max(min(interval.y, front + 1.0) - max(interval.x, front), 0.0);
    }
    let middle = front + 0.5;
    return select(0.0, 1.0, interval.x <= middle && middle < interval.y);
}

// How far before a plane a voxel of a layer lies.
fn before_plane(plane: vec4<f32>, layer: u32, center: vec3<f32>) -> f32 {
    return dot(plane.xyz, center) / layers[layer].slab_thickness - plane.w;
}

// Whether a voxel of a layer adds to nothing that is seen of it.
fn is_beyond(layer: u32, center: vec3<f32>) -> bool {
    return is_beyond_region(layer, center) || is_beyond_part(layer, center);
}

// Whether it adds to nothing of the part that is drawn.
fn is_beyond_part(layer: u32, center: vec3<f32>) -> bool {
    for (var n = 0u; n < layers[layer].n_part_planes; n++) {
        let idx = layers[layer].n_planes + n;
        if face_of(layer, idx).w < before_plane(plane_of(layer, idx), layer, center) {
            return true;
        }
    }
    return false;
}

fn is_beyond_region(layer: u32, center: vec3<f32>) -> bool {
    let is_inverted = layers[layer].is_inverted == 1u;
    var is_behind_all = true;
    for (var n = 0u; n < layers[layer].n_planes; n++) {
        let before = before_plane(plane_of(layer, n), layer, center);
        let reach = face_of(layer, n).w;
        if !is_inverted && reach < before {
            return true;
        }
        is_behind_all = is_behind_all && before < -reach;
    }
    return is_inverted && is_behind_all;
}

// How many `unit`s behind a face its normal counts for nothing; it counts in full up to one before that.
const DEEPEST: f32 = 1.75;

// By how many `unit`s a plane must be nearer than those before it to count as nearer.
const HAIR: f32 = 1.0 / 1024.0;

// A lit face that is near, and how much its normal counts; its plane is of no meaning where that is nothing.
struct NearFace {
    plane: u32,
    share: f32,
}

// The face of a layer near a point of view space.
fn face_near(layer: u32, center: vec3<f32>) -> NearFace {
    if layers[layer].has_lit_faces == 0u || layers[layer].n_planes == 0u {
        return NearFace(0u, 0.0);
    }
    let hair = HAIR / layers[layer].slab_thickness;
    var nearest = 0u;
    var most = before_plane(plane_of(layer, 0u), layer, center);
    for (var n = 1u; n < layers[layer].n_planes; n++) {
        let before = before_plane(plane_of(layer, n), layer, center);
        if most + hair < before {
            nearest = n;
            most = before;
        }
    }
    let behind = -most * outwards(layer) * layers[layer].slab_thickness;
    return NearFace(nearest, clamp(DEEPEST - behind, 0.0, 1.0));
}

// Which way out of a region is, along the normals of its planes.
fn outwards(layer: u32) -> f32 {
    return select(1.0, -1.0, layers[layer].is_inverted == 1u);
}

// What becomes of the normal of a voxel that may be near a lit face.
fn normal_by_faces(layer: u32, center: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let face = face_near(layer, center);
    let share = face.share;
    if share == 0.0 {
        return normal;
    }
    let mixed = face_of(layer, face.plane).xyz * (outwards(layer) * share) + normal * (1.0 - share);
    let length = length(mixed);
    return select(vec3(0.0), mixed / length, 0.0 < length);
}
