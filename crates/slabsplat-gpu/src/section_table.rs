//! Tables as the shaders read them: four values that are interpolated between, in one load, or the
//! coefficients of a row's polynomial.

use slabsplat_kernel::{MAX_COEFFICIENTS, RadialPolynomials, SectionTable};

/// Two neighbours in a row, and the same two in the next row.
pub(crate) type Quad = [f32; 4];

/// The quads of a table of sections. The last row stands for its own next one: it
/// is only read where nothing of the next is taken.
pub(crate) fn section_quads(table: &SectionTable) -> Vec<Quad> {
    let rows: Vec<&[f32]> = table.weights().chunks_exact(table.row_len()).collect();
    let next = |row: usize| rows[(row + 1).min(rows.len() - 1)];
    rows.iter().enumerate().flat_map(|(i, row)| row_quads(row, next(i))).collect()
}

/// Quads of a row of coefficients.
pub(crate) const QUADS_OF_ROW: u32 = MAX_COEFFICIENTS as u32 / 4;

/// The coefficients of all rows, from the constant on, and those of the last row once more, as it stands
/// for its own next one.
pub(crate) fn polynomial_quads(polynomials: &RadialPolynomials) -> Vec<Quad> {
    let n_rows = polynomials.n_rows();
    let rows = (0..n_rows).chain([n_rows - 1]).map(|idx| polynomials.row(idx));
    rows.flat_map(|row| row.as_chunks().0.to_vec()).collect()
}

fn row_quads<'a>(row: &'a [f32], next: &'a [f32]) -> impl Iterator<Item = Quad> + 'a {
    row.windows(2).zip(next.windows(2)).map(|(a, b)| [a[0], a[1], b[0], b[1]])
}
