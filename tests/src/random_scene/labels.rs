//! Labels at random: some visible, some not, some with a transfer function of their own.

use super::random_transfer;
use fastrand::Rng;
use slabsplat_core::{Grid, LabelMap, LabelStyle, Labels, Samples, Scaling, Volume};

/// The labels drawn from.
const LABELS: [i32; 6] = [0, 1, 7, -3, 250, 70_000];

/// Blocks and single voxels of labels, as integers or as floats.
pub(super) fn random_label_volume(rng: &mut Rng, grid: Grid) -> Volume {
    let block = rng.usize(1..=4);
    let of_blocks: Vec<i32> = (0..64).map(|_| LABELS[rng.usize(..LABELS.len())]).collect();
    let label = |voxel_idx: usize| {
        let [x, y, z] = grid.voxel_coords(voxel_idx).map(|coord| coord / block % 4);
        of_blocks[(z * 4 + y) * 4 + x]
    };
    let labels: Vec<i32> = (0..grid.n_voxels()).map(label).collect();
    let samples = if rng.bool() {
        Samples::I32(labels)
    } else {
        Samples::F32(labels.into_iter().map(|label| label as f32).collect())
    };
    Volume::new(grid, samples, Scaling::IDENTITY).expect("there is a label for every voxel")
}

/// What `volume` says of the voxels of `grid`, whose values lie in that range.
pub(super) fn random_labels(
    rng: &mut Rng,
    volume: &Volume,
    grid: &Grid,
    value_range: [f64; 2],
) -> Labels {
    let map = LabelMap::new(volume, grid).expect("labels are whole numbers");
    let mut style = || {
        let mut style = LabelStyle::default();
        style.transfer = (rng.u32(..3) == 0).then(|| random_transfer(rng, value_range));
        style.color = rng.bool().then(|| [0; 3].map(|_| rng.f64()));
        style.opacity([0.0, 1.0, 1.0, rng.f64()][rng.usize(..4)])
    };
    let styles = LABELS[..4].iter().map(|&label| (label.into(), style()));
    Labels::new(map, styles).expect("opacities and colours are from 0 to 1")
}
