//! Tables as the shaders read them: four values that are interpolated between, in one load.

use slabsplat_kernel::{FootprintTable, SectionTable};

/// Two neighbours in a row, and the same two in the next row.
pub(crate) type Quad = [f32; 4];

/// The quads of a table of sections. The last row stands for its own next one: it
/// is only read where nothing of the next is taken.
pub(crate) fn section_quads(table: &SectionTable) -> Vec<Quad> {
    let rows: Vec<&[f32]> = table.weights().chunks_exact(table.row_len()).collect();
    let next = |row: usize| rows[(row + 1).min(rows.len() - 1)];
    rows.iter().enumerate().flat_map(|(i, row)| row_quads(row, next(i))).collect()
}

/// The quads of a whole footprint.
pub(crate) fn footprint_quads(table: &FootprintTable) -> Vec<Quad> {
    row_quads(table.row(), table.row()).collect()
}

fn row_quads<'a>(row: &'a [f32], next: &'a [f32]) -> impl Iterator<Item = Quad> + 'a {
    row.windows(2).zip(next.windows(2)).map(|(a, b)| [a[0], a[1], b[0], b[1]])
}
