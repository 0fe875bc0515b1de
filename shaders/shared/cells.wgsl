// A transfer function, cut into cells of densities on which the weight is a cubic and the colour linear
// (crates/slabsplat-backend/src/densities/weight_cells.rs). They follow each other without a gap, far enough
// for all densities.
//
// A cell takes six elements of `table`, see `crates/slabsplat-gpu/src/density_elements.rs`.
//
// Whoever includes this declares `densities` and `number_at`, an element of `table`.

const ELEMENTS_OF_CELL: u32 = 6u;

struct Cell {
    // Its first element.
    element: u32,
    start: f32,
    width: f32,
    // In powers of the position in the cell, 0 to 1.
    weight: vec4<f32>,
}

// The number of the last cell of a layer that does not begin behind a density.
fn cell_of(layer: u32, density: f32) -> u32 {
    var lo = 1u;
    var hi = densities[layer].n_shown;
    while lo < hi {
        let middle = (lo + hi) / 2u;
        if number_at(densities[layer].first_shown + middle * ELEMENTS_OF_CELL).x <= density {
            lo = middle + 1u;
        } else {
            hi = middle;
        }
    }
    return lo - 1u;
}

fn cell_at(layer: u32, number: u32) -> Cell {
    let element = densities[layer].first_shown + number * ELEMENTS_OF_CELL;
    let extent = number_at(element).xy;
    return Cell(element, extent.x, extent.y, number_at(element + 1u));
}

fn weight_in(cell: Cell, t: f32) -> f32 {
    let c = cell.weight;
    return max(c.x + t * (c.y + t * (c.z + t * c.w)), 0.0);
}

fn color_in(cell: Cell, t: f32) -> vec3<f32> {
    return number_at(cell.element + 2u).xyz + t * number_at(cell.element + 3u).xyz;
}
