//! Levels of detail (model §16): cells of voxels, where a tolerance allows them.

use super::frame::{LayerInView, Voxel};
use super::section::KernelInView;
use super::shade::shaded_cell_color;
use super::view::View;
use super::{GaussLegendre, Kernel};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, Light, Shading};
use std::collections::BTreeMap;

/// How far footprints are stretched in the image plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// Of the voxels.
    unit: f64,
    /// Voxels along an edge of what is drawn, and what its own extent adds to the variance of their kernels,
    /// over its own.
    side: f64,
    spread: f64,
}

const LEVELS: std::ops::RangeInclusive<u32> = 1..=3;

impl Stretch {
    /// Of voxels (model §5).
    pub(super) fn of_voxels(unit: f64) -> Self {
        Self { unit, side: 1.0, spread: 0.0 }
    }

    fn of_cells(self, level: u32, kernel: Kernel) -> Self {
        let side = f64::from(1 << level);
        let of_cell = (side * side - 1.0) / 12.0;
        Self { side, spread: of_cell / (side * side * variance(kernel)), ..self }
    }

    pub(super) fn at(&self, view: &View, depth: f64) -> f64 {
        let of_voxels = (view.pixel_size(depth) / self.unit).max(1.0);
        ((of_voxels / self.side).powi(2) - self.spread).max(0.25).sqrt()
    }

    /// The shortest voxel step, whatever is drawn.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }
}

/// A layer by the largest cells that it may be drawn by, brick by brick: what each level draws. All are taken
/// for as faint and as much alike as they must be.
pub(super) fn within(
    layer: LayerInView,
    (shading, lights): &(Shading, Vec<Light>),
    (view, tolerance): (&View, f64),
) -> Vec<LayerInView> {
    let LayerInView { grid, kernel: of_voxels, stretch, unit, ref region, is_cut, .. } = layer;
    let kernel = of_voxels.kernel();
    let levels = LEVELS.take_while(|level| grid.dims().iter().all(|&n| 8 << level <= n));
    let cells: Vec<Cells<'_>> = levels
        .map(|level| {
            let grid = grid.of_cells(level).expect("its steps are not too long");
            Cells {
                side: 1 << level,
                grid,
                kernel: of_voxels.on_cells(&grid, &view.axes, f64::from(1 << level)),
                stretch: stretch.of_cells(level, kernel),
                unit,
                view,
            }
        })
        .collect();
    let most_noise: Vec<f64> =
        cells.iter().map(|cells| cells.most_noise(&layer, tolerance)).collect();
    let noise: Vec<_> = cells.iter().map(|cells| cells.noise(&layer.voxels)).collect();
    let level_of = |voxel: &Voxel| {
        let levels = || 0..cells.len();
        let of_depth = levels().rev().find(|&level| cells[level].draw(voxel.coords))?;
        let is_even =
            |&level: &usize| noise[level][&cells[level].brick(voxel.coords)] <= most_noise[level];
        (0..=of_depth).rev().find(is_even)
    };
    let mut by_level: BTreeMap<Option<usize>, Vec<Voxel>> = BTreeMap::new();
    for voxel in layer.voxels {
        by_level.entry(level_of(&voxel)).or_default().push(voxel);
    }
    let drawn = |(level, voxels): (Option<usize>, Vec<Voxel>)| {
        let region = region.clone();
        let Some(level) = level else {
            return LayerInView { grid, unit, stretch, kernel: of_voxels, voxels, region, is_cut };
        };
        let cells = &cells[level];
        LayerInView {
            grid: cells.grid,
            unit: cells.grid.unit(),
            stretch: cells.stretch,
            kernel: cells.kernel,
            voxels: cells.of(&voxels, (shading, lights)),
            region,
            is_cut,
        }
    };
    by_level.into_iter().map(drawn).collect()
}

/// The cells of a level.
struct Cells<'a> {
    side: usize,
    grid: Grid,
    kernel: KernelInView,
    stretch: Stretch,
    /// Of the voxels.
    unit: f64,
    view: &'a View,
}

/// Sums over the voxels of a cell: extinction `μ`; `μ` times colour and normal; `μ` of those without a
/// normal.
#[derive(Default)]
struct Sums {
    extinction: f64,
    color: [f64; 3],
    normal: DVec3,
    undirected: f64,
}

impl Cells<'_> {
    /// Whether the brick of 8³ cells that holds a voxel lies where these cells may be drawn.
    fn draw(&self, voxel: [usize; 3]) -> bool {
        let dims = self.grid.dims();
        let first = self.brick(voxel).map(|at| 8 * at);
        let last = [0, 1, 2].map(|axis| (first[axis] + 7).min(dims[axis] - 1));
        let nearest = (0..8).map(|corner| {
            let at = [0, 1, 2]
                .map(|axis| if corner >> axis & 1 == 0 { first[axis] } else { last[axis] });
            self.center_in_view(at).z
        });
        let nearest = nearest.fold(f64::INFINITY, f64::min) - self.kernel.depth_reach;
        self.view.near_depth(self.unit) <= nearest && 0.95 <= self.stretch.at(self.view, nearest)
    }

    /// The brick that holds a voxel.
    fn brick(&self, voxel: [usize; 3]) -> [usize; 3] {
        voxel.map(|at| at / self.side / 8)
    }

    /// What colours of cells may differ by from one to the next.
    fn most_noise(&self, layer: &LayerInView, tolerance: f64) -> f64 {
        let layer_depth = layer.kernel.depth_reach / (layer.kernel.kernel().radius() * layer.unit);
        let depth = 0.5 * (((self.side * self.side - 1) as f64) / 12.0).sqrt();
        tolerance / 20.0 / (depth * layer_depth)
    }

    /// By how much they do in each brick, times the lesser extinction of two: the root of the mean of
    /// squares.
    fn noise(&self, voxels: &[Voxel]) -> BTreeMap<[usize; 3], f64> {
        let unlit = self.of(voxels, (&Shading::None, &[]));
        let cells: BTreeMap<[usize; 3], &Voxel> =
            unlit.iter().map(|cell| (cell.coords, cell)).collect();
        let mut squares: BTreeMap<[usize; 3], (f64, f64)> = BTreeMap::new();
        for (coords, a) in &cells {
            let of_brick = squares.entry(coords.map(|at| at / 8)).or_default();
            for axis in (0..3).filter(|&axis| coords[axis] % 8 != 7) {
                let mut next = *coords;
                next[axis] += 1;
                if let Some(b) = cells.get(&next) {
                    let both = a.extinction().min(b.extinction()) / (self.side * self.side) as f64;
                    let pairs = a.unlit.iter().zip(b.unlit);
                    let most = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
                    of_brick.0 += (both * most).powi(2);
                    of_brick.1 += 1.0;
                }
            }
        }
        let root = |(sum, n): (f64, f64)| (sum / n.max(1.0)).sqrt();
        squares.into_iter().map(|(brick, of_brick)| (brick, root(of_brick))).collect()
    }

    fn center_in_view(&self, cell: [usize; 3]) -> DVec3 {
        let at = DVec3::from_array(cell.map(|at| at as f64));
        self.view.view_from_world(self.grid.world_from_index().transform_point3(at))
    }

    fn of(&self, voxels: &[Voxel], light: (&Shading, &[Light])) -> Vec<Voxel> {
        let mut sums: BTreeMap<[usize; 3], Sums> = BTreeMap::new();
        for voxel in voxels {
            let mu = voxel.extinction();
            let sum = sums.entry(voxel.coords.map(|at| at / self.side)).or_default();
            sum.extinction += mu;
            sum.color.iter_mut().zip(voxel.unlit).for_each(|(sum, channel)| *sum += mu * channel);
            sum.normal += mu * voxel.normal;
            sum.undirected += if voxel.normal == DVec3::ZERO { mu } else { 0.0 };
        }
        let cell = |(coords, sums): ([usize; 3], Sums)| {
            let mu = sums.extinction;
            let normal = sums.normal / mu;
            let unlit = sums.color.map(|sum| sum / mu);
            let forward = self.view.axes.forward;
            Voxel {
                coords,
                center_in_view: self.center_in_view(coords),
                opacity: -(-mu / self.side as f64).exp_m1(),
                color: shaded_cell_color(light, unlit, (normal, sums.undirected / mu), forward),
                unlit,
                normal,
            }
        };
        sums.into_iter().map(cell).collect()
    }
}

/// Along any axis.
fn variance(kernel: Kernel) -> f64 {
    let rule = GaussLegendre::new(24);
    let moment = |power: i32| {
        // Where the two pieces of crawfis-max meet.
        let of_shell = |r: f64| kernel.at(r) * r.powi(power);
        rule.integrate(0.0, 0.88, of_shell) + rule.integrate(0.88, kernel.radius(), of_shell)
    };
    moment(4) / (3.0 * moment(2))
}
