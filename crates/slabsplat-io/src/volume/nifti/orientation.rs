//! Where the voxels lie, by the three methods of nifti1.h: the affine (`sform`), the rotation
//! (`qform`), or the spacing alone. NIfTI's world is RAS+, as ours is.

use slabsplat_core::glam::{DAffine3, DMat3, DQuat, DVec3};
use slabsplat_core::{Grid, GridError, Orientation};

use super::header::{Header, Version};

/// The grid, by the first method that the header offers and that gives one.
pub(super) fn grid(
    header: &Header,
    dims: [usize; 3],
    warnings: &mut Vec<String>,
) -> Result<Grid, GridError> {
    let unit = unit_in_millimetres(header, warnings);
    let to_millimetres = DAffine3::from_scale(DVec3::splat(unit));
    let in_world = |affine: DAffine3| Grid::new_large(dims, to_millimetres * affine);
    for (name, code, affine) in
        [("sform", header.sform_code, sform(header)), ("qform", header.qform_code, qform(header))]
    {
        if 0 < code {
            match in_world(affine) {
                Err(GridError::Singular { .. }) => {
                    warnings.push(format!("the {name} cannot be inverted, and was passed over"));
                }
                decided => return decided,
            }
        }
    }
    for axis in 1..=3 {
        let length = header.pixdim[axis];
        if axis as i64 <= header.dim[0] && !length.is_normal() {
            warnings.push(format!("voxels are {length} long along axis {axis}: 1 was assumed"));
        }
    }
    if header.version == Version::Zero {
        warnings.push(
            "Analyze 7.5 does not say how it lies: its x was taken to go to the left, as its makers had it"
                .to_owned(),
        );
        return in_world(DAffine3::from_scale(spacing(header) * DVec3::new(-1.0, 1.0, 1.0)));
    }
    in_world(DAffine3::from_scale(spacing(header)))
}

/// Without a code the file gives lengths alone, of whatever it is.
pub(super) fn orientation(header: &Header) -> Orientation {
    let is_placed = 0 < header.sform_code || 0 < header.qform_code;
    match is_placed || header.version == Version::Zero {
        true => Orientation::Anatomical,
        false => Orientation::Unknown,
    }
}

/// By `xyzt_units`. Files that say none (0) count in millimetres, as all programs take them.
fn unit_in_millimetres(header: &Header, warnings: &mut Vec<String>) -> f64 {
    match header.xyzt_units & 7 {
        0 | 2 => 1.0,
        1 => 1e3,
        3 => 1e-3,
        code => {
            warnings.push(format!("there is no unit of length {code}: millimetres were assumed"));
            1.0
        }
    }
}

fn sform(header: &Header) -> DAffine3 {
    let [x, y, z] = header.srow.map(|[x, y, z, _]| DVec3::new(x, y, z));
    let origin = DVec3::from_array(header.srow.map(|[_, _, _, offset]| offset));
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z).transpose(), origin)
}

/// The rotation's quaternion lacks its real part, which is what makes its length 1; `pixdim[0]`
/// says whether the third axis is mirrored.
fn qform(header: &Header) -> DAffine3 {
    let imaginary = DVec3::from_array(header.quatern);
    let real = (1.0 - imaginary.length_squared()).max(0.0).sqrt();
    // Rounding may leave the imaginary part a little longer than 1.
    let quaternion = DQuat::from_vec4(imaginary.extend(real)).normalize();
    let mirror = if header.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    let scale = DMat3::from_diagonal(spacing(header) * DVec3::new(1.0, 1.0, mirror));
    let origin = DVec3::from_array(header.qoffset);
    DAffine3::from_mat3_translation(DMat3::from_quat(quaternion) * scale, origin)
}

/// The voxel's sides; 1 where the header has no length.
fn spacing(header: &Header) -> DVec3 {
    let [_, x, y, z, ..] = header.pixdim;
    let side = |length: f64| if length.is_normal() { length.abs() } else { 1.0 };
    DVec3::new(side(x), side(y), side(z))
}
