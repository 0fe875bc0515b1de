// What is stored of a cell of voxels (model §16) while all stays that decides how it looks: means of these,
// weighted with their extinctions. The host writes it.

struct CellRecord {
    // The cell's index among all that the grid has, x fastest.
    cell_idx: u32,
    // Its weight in a sheet.
    extinction: f32,
    // Red, green, blue before light, and the share that has no normal: 16 bits each, 0 … 1.
    color: vec2<u32>,
    // The mean of −∇v/|∇v| in world space: 16 bits each, −1 … 1; and whether second moments are known.
    normal: vec2<u32>,
    // The second moments of normals, xx, yy, zz, xy, xz and yz in 10 bits each: `moments.rs`.
    moments: vec2<u32>,
}

struct CellValues {
    color: vec3<f32>,
    undirected: f32,
    normal: vec3<f32>,
    has_moments: bool,
    // xx, yy, zz, and xy, xz, yz.
    squares: vec3<f32>,
    products: vec3<f32>,
}

const MOMENT_STEPS: f32 = 1023.0;

fn cell_of(record: CellRecord) -> CellValues {
    let red_green = unpack2x16unorm(record.color.x);
    let blue_undirected = unpack2x16unorm(record.color.y);
    let xy = unpack2x16snorm(record.normal.x);
    let z_known = unpack2x16snorm(record.normal.y);
    let low = record.moments.x;
    let high = record.moments.y;
    let squares = vec3(low, low >> 10u, low >> 20u) & vec3(0x3ffu);
    // The fourth begins in the lower word, and ends in the upper one.
    let products = vec3((low >> 30u) | (high << 2u), high >> 8u, high >> 18u) & vec3(0x3ffu);
    return CellValues(
        vec3(red_green, blue_undirected.x),
        blue_undirected.y,
        vec3(xy, z_known.x),
        0.0 < z_known.y,
        vec3<f32>(squares) / MOMENT_STEPS,
        vec3<f32>(products) / MOMENT_STEPS - 0.5,
    );
}

// The mean of squares along a direction.
fn square_along(cell: CellValues, direction: vec3<f32>) -> f32 {
    let mixed = vec3(direction.x * direction.yz, direction.y * direction.z);
    return dot(cell.squares, direction * direction) + 2.0 * dot(cell.products, mixed);
}
