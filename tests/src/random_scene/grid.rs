//! Grids at random, of each kind that differs to a renderer.

use super::{between, radius, random_direction};
use fastrand::Rng;
use slabsplat_core::Grid;
use slabsplat_core::glam::{DAffine3, DMat3, DQuat, DVec3};

/// How a grid lies in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridKind {
    /// Along the axes, with one spacing.
    Cubic,
    /// Along the axes, with three.
    Anisotropic,
    /// With axes that are not at right angles.
    Sheared,
    /// Turned.
    Rotated,
    /// Left-handed.
    Mirrored,
}

impl GridKind {
    /// Each of them.
    pub const ALL: [Self; 5] =
        [Self::Cubic, Self::Anisotropic, Self::Sheared, Self::Rotated, Self::Mirrored];
}

pub(super) fn random_grid(rng: &mut Rng, kind: GridKind) -> Grid {
    let dims = [0; 3].map(|_| rng.usize(5..=9));
    let spacing = between(rng, 0.4, 2.5);
    let uneven =
        |rng: &mut Rng| DVec3::from_array([0; 3].map(|_| spacing * between(rng, 1.0, 2.2)));
    let turn = |rng: &mut Rng| {
        DMat3::from_quat(DQuat::from_axis_angle(random_direction(rng), between(rng, 0.3, 3.0)))
    };
    let matrix = match kind {
        GridKind::Cubic => DMat3::from_diagonal(DVec3::splat(spacing)),
        GridKind::Anisotropic => DMat3::from_diagonal(uneven(rng)),
        GridKind::Sheared => sheared(rng) * DMat3::from_diagonal(uneven(rng)),
        GridKind::Rotated => turn(rng) * DMat3::from_diagonal(DVec3::splat(spacing)),
        GridKind::Mirrored => {
            let mut sizes = uneven(rng);
            sizes[rng.usize(..3)] *= -1.0;
            turn(rng) * DMat3::from_diagonal(sizes)
        }
    };
    let origin = 20.0 * rng.f64() * random_direction(rng);
    Grid::new(dims, DAffine3::from_mat3_translation(matrix, origin)).expect("no axis is flat")
}

/// One of any kind, whose middle is not far from that of `other`. Of several around the same, none has steps
/// more than 3 times as long as those of another.
pub(super) fn random_grid_around(rng: &mut Rng, other: &Grid) -> Grid {
    let kind = GridKind::ALL[rng.usize(..GridKind::ALL.len())];
    let any = random_grid(rng, kind);
    let unit = other.unit() * 3_f64.powf(between(rng, -0.5, 0.5));
    let matrix = any.world_from_index().matrix3 * (unit / any.unit());
    let aside = radius(other) * between(rng, 0.0, 0.6) * random_direction(rng);
    let origin = other.center_in_world() + aside - matrix * any.center_in_index();
    Grid::new(any.dims(), DAffine3::from_mat3_translation(matrix, origin)).expect("no axis is flat")
}

/// Lower triangular, with each axis off by at most some 30°.
fn sheared(rng: &mut Rng) -> DMat3 {
    let mut lean = || between(rng, -0.5, 0.5);
    DMat3::from_cols(
        DVec3::new(1.0, lean(), lean()),
        DVec3::new(0.0, 1.0, lean()),
        DVec3::new(0.0, 0.0, 1.0),
    )
}
