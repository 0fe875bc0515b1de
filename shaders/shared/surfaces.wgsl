// Where the rays of a pixel's samples end at opaque surfaces (model §14). The host has found them.
//
// They are in `table` from element `step.first_surface` on. First come all tiles, a word each: the element,
// counted from there, at which a tile begins, 0 if nothing is hit on it. A tile begins with a word for each
// of its pixels, row by row: how many elements behind the tile's first its surfaces begin, in the upper half,
// and how many they are. Then come the surfaces of all its pixels, an element each, the nearest of a pixel
// first:
//
//   x: the sheet in which it lies, as many as there are if behind all of them; of densities the sheet that shows
//      the part of the ray in which it lies
//   y: what part of that sheet lies before it, a float
//   z: red and green, 16 bits each
//   w: blue, likewise, and in the upper half how many rays end there
//
// Whoever includes this declares `table` and `step`.

const NO_SURFACES: u32 = 0xffffffffu;

// Samples of a pixel.
const N_SAMPLES: u32 = 8u;

// The rays of a pixel's samples on their way.
struct Rays {
    // How many have not ended.
    n_left: u32,
    // The next element that any of them meets, and the one behind the last.
    next: u32,
    end: u32,
}

// Those of this thread's pixel.
var<private> rays: Rays;

fn has_surfaces() -> bool {
    return step.first_surface != NO_SURFACES;
}

// The rays of a tile's pixel, before any sheet.
fn rays_of(tile: u32, pixel: u32) -> Rays {
    if !has_surfaces() {
        return Rays(N_SAMPLES, 0u, 0u);
    }
    let from_start = table[step.first_surface + tile / 4u][tile % 4u];
    if from_start == 0u {
        return Rays(N_SAMPLES, 0u, 0u);
    }
    let first = step.first_surface + from_start;
    let word = table[first + pixel / 4u][pixel % 4u];
    let next = first + (word >> 16u);
    return Rays(N_SAMPLES, next, next + (word & 0xffffu));
}

// Whether any ray ends before a sheet.
fn any_ends_before(sheet: u32) -> bool {
    return rays.next < rays.end && table[rays.next].x < sheet;
}

// Ends rays before a sheet that a pixel has come to: it holds what they have met already.
fn skip_rays(sheet: u32) {
    while any_ends_before(sheet) {
        rays.n_left -= table[rays.next].w >> 16u;
        rays.next++;
    }
}

// Puts a sheet behind a pixel, and ends rays in it, or behind it and before sheet `next`, where nothing lies
// between: the twin of the CPU's `ended_rays.rs`.
//
//   of a pixel: n of its rays are left, and 1 − opacity is what goes through all rays together
//   for each ray that ends: color += (1 − opacity)/n · (what of the sheet lies before the surface, and then that)
//   for the others: the whole sheet
//   opacity = 1 − what goes through the others
fn end_rays(pixel: vec4<f32>, sums: vec4<f32>, sheet: u32, next: u32) -> vec4<f32> {
    let of_ray = (1.0 - pixel.a) / f32(rays.n_left);
    var color = vec3(0.0);
    while any_ends_before(next) {
        let surface = table[rays.next];
        let share = select(1.0, bitcast<f32>(surface.y), surface.x == sheet);
        let before = resolve(frame.compositing, sums * share);
        let own = vec3(unpack2x16unorm(surface.z), unpack2x16unorm(surface.w).x);
        let n_ended = surface.w >> 16u;
        color += f32(n_ended) * (before.rgb + (1.0 - before.a) * own);
        rays.n_left -= n_ended;
        rays.next++;
    }
    let whole = resolve(frame.compositing, sums);
    let n_left = f32(rays.n_left);
    // Exactly 1 if none is left, whatever was rounded.
    let opacity = 1.0 - of_ray * n_left * (1.0 - whole.a);
    return vec4(pixel.rgb + of_ray * (color + n_left * whole.rgb), opacity);
}

// Ends rays before a sheet, where nothing is left to be put before them.
fn end_rays_before(pixel: vec4<f32>, sheet: u32) -> vec4<f32> {
    if has_surfaces() && any_ends_before(sheet) {
        return end_rays(pixel, vec4(0.0), 0u, sheet);
    }
    return pixel;
}
