//! Cameras at random: near, far, inside the volume, and so far that a pixel spans several voxels.

use super::{ProjectionKind, between, radius, random_direction};
use fastrand::Rng;
use slabsplat_core::{Camera, Grid, Projection};

pub(super) fn random_camera(rng: &mut Rng, grid: &Grid, kind: ProjectionKind, rows: u32) -> Camera {
    let radius = radius(grid);
    let off_center = random_direction(rng) * between(rng, 0.0, 0.2) * radius;
    let target = grid.center_in_world() + off_center;
    let (projection, distance) = match kind {
        ProjectionKind::Orthographic => orthographic(rng, radius, f64::from(rows) * grid.unit()),
        ProjectionKind::Perspective => perspective(rng, radius),
    };
    loop {
        let eye = target + distance * random_direction(rng);
        // It fails only where up happens to be forward.
        if let Ok(camera) = Camera::new(eye, target, random_direction(rng), projection) {
            return camera;
        }
    }
}

/// The projection and the eye's distance. At a view height of `voxel_rows` a pixel is a voxel step.
fn orthographic(rng: &mut Rng, radius: f64, voxel_rows: f64) -> (Projection, f64) {
    let view_height = match rng.u32(..4) {
        0 => voxel_rows * between(rng, 1.1, 3.0),
        _ => 2.0 * radius * between(rng, 0.5, 1.2),
    };
    let distance = match rng.u32(..5) {
        0 => between(rng, 0.1, 0.8),
        _ => between(rng, 2.0, 5.0),
    };
    (Projection::Orthographic { view_height }, distance * radius)
}

fn perspective(rng: &mut Rng, radius: f64) -> (Projection, f64) {
    let fov_y_radians = between(rng, 20.0, 70.0).to_radians();
    let fits = 1.0 / (0.5 * fov_y_radians).tan();
    let distance = match rng.u32(..4) {
        0 => between(rng, 0.1, 0.9),
        1 => fits * between(rng, 3.0, 6.0),
        _ => 1.2 + fits * between(rng, 0.5, 1.2),
    };
    (Projection::Perspective { fov_y_radians }, distance * radius)
}
