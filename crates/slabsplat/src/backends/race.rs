//! A race between a graphics card and the CPU, where nobody knows which is faster: a card that shares the
//! processor's chip or its memory may be the slower one.

use super::CPU;
use slabsplat_backend::{Backend, BackendError, Planner};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Camera, FrameHandle, Grid, Layer, Projection, Scaling, Scene, TransferFunction, Volume,
};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Frames that count. One before them does not: it compiles shaders and makes lists.
const N_FRAMES: u32 = 3;

/// Who won, by the name of the card.
static DECIDED: Mutex<Vec<(String, bool)>> = Mutex::new(Vec::new());

/// Whether a card draws frames faster than the CPU. They race once: it takes some tenths of a second.
pub(super) fn is_won_by(card: &mut dyn Backend) -> bool {
    let Some(make_cpu) = CPU else { return true };
    let name = card.caps().device.clone();
    let mut decided = DECIDED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, is_won)) = decided.iter().find(|(known, _)| *known == name) {
        return *is_won;
    }
    let started = Instant::now();
    let is_won = is_faster(card, &mut *make_cpu(), || started.elapsed());
    decided.push((name, is_won));
    is_won
}

/// The same of any two, by any clock. One that cannot draw loses.
pub(super) fn is_faster(
    card: &mut dyn Backend,
    cpu: &mut dyn Backend,
    now: impl Fn() -> Duration,
) -> bool {
    let Some(scene) = ball() else { return false };
    match (best_of(card, &scene, &now), best_of(cpu, &scene, &now)) {
        (Ok(of_card), Ok(of_cpu)) => of_card < of_cpu,
        (of_card, _) => of_card.is_ok(),
    }
}

/// What the fastest of some frames takes, each with a camera of its own.
fn best_of(
    backend: &mut dyn Backend,
    scene: &Scene,
    now: &impl Fn() -> Duration,
) -> Result<Duration, BackendError> {
    let (mut planner, mut scene) = (Planner::default(), scene.clone());
    let mut best = Duration::MAX;
    for n in 0..=N_FRAMES {
        scene.camera = scene.camera.orbited(0.02);
        let started = now();
        let Ok(plan) = planner.plan(&scene) else { return Ok(best) };
        let frame = FrameHandle::new();
        backend.submit(&plan, &frame)?;
        backend.wait_image(&frame)?;
        if 0 < n {
            best = best.min(now().saturating_sub(started));
        }
    }
    Ok(best)
}

/// A ball of 64³ voxels with a skin that one sees through, as large as a picture of 512².
fn ball() -> Option<Scene> {
    const SIDE: usize = 64;
    let grid = Grid::with_spacing([SIDE; 3], [1.0; 3]).ok()?;
    let center = grid.center_in_index();
    let value = |idx| {
        let at = DVec3::from_array(grid.voxel_coords(idx).map(|c| c as f64));
        (255.0 * (1.0 - 2.0 * at.distance(center) / SIDE as f64)).max(0.0) as u8
    };
    let samples: Vec<u8> = (0..grid.n_voxels()).map(value).collect();
    let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).ok()?;
    let opacities = vec![(10.0, [0.0]), (60.0, [0.1]), (120.0, [0.8])];
    let colors = vec![(0.0, [0.9, 0.6, 0.4]), (255.0, [0.9, 0.9, 0.8])];
    let transfer = TransferFunction::new(opacities, colors).ok()?;
    let target = volume.grid().center_in_world();
    let projection = Projection::Orthographic { view_height: SIDE as f64 };
    let eye = target + DVec3::new(0.4, 0.3, 2.0) * SIDE as f64;
    let camera = Camera::new(eye, target, DVec3::Y, projection).ok()?;
    Some(Scene::new(Layer::new(volume, transfer), camera))
}
