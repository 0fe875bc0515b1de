//! What is under the pointer: the first thing on a ray that hides half of what is behind it.

use slabsplat::glam::DVec3;
use slabsplat::{Layer, Mode, Scene};

/// A point of the world that is seen, and the voxel next to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// Where it is.
    pub point: DVec3,
    /// Which layer is seen there.
    pub layer_idx: usize,
    /// The voxel.
    pub voxel: [usize; 3],
    /// Its value, as its file scales it.
    pub value: f64,
}

/// Samples of a ray, at most: volumes of thousands of voxels along it are looked at in wider steps.
const MAX_SAMPLES: f64 = 4096.0;

/// From which opacity on something is what is seen there.
const SEEN: f64 = 0.5;

/// Opacity below which there is nothing to be pointed at.
const FAINT: f64 = 0.02;

/// What a ray sees first, that begins at a point of the world and goes in a direction of length 1.
///
/// That is where opacities of transfer functions add up to a half, or else where they add most to the ray; in
/// modes that show one density of a ray, where that density is.
pub fn picked(scene: &Scene, [from, along]: [DVec3; 2]) -> Option<Picked> {
    let on_layers = scene.layers.iter().enumerate();
    let found = on_layers.filter_map(|(layer_idx, layer)| {
        let (picked, is_seen) = on_layer(layer, layer_idx, [from, along], scene.settings.mode)?;
        Some((picked, is_seen, (picked.point - from).dot(along)))
    });
    // What hides what is behind it, or else what is only faint.
    let order =
        |a: &(Picked, bool, f64), b: &(Picked, bool, f64)| b.1.cmp(&a.1).then(a.2.total_cmp(&b.2));
    found.min_by(order).map(|(picked, ..)| picked)
}

/// What is seen of one layer, and whether it hides what is behind it.
fn on_layer(
    layer: &Layer,
    layer_idx: usize,
    [from, along]: [DVec3; 2],
    mode: Mode,
) -> Option<(Picked, bool)> {
    let (volume, grid) = (&layer.volume, layer.volume.grid());
    let index_from_world = grid.index_from_world();
    let origin = index_from_world.transform_point3(from);
    let direction = index_from_world.transform_vector3(along);
    let dims = DVec3::from_array(grid.dims().map(|n| n as f64));
    let [enter, leave] = within([DVec3::splat(-0.5), dims - 0.5], origin, direction)?;
    let step = (0.5 / direction.length()).max((leave - enter) / MAX_SAMPLES);
    let steps_of_grid = step / grid.unit();
    let mut best: Option<(f64, Picked)> = None;
    let mut hidden = 0.0;
    for sample_idx in 0..((leave - enter) / step).ceil() as usize {
        let at = enter + (sample_idx as f64 + 0.5) * step;
        let point = from + along * at;
        if !layer.region.contains(point) {
            continue;
        }
        let voxel = (origin + direction * at).round().clamp(DVec3::ZERO, dims - 1.0);
        let voxel = voxel.to_array().map(|i| i as usize);
        let value = volume.value(grid.voxel_idx(voxel));
        if !value.is_finite() {
            continue;
        }
        let picked = Picked { point, layer_idx, voxel, value };
        let rank = match mode {
            Mode::Maximum => value,
            Mode::Minimum => -value,
            _ => {
                // Of a step of the grid, so that thin steps hide less.
                let alpha = opacity(layer, mode, value);
                let share = (1.0 - hidden) * (1.0 - (1.0 - alpha).powf(steps_of_grid));
                hidden += share;
                if SEEN <= hidden {
                    return Some((picked, true));
                }
                share
            }
        };
        if best.is_none_or(|(most, _)| most < rank) {
            best = Some((rank, picked));
        }
    }
    let is_there = mode.statistic().is_some() || FAINT < hidden;
    best.filter(|_| is_there).map(|(_, picked)| (picked, false))
}

/// How opaque a value is, whatever its gradient and its label.
fn opacity(layer: &Layer, mode: Mode, value: f64) -> f64 {
    match mode {
        // All that lies within a surface counts for it.
        Mode::Isosurfaces => {
            let least = layer.isosurfaces.iter().map(|surface| surface.value());
            let is_within = least.fold(f64::INFINITY, f64::min) <= value;
            f64::from(u8::from(is_within))
        }
        _ => layer.transfer.opacity(value),
    }
}

/// Where a line enters and leaves a box, not before it begins.
fn within([lo, hi]: [DVec3; 2], origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let (from, along) = (origin[axis], direction[axis]);
        if along == 0.0 {
            if from < lo[axis] || hi[axis] < from {
                return None;
            }
            continue;
        }
        let ends = [(lo[axis] - from) / along, (hi[axis] - from) / along];
        enter = enter.max(ends[0].min(ends[1]));
        leave = leave.min(ends[0].max(ends[1]));
    }
    (enter < leave && leave.is_finite()).then_some([enter, leave])
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::{Camera, Grid, Projection, Region, Scaling, TransferFunction, Volume};

    /// A wall of value 100 at i = 6 and 7, before air of value 1, in a grid of steps of 2.
    fn scene(opacity_of_wall: f64) -> Scene {
        let grid = Grid::with_spacing([10, 5, 5], [2.0; 3]).unwrap();
        let sample = |[i, _, _]: [usize; 3]| if (6..8).contains(&i) { 100_u8 } else { 1 };
        let volume = Volume::from_fn(grid, sample);
        assert_eq!(volume.scaling(), Scaling::IDENTITY);
        let opacity = [(0.0, 0.0), (50.0, 0.0), (100.0, opacity_of_wall)];
        let transfer = TransferFunction::new(opacity, [(0.0, [1.0; 3])]).unwrap();
        let projection = Projection::Orthographic { view_height: 12.0 };
        let camera = Camera::new([40.0, 4.0, 4.0], [0.0, 4.0, 4.0], DVec3::Z, projection).unwrap();
        Scene::new(Layer::new(volume, transfer), camera)
    }

    fn from_the_right() -> [DVec3; 2] {
        [DVec3::new(40.0, 4.0, 4.0), DVec3::NEG_X]
    }

    #[test]
    fn the_nearest_side_of_what_is_opaque_is_seen() {
        let wall = picked(&scene(1.0), from_the_right()).unwrap();
        assert_eq!((wall.voxel, wall.value), ([7, 2, 2], 100.0));
        assert!((wall.point.x - 15.0).abs() < 1.0, "{wall:?}");
        assert_eq!(picked(&scene(1.0), [DVec3::splat(90.0), DVec3::Y]), None);
        let away = [DVec3::new(40.0, 4.0, 4.0), DVec3::X];
        assert_eq!(picked(&scene(1.0), away), None);
    }

    #[test]
    fn what_is_faint_is_seen_where_it_is_densest() {
        let wall = picked(&scene(0.1), from_the_right()).unwrap();
        assert_eq!(wall.value, 100.0);
        assert_eq!(picked(&scene(0.0), from_the_right()), None);
    }

    #[test]
    fn what_is_cut_off_is_not_seen() {
        let mut cut = scene(1.0);
        cut.layers[0].region = Region::in_box([[0.0; 3], [12.5, 9.0, 9.0]]).unwrap();
        let wall = picked(&cut, from_the_right()).unwrap();
        assert_eq!(wall.voxel, [6, 2, 2]);
    }

    #[test]
    fn modes_of_densities_show_where_they_are() {
        let mut scene = scene(0.0);
        scene.settings.mode = Mode::Maximum;
        assert_eq!(picked(&scene, from_the_right()).unwrap().value, 100.0);
        scene.settings.mode = Mode::Minimum;
        assert_eq!(picked(&scene, from_the_right()).unwrap().value, 1.0);
    }
}
