// Looking up a section (paper §3.2, figure 5), or a whole footprint, which is a table of one row. Each layer has
// a table, and another one of merged sections, if any are; all have rows of one length.
//
// Rows run over the half chord √(R² − ρ²), and stand at equal steps of the depth to which the slab goes into the
// kernel. An element holds all four values that are interpolated between: two neighbours of a row, and
// the same two of the next row. So a look-up is one load.
//
// Whoever includes this declares `table`, which holds other things too, and so is of words.

// A row of the table, and how far it is to the next.
struct Row {
    first_element: u32,
    t: f32,
}

// The row of a section of a layer.
fn row_at(layer: u32, section: Section) -> Row {
    let from_front = section.faces.y + frame.radius;
    let is_mirrored = layers[layer].is_mirrored == 1u;
    let depth = select(from_front, min(from_front, frame.radius - section.faces.x), is_mirrored);
    var first_element = layers[layer].first_element;
    var rows_per_index = layers[layer].rows_per_index;
    var last_row = layers[layer].last_row;
    if section.is_merged {
        first_element = layers[layer].first_merged_element;
        rows_per_index = layers[layer].merged_rows_per_index;
        last_row = layers[layer].last_merged_row;
    }
    let position = clamp(depth * rows_per_index, 0.0, last_row);
    if frame.is_nearest == 1u {
        return Row(first_element + u32(position + 0.5) * frame.row_len, 0.0);
    }
    let row = floor(position);
    return Row(first_element + u32(row) * frame.row_len, position - row);
}

// The weight at `rho_squared`, which is less than the radius squared.
fn weight_at(row: Row, rho_squared: f32) -> f32 {
    let half_chord = sqrt(max(frame.radius * frame.radius - rho_squared, 0.0));
    let position = half_chord * frame.samples_per_index;
    let sample = min(floor(position), f32(frame.row_len - 1u));
    let near = bitcast<vec4<f32>>(table[row.first_element + u32(sample)]);
    let along = mix(near.xz, near.yw, position - sample);
    return mix(along.x, along.y, row.t);
}
