//! Levels of detail (model §16): cells of voxels, where a tolerance allows them.

use super::cell_bricks::{OfBrick, OfLight, Sums, bricks, sums};
use super::frame::{LayerInView, Voxel};
use super::region::lit_face;
use super::section::KernelInView;
use super::shade::{Directions, shaded_cell_color};
use super::view::View;
use super::{GaussLegendre, Kernel};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, Light, Region, Shading};
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

    /// Voxels along an edge of what is drawn.
    pub(super) fn side(&self) -> f64 {
        self.side
    }

    /// The shortest voxel step, whatever is drawn.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }
}

/// A layer by the largest cells that it may be drawn by, brick by brick: what each level draws. Cells are
/// taken for as little different from each other as they must be.
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
            let n_voxels = grid.dims();
            let grid = grid.of_cells(level).expect("its steps are not too long");
            Cells {
                side: 1 << level,
                n_voxels,
                grid,
                kernel: of_voxels.on_cells(&grid, &view.axes, f64::from(1 << level)),
                stretch: stretch.of_cells(level, kernel),
                unit,
                view,
            }
        })
        .collect();
    let light = OfLight::new(shading, lights);
    let bricks: Vec<_> = cells
        .iter()
        .map(|cells| bricks((&layer.voxels, cells.side), &cells.grid, &light))
        .collect();
    let by_mean_normals = (3.0 * tolerance / light.normals).powi(2);
    let level_of = |voxel: &Voxel| {
        let levels = || 0..cells.len();
        let of_depth = levels().rev().find(|&level| cells[level].draw(voxel.coords))?;
        let is_even = |&level: &usize| {
            let of_brick = &bricks[level][&cells[level].brick(voxel.coords)];
            of_brick.is_even(tolerance, cells[level].depth_of_voxels(&grid), &light)
                && !cells[level].is_near_lit_face(voxel.coords, region)
        };
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
        let (cells, bricks) = (&cells[level], &bricks[level]);
        LayerInView {
            grid: cells.grid,
            unit: cells.grid.unit(),
            stretch: cells.stretch,
            kernel: cells.kernel,
            voxels: cells.of(&voxels, (bricks, by_mean_normals), (shading, lights)),
            region,
            is_cut,
        }
    };
    by_level.into_iter().map(drawn).collect()
}

/// The bound of model §16 on how long a step in the world is that is one step long in index space.
fn longest_in_world(grid: &Grid) -> f64 {
    let m = grid.world_from_index().matrix3;
    let steps = [m.x_axis, m.y_axis, m.z_axis];
    let sums = steps.map(|a| steps.map(|b| a.dot(b).abs()).iter().sum::<f64>());
    sums.into_iter().fold(0.0, f64::max).sqrt()
}

/// A number from 0 to 1, of each brick another.
fn turn([x, y, z]: [usize; 3]) -> f64 {
    // The real root of x⁴ = x + 1, by Newton's method.
    let root = (0..9).fold(1.2_f64, |x, _| x - (x.powi(4) - x - 1.0) / (4.0 * x.powi(3) - 1.0));
    (x as f64 / root + y as f64 / root.powi(2) + z as f64 / root.powi(3)).fract()
}

/// The cells of a level.
struct Cells<'a> {
    side: usize,
    /// Along each axis.
    n_voxels: [usize; 3],
    grid: Grid,
    kernel: KernelInView,
    stretch: Stretch,
    /// Of the voxels.
    unit: f64,
    view: &'a View,
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
        let n_bricks = self.n_voxels.map(|n| n.div_ceil(8 * self.side));
        let is_at_end = (0..3).any(|axis| {
            let at = self.brick(voxel)[axis];
            at == 0 || at + 1 == n_bricks[axis]
        });
        let of_levels = if is_at_end { [0.95, 1.1, 1.3] } else { [0.87, 0.9, 0.9] };
        let of_level = of_levels[self.side.ilog2() as usize - 1];
        let least = of_level * (1.0 + turn(self.brick(voxel)) / 24.0);
        self.view.near_depth(self.unit) <= nearest && least <= self.stretch.at(self.view, nearest)
    }

    /// Whether any cell of the brick that holds a voxel lies where a lit face has a say.
    fn is_near_lit_face(&self, voxel: [usize; 3], region: &Region) -> bool {
        let brick = self.brick(voxel);
        let [xs, ys, zs] =
            [0, 1, 2].map(|axis| 8 * brick[axis]..self.grid.dims()[axis].min(8 * brick[axis] + 8));
        let to_world = self.grid.world_from_index();
        let is_near = |[x, y, z]: [usize; 3]| {
            let at = to_world.transform_point3(DVec3::new(x as f64, y as f64, z as f64));
            lit_face(region, self.unit, at).is_some_and(|(_, behind)| behind < 1.75)
        };
        let mut rows = zs.flat_map(|z| ys.clone().map(move |y| [y, z]));
        rows.any(|[y, z]| xs.clone().any(|x| is_near([x, y, z])))
    }

    /// The brick that holds a voxel.
    fn brick(&self, voxel: [usize; 3]) -> [usize; 3] {
        voxel.map(|at| at / self.side / 8)
    }

    /// How deep the voxels of a cell lie apart, at most from any side: their standard deviation.
    fn depth_of_voxels(&self, voxels: &Grid) -> f64 {
        ((self.side * self.side - 1) as f64 / 12.0).sqrt() * longest_in_world(voxels) / self.unit
    }

    fn center_in_view(&self, cell: [usize; 3]) -> DVec3 {
        let at = [0, 1, 2].map(|axis| cell[axis] as f64 + self.moved(cell, axis));
        let at = DVec3::from_array(at);
        self.view.view_from_world(self.grid.world_from_index().transform_point3(at))
    }

    /// How far a cell lies along an axis from the middle of its place, in cells.
    fn moved(&self, cell: [usize; 3], axis: usize) -> f64 {
        let side = self.side as f64;
        let outwards = |n: f64| 0.5 * (n - side) + (side * side - 1.0) / (12.0 * n);
        let (first, is_last) = (self.side * cell[axis], cell[axis] + 1 == self.grid.dims()[axis]);
        if first == 0 {
            -outwards(side) / side
        } else if is_last {
            let n_in_last = (self.n_voxels[axis] - first) as f64;
            outwards(n_in_last).min(outwards(side)) / side
        } else {
            0.0
        }
    }

    fn of(
        &self,
        voxels: &[Voxel],
        (bricks, by_mean_normals): (&BTreeMap<[usize; 3], OfBrick>, f64),
        light: (&Shading, &[Light]),
    ) -> Vec<Voxel> {
        let cell = |(coords, sums): ([usize; 3], Sums)| {
            let mu = sums.extinction;
            let has_moments = by_mean_normals < bricks[&coords.map(|at| at / 8)].extinction;
            let directions = Directions {
                normal: sums.normal(),
                undirected: sums.undirected(),
                moments: has_moments.then(|| sums.moments()),
            };
            let forward = self.view.axes.forward;
            Voxel {
                coords,
                center_in_view: self.center_in_view(coords),
                opacity: -(-mu / self.side as f64).exp_m1(),
                color: shaded_cell_color(light, sums.color(), &directions, forward),
                unlit: sums.color(),
                normal: sums.normal(),
            }
        };
        sums(voxels, self.side).into_iter().map(cell).collect()
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
