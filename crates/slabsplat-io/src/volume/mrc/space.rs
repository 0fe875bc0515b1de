//! Where the voxels of an MRC file are: a cell of a crystal, or of a box, in steps.

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};

use super::super::units::{NO_SIZE, millimetres};
use super::header::Header;

/// Index space to millimetres. The format does not say how the axes lie in a body: they are taken as they
/// are.
///
/// # Errors
/// If there is no cell of such angles.
pub(super) fn world_from_index(
    header: &Header,
    warnings: &mut Vec<String>,
) -> Result<DAffine3, String> {
    let (steps, is_known) = match steps(header) {
        Some(steps) => (steps, true),
        None => ([1.0; 3], false),
    };
    let directions = directions(header.angles)?;
    let matrix = directions * DMat3::from_diagonal(DVec3::from_array(steps));
    let origin = origin(header, matrix, warnings);
    if !is_known {
        warnings.push(NO_SIZE.to_owned());
        return Ok(DAffine3::from_mat3_translation(matrix, DVec3::ZERO));
    }
    let unit = millimetres("Å").unwrap_or(1.0);
    Ok(DAffine3::from_mat3_translation(matrix * unit, origin * unit))
}

/// Lengths of voxels in ångström, if the header has them.
fn steps(header: &Header) -> Option<[f64; 3]> {
    let is_given = |axis: usize| {
        let length = header.cell[axis];
        0.0 < length && length.is_finite() && 0 < header.intervals[axis]
    };
    (0..3)
        .all(is_given)
        .then(|| [0, 1, 2].map(|axis| header.cell[axis] / f64::from(header.intervals[axis])))
}

/// The directions of a cell's edges as columns: the first along x, the second in the plane of x and y.
/// Angles of 0 are those of a box, as programs that do not know of others write them.
fn directions(angles: [f64; 3]) -> Result<DMat3, String> {
    if angles == [0.0; 3] || angles == [90.0; 3] {
        return Ok(DMat3::IDENTITY);
    }
    // Exactly 0 for right angles.
    let cosine = |angle: f64| if angle == 90.0 { 0.0 } else { angle.to_radians().cos() };
    let [alpha, beta, gamma] = angles.map(cosine);
    let sine = (1.0 - gamma * gamma).sqrt();
    let up = 1.0 - alpha * alpha - beta * beta - gamma * gamma + 2.0 * alpha * beta * gamma;
    let is_cell = angles.iter().all(|&angle| 0.0 < angle && angle < 180.0) && 1e-6 < up;
    if !is_cell {
        let [alpha, beta, gamma] = angles;
        return Err(format!("no cell has the angles {alpha}, {beta} and {gamma} degrees"));
    }
    Ok(DMat3::from_cols(
        DVec3::X,
        DVec3::new(gamma, sine, 0.0),
        DVec3::new(beta, (alpha - beta * gamma) / sine, up.sqrt() / sine),
    ))
}

/// Where the first voxel is, in ångström: ORIGIN, as electron microscopy has it, or else the first indices,
/// as crystallography has them.
fn origin(header: &Header, matrix: DMat3, warnings: &mut Vec<String>) -> DVec3 {
    let mut first = DVec3::ZERO;
    for (stored, &axis) in header.axis_of.iter().enumerate() {
        first[axis] = f64::from(header.start[stored]);
    }
    let by_start = matrix * first;
    let by_origin = DVec3::from_array(header.origin);
    if by_origin == DVec3::ZERO || !by_origin.is_finite() {
        return by_start;
    }
    let is_same = by_start.distance(by_origin) <= 1e-3 * matrix.x_axis.length();
    if by_start != DVec3::ZERO && !is_same {
        let what = "ORIGIN and NXSTART, NYSTART, NZSTART put the volume into different places: ORIGIN was taken";
        warnings.push(what.to_owned());
    }
    by_origin
}
