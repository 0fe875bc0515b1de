// The last six sheets of a pixel, of the layer that it has come to, and what is in their middle (model §8).
//
// A sheet's density is a mean over its thickness, and its node is what a smooth function is in the middle
// that has such means.

const N_SHEETS: u32 = 6u;

// The sheet of the first of both nodes in the middle, and that of the second.
const FIRST: u32 = 2u;
const SECOND: u32 = 3u;

// Of each sheet, from front to back: how much of the ray it holds, its density, and the density's slopes to
// the right and upwards, per `unit`.
var<private> sheets: array<vec4<f32>, N_SHEETS>;

// `r`: how much a sheet counts, seen from another one. Seen from one that holds nothing it is of no meaning,
// but that parts go to the node of the other one.
fn share_of_sheet(seen: u32, here: u32) -> f32 {
    if sheets[here].x <= sheets[seen].x {
        return 1.0;
    }
    return sheets[seen].x / sheets[here].x;
}

// `Δ`: by how much the density and its slopes across the ray change from a sheet to another one.
fn change(here: u32, seen: u32) -> vec3<f32> {
    return share_of_sheet(seen, here) * (sheets[seen].yzw - sheets[here].yzw);
}

// `P`: the density and its slopes across the ray in the middle of a sheet.
fn node(here: u32) -> vec3<f32> {
    return sheets[here].yzw - (change(here, here - 1u) + change(here, here + 1u)) / 24.0;
}

// The slope along the ray there, per sheet, of the fourth order where there are two sheets on either side.
fn slope_along(here: u32) -> f32 {
    let behind = share_of_sheet(here + 1u, here);
    let before = share_of_sheet(here - 1u, here);
    let near = change(here, here + 1u).x - change(here, here - 1u).x;
    let far = behind * change(here + 1u, here + 2u).x - before * change(here - 1u, here - 2u).x;
    return near / max(behind + before, 1.0) + 5.0 / 48.0 * behind * before * (near - far);
}
