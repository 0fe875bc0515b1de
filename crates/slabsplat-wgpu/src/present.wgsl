// Draws some rows of a picture into a texture, one triangle over all of it, cut to these rows. Nothing is
// drawn of a picture that is not whole: the texture stays as it was, and the frame is drawn again.
//
// The picture is one of premultiplied colours as screens take them, which is what files of 8 bits hold. So
// its numbers go into plain formats as they are; a format with the transfer curve of sRGB would apply that
// curve once more, and gets what the curve leads back to them.

struct Params {
    // Pixels in a row.
    width: u32,
    // The row that `pixels` begin with.
    first_row: u32,
    // Which of `counts` is 1 if the picture is whole.
    is_whole_at: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> pixels: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> counts: array<u32>;

@vertex
fn cover(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    return vec4(select(-1.0, 3.0, corner == 1u), select(-1.0, 3.0, corner == 2u), 0.0, 1.0);
}

fn pixel_at(position: vec4<f32>) -> vec4<f32> {
    if counts[params.is_whole_at] != 1u {
        discard;
    }
    let at = vec2<u32>(position.xy);
    return pixels[(at.y - params.first_row) * params.width + at.x];
}

@fragment
fn draw_floats(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return pixel_at(position);
}

@fragment
fn draw_bytes(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return clamp(pixel_at(position), vec4(0.0), vec4(1.0));
}

@fragment
fn draw_srgb(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = clamp(pixel_at(position), vec4(0.0), vec4(1.0));
    let low = pixel.rgb / 12.92;
    let high = pow((pixel.rgb + 0.055) / 1.055, vec3(2.4));
    return vec4(select(high, low, pixel.rgb <= vec3(0.04045)), pixel.a);
}
