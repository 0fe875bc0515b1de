// Pre-integrated classification (Engel, Kraus & Ertl, Graphics Hardware 2001): the mean opacity and colour of
// a part of a ray on which the density goes evenly from one value to another (model §8).
//
//   W = ∫μ dd / (b − a),   from a to b: the rest of the cell that holds a, the cells between, and that of b
//
// Of the cells between, integrals are a difference of two running ones, which come as two numbers each, as one
// would not have the digits. Within a cell nothing is subtracted.

// What a part is in the mean.
struct Mean {
    // Of what the compositing sums.
    weight: f32,
    // Weighted with that.
    color: vec3<f32>,
    // Where on the part that weight lies: 0 at its start, 1 at its end.
    position: f32,
}

// Integrals over densities: of the weight, times red, green, blue, and times how far a density lies behind
// the first.
struct Integrals {
    weight: f32,
    color: vec3<f32>,
    moment: f32,
}

// Densities that differ by rounding are one, and one that lies as much before a step counts as on it.
const ROUNDING: f32 = 1.0 / 524288.0;

// Beyond all densities.
const END: f32 = 1.5;

// Weights that no picture shows.
const NOTHING: f32 = 1e-9;

fn mean_between(layer: u32, start: f32, end: f32) -> Mean {
    let a = clamp(start, -END, END);
    let b = clamp(end, -END, END);
    if abs(b - a) <= 2.0 * ROUNDING {
        return mean_at(layer, 0.5 * (a + b));
    }
    let least = min(a, b);
    let width = abs(b - a);
    let whole = integrals_between(layer, least, max(a, b));
    if whole.weight <= NOTHING * width {
        return Mean(0.0, vec3(0.0), 0.5);
    }
    let behind_least = clamp(whole.moment / (whole.weight * width), 0.0, 1.0);
    let position = select(1.0 - behind_least, behind_least, a < b);
    return Mean(whole.weight / width, whole.color / whole.weight, position);
}

fn integrals_between(layer: u32, a: f32, b: f32) -> Integrals {
    let first = cell_of(layer, a);
    let last = cell_of(layer, b);
    let cell = cell_at(layer, first);
    if first == last {
        return integrals_in(cell, a, b);
    }
    var sum = integrals_in(cell, a, cell_at(layer, first + 1u).start);
    let between = running_integrals(layer, first + 1u, last);
    sum.weight += between.weight;
    sum.color += between.color;
    sum.moment += between.moment - a * between.weight;
    let end = cell_at(layer, last);
    let rest = integrals_in(end, end.start, b);
    sum.weight += rest.weight;
    sum.color += rest.color;
    sum.moment += rest.moment + (end.start - a) * rest.weight;
    return sum;
}

// Within a cell: its cubic, in powers of how far it is from the first density.
fn integrals_in(cell: Cell, a: f32, b: f32) -> Integrals {
    let c = cell.weight;
    let t = (a - cell.start) / cell.width;
    let u = (b - a) / cell.width;
    let powers = vec4(
        c.x + t * (c.y + t * (c.z + t * c.w)),
        c.y + t * (2.0 * c.z + 3.0 * t * c.w),
        c.z + 3.0 * t * c.w,
        c.w,
    );
    let mean = powers.x + u * (powers.y / 2.0 + u * (powers.z / 3.0 + u * powers.w / 4.0));
    let moment = powers.x / 2.0 + u * (powers.y / 3.0 + u * (powers.z / 4.0 + u * powers.w / 5.0));
    let weight = max(mean, 0.0) * (b - a);
    let behind = max(moment, 0.0) * (b - a) * (b - a);
    let slope = number_at(cell.element + 3u).xyz / cell.width;
    return Integrals(weight, color_in(cell, t) * weight + slope * behind, behind);
}

// Over all cells from one on and before another one; the moment is that about 0.
fn running_integrals(layer: u32, first: u32, end: u32) -> Integrals {
    let before = densities[layer].first_shown + first * ELEMENTS_OF_CELL;
    let behind = densities[layer].first_shown + end * ELEMENTS_OF_CELL;
    let large = number_at(behind + 4u) - number_at(before + 4u);
    let sums = large + (number_at(behind + 5u) - number_at(before + 5u));
    let moments = number_at(behind).zw - number_at(before).zw;
    return Integrals(sums.x, sums.yzw, moments.x + moments.y);
}

// A part of one density.
fn mean_at(layer: u32, density: f32) -> Mean {
    let number = cell_of(layer, density);
    var cell = cell_at(layer, number);
    var t = (density - cell.start) / cell.width;
    if number + 1u < densities[layer].n_shown {
        let next = cell_at(layer, number + 1u);
        // What falls to 0 there is 0 a rounding before it, too.
        if next.start <= density + ROUNDING && (begins_with_step(next) || next.weight.x <= 0.0) {
            cell = next;
            t = 0.0;
        }
    }
    let weight = weight_in(cell, clamp(t, 0.0, 1.0));
    return Mean(weight, color_in(cell, clamp(t, 0.0, 1.0)), 0.5);
}

fn begins_with_step(cell: Cell) -> bool {
    return number_at(cell.element + 2u).w == 1.0;
}
