// From view space to pixels (model §5).

// Pixels per unit of a layer at a depth.
fn scale_at(layer: u32, depth: f32) -> f32 {
    if frame.is_perspective == 1u {
        return layers[layer].pixels_per_unit / (depth + layers[layer].eye_distance);
    }
    return layers[layer].pixels_per_unit;
}

// By how much footprints are widened where a pixel covers more than a unit; those of cells, so that they are as
// wide as those of their voxels together.
fn stretch_of(layer: u32, scale: f32) -> f32 {
    let squared = 1.0 / (scale * scale) - layers[layer].spread;
    return sqrt(max(squared, layers[layer].least_stretch_squared));
}

// Where a point lies in the picture.
fn pixel_of(center: vec3<f32>, scale: f32) -> vec2<f32> {
    return frame.image_center + vec2(center.x, -center.y) * scale;
}
