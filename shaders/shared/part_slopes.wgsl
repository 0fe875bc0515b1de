// Slopes of the density on the part of a ray between the two nodes in the middle, and the normals that they
// make (model §8).

// To the right and upwards, per `unit`, and along the ray, per sheet: at the part's start, at its end, and
// four times how much more they are half way than in the mean of both.
struct Slopes {
    start: vec3<f32>,
    end: vec3<f32>,
    bulge: vec3<f32>,
}

// Those of a part that begins and ends with these.
fn slopes_between(start: vec3<f32>, end: vec3<f32>) -> Slopes {
    let evenness = share_of_sheet(FIRST, SECOND) * share_of_sheet(SECOND, FIRST);
    let before = change(FIRST, FIRST - 1u);
    let behind = change(SECOND, SECOND + 1u);
    let from_first_to_second = sheets[SECOND].y - sheets[FIRST].y;
    let half_way = from_first_to_second * (7.0 / 6.0) - (behind.x - before.x) / 12.0;
    let along = half_way - 0.5 * (start.z + end.z);
    let across = (before.yz + behind.yz) / -16.0;
    return Slopes(start, end, 4.0 * evenness * vec3(across, along));
}

// −∇d/max(|∇d|, faint) at a position of the part, 0 to 1: to the right, upwards and forward.
fn normal_at(layer: u32, slopes: Slopes, t: f32, pixel: Pixel) -> vec3<f32> {
    let slope = mix(slopes.start, slopes.end, t) + t * (1.0 - t) * slopes.bulge;
    // From a sheet to the next, a pixel moves with its ray.
    let slant = from_axis(pixel) * frame.ray_step;
    let forward = slope.z / layers[layer].slab_thickness - dot(slant, slope.xy);
    let gradient = vec3(slope.xy, forward);
    return -gradient / max(length(gradient), densities[layer].faint);
}

// Pixels from the optical axis, to the right and upwards.
fn from_axis(pixel: Pixel) -> vec2<f32> {
    return vec2(pixel.at.x - frame.image_center.x, frame.image_center.y - pixel.at.y);
}
