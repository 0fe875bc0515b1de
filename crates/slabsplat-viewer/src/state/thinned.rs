//! A layer of fewer voxels, for pictures in which those of the layer are not told apart: every nth along each
//! axis. They have the values of the volume, which means of cells would not: what depends on how many voxels
//! have which values looks alike.

use slabsplat::glam::{DAffine3, DVec3};
use slabsplat::{ColorSamples, Grid, LabelMap, Labels, Layer, Volume, VoxelColors, with_samples};

/// Voxels that are left of an axis at least, where it has so many: of a few slices none is left out.
const MIN_LEFT: usize = 8;

/// The layer with `n_at_most` voxels or hardly more, and how much longer its voxel steps are, per which
/// opacities are; `None` if it has no more already.
pub(super) fn thinned(layer: &Layer, n_at_most: usize) -> Option<(Layer, f64)> {
    let grid = *layer.volume.grid();
    if grid.n_voxels() <= n_at_most {
        return None;
    }
    let thinning = Thinning::of(&grid, n_at_most)?;
    let mut thin = layer.clone().volume(thinning.volume(&layer.volume));
    thin.colors = layer.colors.as_ref().and_then(|colors| thinning.colors(colors));
    thin.labels = layer.labels.as_ref().and_then(|labels| thinning.labels(labels));
    Some((thin, thinning.grid.unit() / grid.unit()))
}

/// Which voxels of a grid are left.
struct Thinning {
    dims: [usize; 3],
    steps: [usize; 3],
    grid: Grid,
}

impl Thinning {
    /// `None` if they are nowhere.
    fn of(grid: &Grid, n_at_most: usize) -> Option<Self> {
        let dims = grid.dims();
        let steps_of = |step: usize| dims.map(|dim| step.min(dim.div_ceil(MIN_LEFT)));
        let left_of = |steps: [usize; 3]| [0, 1, 2].map(|axis| dims[axis].div_ceil(steps[axis]));
        let is_enough =
            |step: &usize| left_of(steps_of(*step)).iter().product::<usize>() <= n_at_most;
        let largest = dims.into_iter().max().unwrap_or(1);
        let steps = steps_of((1..=largest).find(is_enough).unwrap_or(largest));
        let scale = DAffine3::from_scale(DVec3::from_array(steps.map(|step| step as f64)));
        let grid = Grid::new(left_of(steps), grid.world_from_index() * scale).ok()?;
        Some(Self { dims, steps, grid })
    }

    /// The voxels that are left.
    fn voxels(&self) -> impl Iterator<Item = usize> + '_ {
        let along = |axis: usize| (0..self.dims[axis]).step_by(self.steps[axis]);
        let row = move |j: usize, k: usize| self.dims[0] * (j + self.dims[1] * k);
        along(2).flat_map(move |k| along(1).flat_map(move |j| along(0).map(move |i| row(j, k) + i)))
    }

    fn volume(&self, volume: &Volume) -> Volume {
        let samples = with_samples!(volume.samples(), |all| {
            self.voxels().map(|voxel_idx| all[voxel_idx]).collect::<Vec<_>>().into()
        });
        let thin = Volume::new(self.grid, samples, volume.scaling());
        thin.expect("there is a sample for each voxel, and the scaling is another volume's")
    }

    fn colors(&self, colors: &VoxelColors) -> Option<VoxelColors> {
        let samples = match colors.samples() {
            ColorSamples::U8(all) => ColorSamples::U8(self.voxels().map(|idx| all[idx]).collect()),
            ColorSamples::U16(all) => {
                ColorSamples::U16(self.voxels().map(|idx| all[idx]).collect())
            }
            _ => return None,
        };
        VoxelColors::new(self.grid.dims(), samples).ok()
    }

    fn labels(&self, labels: &Labels) -> Option<Labels> {
        let map = labels.map();
        let label = |voxel_idx: usize| map.labels()[usize::from(map.indices()[voxel_idx])] as f64;
        let samples: Vec<f64> = self.voxels().map(label).collect();
        let volume = Volume::new(self.grid, samples.into(), slabsplat::Scaling::IDENTITY).ok()?;
        let map = LabelMap::new(&volume, &self.grid).ok()?;
        Labels::new(map, labels.styles().clone()).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::{LabelStyle, TransferFunction};

    fn layer(dims: [usize; 3]) -> Layer {
        let grid = Grid::with_spacing(dims, [1.0, 2.0, 0.5]).unwrap();
        let [nx, ny, _] = dims;
        let volume = Volume::from_fn(grid, |[i, j, k]| (i + nx * (j + ny * k)) as u32);
        let n_voxels = grid.n_voxels();
        let colors = (0..n_voxels).map(|idx| [idx as u8, 0, 0]).collect();
        let colors = VoxelColors::new(dims, ColorSamples::U8(colors)).unwrap();
        let of_voxels = Volume::from_fn(grid, |[i, ..]| i as i16 - 3);
        let map = LabelMap::new(&of_voxels, &grid).unwrap();
        let labels = Labels::new(map, [(-3, LabelStyle::default().opacity(0.5))]).unwrap();
        let points = [(0.0, 0.0), (1.0, 1.0)];
        let transfer = TransferFunction::new(points, [(0.0, [1.0; 3])]).unwrap();
        Layer::new(volume, transfer).colors(colors).labels(labels)
    }

    #[test]
    fn voxels_that_are_left_are_where_and_what_they_were() {
        let layer = layer([50, 30, 20]);
        let (thin, longer) = thinned(&layer, 3_000).unwrap();
        let (grid, of) = (thin.volume.grid(), layer.volume.grid());
        assert!(grid.n_voxels() <= 3_000 && 500 < grid.n_voxels(), "{:?}", grid.dims());
        let step = of.dims()[0].div_ceil(grid.dims()[0]);
        assert!((longer - step as f64).abs() < 1e-9);
        for at in [[0, 0, 0], [1, 2, 3], grid.dims().map(|dim| dim - 1)] {
            let [thin_idx, idx] = [grid.voxel_idx(at), of.voxel_idx(at.map(|c| c * step))];
            let place = |grid: &Grid, at: [usize; 3]| {
                let at = DVec3::from_array(at.map(|c| c as f64));
                grid.world_from_index().transform_point3(at)
            };
            assert!(place(grid, at).distance(place(of, at.map(|c| c * step))) < 1e-9);
            assert_eq!(thin.volume.value(thin_idx), layer.volume.value(idx));
            let colors = |layer: &Layer, idx| layer.colors.as_ref().unwrap().at(idx);
            assert_eq!(colors(&thin, thin_idx), colors(&layer, idx));
            let label = |layer: &Layer, idx: usize| {
                let map = layer.labels.as_ref().unwrap().map();
                map.labels()[usize::from(map.indices()[idx])]
            };
            assert_eq!(label(&thin, thin_idx), label(&layer, idx));
        }
        assert_eq!(thin.labels.unwrap().styles(), layer.labels.as_ref().unwrap().styles());
        assert!(thinned(&layer, 30_000).is_none());
    }

    #[test]
    fn a_few_slices_stay_so_many() {
        let (thin, _) = thinned(&layer([200, 100, 5]), 2_000).unwrap();
        let dims = thin.volume.grid().dims();
        assert!(dims[2] == 5 && dims.iter().product::<usize>() <= 2_000, "{dims:?}");
    }
}
