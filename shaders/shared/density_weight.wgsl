// The weight of a section for densities, smooth enough for differences between neighbouring pixels: the kinks
// of a table that is read linearly would show as facets.
//
// A kernel that is a product has polynomials (crates/slabsplat-kernel/src/tilted_sections.rs). Of any other
// there is a table of cubics (cubic_section_table.rs), an element of `table` for the coefficients of each.
//
// Whoever includes this declares `densities`, `staged_layer`, and `number_at`, an element of `table`.

// The weight of a staged section at a pixel's centre.
fn weight_at(i: u32, at: vec2<f32>) -> f32 {
    let d = at - staged[i].center;
    let x = d.x + staged[i].shear * d.y;
    let rho_squared = staged[i].across * x * x + staged[i].along * d.y * d.y;
    if staged[i].rho_squared_max <= rho_squared {
        return 0.0;
    }
    var faces = vec2(staged[i].front, staged[i].back);
    if frame.is_tilted == 1u {
        faces += dot(staged[i].tilt, d);
    }
    let half_chord = sqrt(max(frame.radius * frame.radius - rho_squared, 0.0));
    let layer = staged_layer(i);
    if densities[layer].is_product == 1u {
        let inside = clamp(faces, vec2(-half_chord), vec2(half_chord));
        return weight_of_product(layer, rho_squared, inside);
    }
    if half_chord <= faces.x || faces.y <= -half_chord {
        return 0.0;
    }
    return weight_by_cubics(layer, half_chord, faces);
}

// H = g(ρ)·(A(back) − A(front)), between faces that lie within the ball.
fn weight_of_product(layer: u32, rho_squared: f32, faces: vec2<f32>) -> f32 {
    let per_square = 2.0 / (frame.radius * frame.radius);
    let across = polynomial(densities[layer].across, rho_squared * per_square - 1.0);
    let front = faces.x * polynomial(densities[layer].along, faces.x * faces.x * per_square - 1.0);
    let back = faces.y * polynomial(densities[layer].along, faces.y * faces.y * per_square - 1.0);
    return across * (back - front);
}

// From the constant on.
fn polynomial(c: array<vec4<f32>, 3>, x: f32) -> f32 {
    var sum = c[2].w;
    sum = sum * x + c[2].z;
    sum = sum * x + c[2].y;
    sum = sum * x + c[2].x;
    sum = sum * x + c[1].w;
    sum = sum * x + c[1].z;
    sum = sum * x + c[1].y;
    sum = sum * x + c[1].x;
    sum = sum * x + c[0].w;
    sum = sum * x + c[0].z;
    sum = sum * x + c[0].y;
    return sum * x + c[0].x;
}

// Four rows of cubics, and what the kernel's value at its rim adds.
fn weight_by_cubics(layer: u32, half_chord: f32, faces: vec2<f32>) -> f32 {
    let radius = frame.radius;
    let depth = min(faces.y + radius, radius - faces.x);
    let position = clamp(depth * layers[layer].rows_per_index, 0.0, layers[layer].last_row);
    let row = floor(position);
    let t = position - row;
    let before = t + 1.0;
    let behind = 1.0 - t;
    let second = 2.0 - t;
    let n_cells = f32(frame.row_len - 1u);
    let cell_position = n_cells - n_cells * sqrt(max(1.0 - half_chord / radius, 0.0));
    let cell = min(floor(cell_position), n_cells);
    let first = layers[layer].first_element + u32(row) * frame.row_len + u32(cell);
    let along = cell_position - cell;
    let rows = vec4(
        cubic_at(first, along),
        cubic_at(first + frame.row_len, along),
        cubic_at(first + 2u * frame.row_len, along),
        cubic_at(first + 3u * frame.row_len, along),
    );
    let shares = vec4(
        -t * behind * second / 6.0,
        0.5 * before * behind * second,
        0.5 * before * t * second,
        -before * t * behind / 6.0,
    );
    let cut_length = min(faces.y, half_chord) + min(half_chord, -faces.x);
    return dot(rows, shares) + densities[layer].rim * cut_length;
}

fn cubic_at(element: u32, t: f32) -> f32 {
    let c = number_at(element);
    return c.x + t * (c.y + t * (c.z + t * c.w));
}
