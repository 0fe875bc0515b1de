//! Bricks of cells (model §16): which of them are even enough to be drawn.

use super::frame::Voxel;
use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{Grid, Light, Shading};
use std::collections::BTreeMap;

/// Sums over the voxels of a cell: extinction `μ`; `μ` times colour and normal; `μ` of those without a
/// normal.
#[derive(Default)]
pub(super) struct Sums {
    pub(super) extinction: f64,
    color: [f64; 3],
    squares: [f64; 3],
    /// Of extinctions alone.
    square: f64,
    normal: DVec3,
    undirected: f64,
    /// Of normal times normal, transposed, column by column: a matrix begins as the identity.
    moments: [DVec3; 3],
}

impl Sums {
    pub(super) fn color(&self) -> [f64; 3] {
        self.color.map(|sum| sum / self.extinction)
    }

    pub(super) fn normal(&self) -> DVec3 {
        self.normal / self.extinction
    }

    pub(super) fn undirected(&self) -> f64 {
        self.undirected / self.extinction
    }

    pub(super) fn moments(&self) -> DMat3 {
        let [x, y, z] = self.moments.map(|sum| sum / self.extinction);
        DMat3::from_cols(x, y, z)
    }

    /// By how much colours differ from those of another, times the lesser extinction.
    fn difference(&self, other: &Self) -> [f64; 3] {
        let (here, there) = (self.color(), other.color());
        [0, 1, 2]
            .map(|channel| self.extinction.min(other.extinction) * (here[channel] - there[channel]))
    }

    /// Both together, but for moments.
    fn and(mut self, other: &Self) -> Self {
        self.extinction += other.extinction;
        for channel in 0..3 {
            self.color[channel] += other.color[channel];
            self.squares[channel] += other.squares[channel];
        }
        self.square += other.square;
        self.normal += other.normal;
        self.undirected += other.undirected;
        self
    }

    /// In the channel in which it is largest.
    fn variance_of_colors(&self) -> f64 {
        let pairs = self.color().into_iter().zip(self.squares);
        pairs.fold(0.0, |most, (mean, sum)| most.max(sum / self.extinction - mean * mean))
    }

    /// Of what light makes of directions: 1 at most where all have one.
    fn variance_of_directions(&self) -> f64 {
        let d = 1.0 - self.undirected();
        let r = if d < 1e-9 { 0.0 } else { self.normal().length() / d };
        let of_all = ((1.0 - r * r) * (0.75 + 2.7 * r * r)).min(1.0);
        d * of_all + 9.0 * d * (1.0 - d)
    }
}

/// What groups of `side³` voxels have together.
pub(super) fn sums(voxels: &[Voxel], side: usize) -> BTreeMap<[usize; 3], Sums> {
    let mut sums: BTreeMap<[usize; 3], Sums> = BTreeMap::new();
    for voxel in voxels {
        let (mu, n) = (voxel.extinction(), voxel.normal);
        let sum = sums.entry(voxel.coords.map(|at| at / side)).or_default();
        sum.extinction += mu;
        sum.square += mu * mu;
        for (channel, color) in voxel.unlit.into_iter().enumerate() {
            sum.color[channel] += mu * color;
            sum.squares[channel] += mu * color * color;
        }
        sum.normal += mu * n;
        sum.undirected += if n == DVec3::ZERO { mu } else { 0.0 };
        sum.moments.iter_mut().zip(n.to_array()).for_each(|(column, x)| *column += mu * x * n);
    }
    sums
}

/// What decides how a brick of cells is drawn.
#[derive(Clone, Copy, Default)]
pub(super) struct OfBrick {
    /// The mean extinction of the most opaque cell's voxels.
    pub(super) extinction: f64,
    /// The standard deviation of lit colours within a block of 2³ cells, times the extinction of a voxel, and
    /// that of extinctions: the largest.
    spread: f64,
    spread_of_extinction: f64,
    /// That of colours, times the root of the extinction: the root of the mean square.
    noise: f64,
    /// By how much colours differ from one cell to the next, times the lesser extinction: the root of the
    /// mean square.
    step_noise: f64,
    /// The same, averaged over blocks of 2×2 pairs: the largest.
    contrast: f64,
}

impl OfBrick {
    fn new(
        (cells, side): (&BTreeMap<[usize; 3], Sums>, usize),
        (grid, brick): (&Grid, [usize; 3]),
        coords: &[[usize; 3]],
        light: &OfLight,
    ) -> Self {
        // Of the extinction of all voxels of a cell, what one has.
        let per_voxel = (side as f64).powi(-3);
        let most = coords.iter().map(|at| cells[at].extinction).fold(0.0, f64::max);
        let n_bricks = grid.dims().map(|n| n.div_ceil(8));
        let is_at_end = (0..3).any(|axis| [1, n_bricks[axis]].contains(&(brick[axis] + 1)));
        let mut of_brick = Self {
            extinction: per_voxel * most,
            step_noise: per_voxel * step_noise(cells, brick),
            contrast: per_voxel * contrast(cells, brick),
            ..Self::default()
        };
        if is_at_end {
            of_brick.spread_of_extinction = 0.5 * of_brick.extinction;
        }
        let per_voxel_of_block = per_voxel / 8.0;
        let (mut squares, mut n_blocks) = (0.0, 0.0);
        for block in blocks(cells, brick) {
            let mu = per_voxel_of_block * block.extinction;
            let of_extinction = (per_voxel_of_block * block.square - mu * mu).max(0.0).sqrt();
            of_brick.spread = of_brick.spread.max(mu * light.spread(&block));
            of_brick.spread_of_extinction = of_brick.spread_of_extinction.max(of_extinction);
            squares += mu * block.variance_of_colors().max(0.0);
            n_blocks += 1.0;
        }
        of_brick.noise = (squares / f64::max(n_blocks, 1.0)).sqrt();
        of_brick
    }

    pub(super) fn is_even(&self, tolerance: f64, depth_of_voxels: f64, light: &OfLight) -> bool {
        let in_depth = 2.5 * tolerance / depth_of_voxels;
        let is_alike = self.spread <= in_depth && self.spread_of_extinction <= in_depth;
        let is_calm = light.colors * self.noise <= 2.0 * tolerance
            && light.colors * self.contrast <= 4.0 * tolerance * self.extinction;
        self.extinction <= (14.0 * tolerance / light.normals).powi(2)
            && (0.5 * self.extinction <= in_depth || is_alike)
            && (0.5 * depth_of_voxels * self.step_noise <= tolerance / 20.0 || is_calm)
    }
}

/// What decides of each brick of cells of `side³` voxels, on that grid.
pub(super) fn bricks(
    (voxels, side): (&[Voxel], usize),
    grid: &Grid,
    light: &OfLight,
) -> BTreeMap<[usize; 3], OfBrick> {
    let cells = sums(voxels, side);
    let mut bricks: BTreeMap<[usize; 3], Vec<[usize; 3]>> = BTreeMap::new();
    for coords in cells.keys() {
        bricks.entry(coords.map(|at| at / 8)).or_default().push(*coords);
    }
    let of_brick = |(brick, coords): ([usize; 3], Vec<[usize; 3]>)| {
        (brick, OfBrick::new((&cells, side), (grid, brick), &coords, light))
    };
    bricks.into_iter().map(of_brick).collect()
}

/// Where the cells of a brick lie, if they are there.
fn places(brick: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..512).map(move |idx| [0, 1, 2].map(|axis| 8 * brick[axis] + idx / [1, 8, 64][axis] % 8))
}

/// The next place along an axis, if it is in the same brick.
fn next_in_brick(at: [usize; 3], axis: usize) -> Option<[usize; 3]> {
    let mut next = at;
    next[axis] += 1;
    (!next[axis].is_multiple_of(8)).then_some(next)
}

/// By how much colours of cells side by side differ, pair by pair along an axis: the place of the first, and
/// the difference times the lesser extinction.
fn steps(
    cells: &BTreeMap<[usize; 3], Sums>,
    brick: [usize; 3],
    axis: usize,
) -> impl Iterator<Item = ([usize; 3], [f64; 3])> {
    places(brick).filter_map(move |at| {
        let (a, b) = (cells.get(&at)?, cells.get(&next_in_brick(at, axis)?)?);
        Some((at, a.difference(b)))
    })
}

/// The root of the mean square of all steps of a brick, each in the channel in which it is largest.
fn step_noise(cells: &BTreeMap<[usize; 3], Sums>, brick: [usize; 3]) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for (_, step) in (0..3).flat_map(|axis| steps(cells, brick, axis)) {
        sum += step.into_iter().map(|channel| channel * channel).fold(0.0, f64::max);
        n += 1.0;
    }
    (sum / f64::max(n, 1.0)).sqrt()
}

/// Steps averaged over blocks of 2×2 pairs: the largest of a brick in any channel.
fn contrast(cells: &BTreeMap<[usize; 3], Sums>, brick: [usize; 3]) -> f64 {
    let mut most = 0.0_f64;
    for axis in 0..3 {
        let mut blocks: BTreeMap<[usize; 3], [f64; 3]> = BTreeMap::new();
        for (at, step) in steps(cells, brick, axis) {
            let mut block = at.map(|at| at / 2);
            block[axis] = at[axis];
            let sums = blocks.entry(block).or_default();
            sums.iter_mut().zip(step).for_each(|(sum, step)| *sum += step / 4.0);
        }
        most = blocks.values().flatten().fold(most, |most, mean| most.max(mean.abs()));
    }
    most
}

/// What blocks of 2³ cells of a brick have together, of all in which there is anything.
fn blocks(cells: &BTreeMap<[usize; 3], Sums>, brick: [usize; 3]) -> impl Iterator<Item = Sums> {
    places(brick).filter_map(move |at| {
        (0..3).all(|axis| next_in_brick(at, axis).is_some()).then_some(())?;
        let of_block = (0..8).map(|idx| [idx % 2, idx / 2 % 2, idx / 4]);
        let of_block = of_block.map(|by| [0, 1, 2].map(|axis| at[axis] + by[axis]));
        let there = of_block.filter_map(|cell| cells.get(&cell));
        Some(there.fold(Sums::default(), Sums::and)).filter(|block| 0.0 < block.extinction)
    })
}

/// By how much lit colours differ at most.
pub(super) struct OfLight {
    /// Where colours do by 1.
    colors: f64,
    /// Where normals do by 1.
    pub(super) normals: f64,
    /// Standard deviations where directions differ most: of highlights, and of diffuse light on white.
    highlights: f64,
    diffuse: f64,
}

impl OfLight {
    pub(super) fn new(shading: &Shading, lights: &[Light]) -> Self {
        let Shading::Phong(phong) = shading else {
            return Self { colors: 1.0, normals: 0.0, highlights: 0.0, diffuse: 0.0 };
        };
        let colors = lights.iter().map(|light| DVec3::from(light.color));
        let in_all = colors.sum::<DVec3>().max_element();
        let [diffuse, specular] = [in_all * phong.diffuse, in_all * phong.specular];
        let of_directions = if phong.two_sided { 1.0 / 3.0 } else { 0.41 };
        Self {
            colors: (phong.ambient + diffuse).max(1.0),
            normals: diffuse + specular,
            highlights: of_directions * specular,
            diffuse: of_directions * diffuse,
        }
    }

    /// The standard deviation of lit colours among some voxels.
    fn spread(&self, sums: &Sums) -> f64 {
        let brightest = sums.color().into_iter().fold(0.0, f64::max);
        let of_light = self.highlights + self.diffuse * brightest;
        let of_directions = sums.variance_of_directions().max(0.0).sqrt();
        let of_colors = self.colors * sums.variance_of_colors().max(0.0).sqrt();
        of_colors.hypot(of_light * of_directions)
    }
}
