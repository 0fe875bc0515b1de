//! Where the voxels of a MetaImage are.

use slabsplat_core::Orientation;
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};

use super::header::Header;
use crate::IoError;

/// Index space to RAS+ millimetres, of an image of so many axes. The rows of `TransformMatrix` are the
/// directions of the axes, as ITK reads them, in LPS.
pub(super) fn world_from_index(header: &Header, n_dims: usize) -> Result<DAffine3, IoError> {
    let spacing = match header.numbers("elementspacing", n_dims)? {
        None => header.numbers("elementsize", n_dims)?,
        given => given,
    };
    let spacing = spacing.unwrap_or_else(|| vec![1.0; n_dims]);
    let directions = header.numbers("transformmatrix", n_dims * n_dims)?;
    let directions = directions.unwrap_or_else(|| identity(n_dims));
    let offset = header.numbers("offset", n_dims)?.unwrap_or_else(|| vec![0.0; n_dims]);

    let ras_from_lps = DVec3::new(-1.0, -1.0, 1.0);
    let column = |axis: usize| {
        let along = if axis < n_dims { &directions[axis * n_dims..][..n_dims] } else { &[] };
        let step = spacing.get(axis).copied().unwrap_or(1.0);
        let default = |other: usize| if n_dims <= axis && other == axis { 1.0 } else { 0.0 };
        let direction = [0, 1, 2].map(|o| along.get(o).copied().unwrap_or_else(|| default(o)));
        DVec3::from_array(direction) * step * ras_from_lps
    };
    let matrix = DMat3::from_cols(column(0), column(1), column(2));
    let origin = [0, 1, 2].map(|axis| offset.get(axis).copied().unwrap_or(0.0));
    Ok(DAffine3::from_mat3_translation(matrix, DVec3::from_array(origin) * ras_from_lps))
}

/// ITK writes a matrix, an offset and a spacing whether anybody has set them or not: where all three are
/// those of a new image, the file says nothing of a body.
pub(super) fn orientation(header: &Header) -> Orientation {
    let differs = |key: &str, usual: &[f64]| {
        let numbers = header.get(key).map(|text| text.split_whitespace().map(str::parse));
        numbers.is_some_and(|mut numbers| !numbers.all(|n| n.is_ok_and(|n| usual.contains(&n))))
    };
    let matrix = header.get("transformmatrix");
    let is_turned = matrix.is_some_and(|text| {
        let numbers = text.split_whitespace().map(|number| number.parse().unwrap_or(f64::NAN));
        !numbers.eq(identity(3))
    });
    let is_set = is_turned
        || differs("offset", &[0.0])
        || (matrix.is_some() && differs("elementspacing", &[1.0]));
    if is_set { Orientation::Anatomical } else { Orientation::Unknown }
}

fn identity(n_dims: usize) -> Vec<f64> {
    let entry = |idx: usize| if idx.is_multiple_of(n_dims + 1) { 1.0 } else { 0.0 };
    (0..n_dims * n_dims).map(entry).collect()
}
