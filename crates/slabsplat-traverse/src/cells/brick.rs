//! A brick of cells.

use super::moments::Moments;
use super::record::{CellRecord, CellValues};
use super::sums::{CellSums, MomentSums, N_SLOTS};
use crate::{BRICK_SIDE, VoxelRecord};

/// A brick of 8³ cells, of which some hold relevant voxels.
#[derive(Clone, Debug)]
pub struct CellBrick {
    /// A bit a slot.
    is_there: [u64; N_SLOTS / 64],
    /// For each of these words, how many there are in those before it.
    n_before: [u16; N_SLOTS / 64],
    /// Those that are there, in the order of slots.
    cells: Box<[CellRecord]>,
    /// As many, or none.
    moments: Box<[Moments]>,
    largest: f32,
    per_voxel: f32,
    n_voxels: u32,
    contrast: [f32; 2],
    spread: Spread,
    step_noise: f32,
}

/// How unlike voxels are that a pixel sees at once, whatever their order: standard deviations within blocks
/// of 2³ cells, the most of any block unless said otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Spread {
    /// Of colours in the channel in which it is largest, times the mean extinction per voxel.
    color: f32,
    /// Of what light makes of directions, over the most that it makes of any, times the same.
    direction: f32,
    /// The same times the mean colour, in its brightest channel.
    lit_color: f32,
    /// Of extinction per voxel.
    extinction: f32,
    /// Of colours, times the root of the extinction: the root of the mean of squares.
    noise: f32,
}

impl CellBrick {
    /// The brick of those sums, which are of so many voxels; if it is at an end of its grid, there is nothing
    /// beside it.
    pub(super) fn new(sums: &CellSums, level: u32, n_voxels: u32, is_at_end: bool) -> Self {
        let mut values = [CellValues::default(); N_SLOTS];
        let mut is_there = [0_u64; N_SLOTS / 64];
        let (mut n_cells, mut largest) = (0, 0.0_f32);
        for (slot, cell) in sums.cells(level) {
            values[slot] = cell;
            is_there[slot / 64] |= 1 << (slot % 64);
            n_cells += 1;
            largest = largest.max(cell.extinction);
        }
        let mut cells = Vec::with_capacity(n_cells);
        let are_there = (0..N_SLOTS).filter(|slot| is_there[slot / 64] >> (slot % 64) & 1 == 1);
        cells.extend(are_there.map(|slot| CellRecord::new(&values[slot], slot, largest)));
        // A cell's extinction is the sum of its voxels', over the voxels along an edge.
        let per_voxel = 1.0 / f32::from(1_u16 << (2 * level));
        let mut spread = Spread::of(sums, level);
        if is_at_end {
            spread.extinction = spread.extinction.max(0.5 * largest * per_voxel);
        }
        let mut n_before = [0; N_SLOTS / 64];
        for word in 1..n_before.len() {
            n_before[word] = n_before[word - 1] + is_there[word - 1].count_ones() as u16;
        }
        Self {
            is_there,
            n_before,
            cells: cells.into_boxed_slice(),
            moments: Box::default(),
            largest,
            per_voxel,
            n_voxels,
            contrast: contrast(&values, level),
            spread,
            step_noise: per_voxel * noise(&values),
        }
    }

    /// The same with second moments.
    pub(super) fn with_moments(self, sums: &CellSums, moments: &MomentSums) -> Self {
        let of_cell = |record: VoxelRecord| {
            let slot = usize::from(record.slot);
            moments.of_cell(slot, sums.extinction(slot))
        };
        let moments = self.slots().map(of_cell).collect();
        Self { moments, ..self }
    }

    /// The slots of the cells that are there, as voxels without normals, in memory order.
    pub fn slots(&self) -> impl Iterator<Item = VoxelRecord> {
        (0_u16..).zip(self.is_there).flat_map(|(word, bits)| {
            let next = |left: &u64| Some(left & left.wrapping_sub(1)).filter(|left| *left != 0);
            let all_left = std::iter::successors(Some(bits).filter(|bits| *bits != 0), next);
            all_left.map(move |left| VoxelRecord {
                slot: 64 * word + left.trailing_zeros() as u16,
                ..VoxelRecord::default()
            })
        })
    }

    /// Which of [`cells`](Self::cells) is in a slot that has one.
    #[inline(always)]
    pub(super) fn idx_of(&self, slot: u16) -> usize {
        let word = usize::from(slot / 64);
        let before = self.is_there[word] & ((1 << (slot % 64)) - 1);
        usize::from(self.n_before[word]) + before.count_ones() as usize
    }

    /// The cells in these slots.
    pub fn cells(&self) -> &[CellRecord] {
        &self.cells
    }

    /// The second moments of their normals, where light needs these.
    pub fn moments(&self) -> &[Moments] {
        &self.moments
    }

    /// The largest extinction of any cell, by which they are stored.
    pub fn largest(&self) -> f32 {
        self.largest
    }

    /// The same per voxel step: the largest mean of a cell's voxels.
    pub fn largest_of_voxels(&self) -> f32 {
        self.largest * self.per_voxel
    }

    /// Relevant voxels in it.
    pub fn n_voxels(&self) -> u64 {
        self.n_voxels.into()
    }

    /// How much layers of cells that follow each other differ, as a pixel sees them: differences times the
    /// lesser extinction per voxel, averaged over 2×2 pairs, the largest in the brick. Noise averages out
    /// there as it does in a picture. Of colours, in the channel in which they differ most; and of normals,
    /// and of what has none.
    pub fn contrast(&self) -> [f32; 2] {
        self.contrast
    }

    /// How unlike voxels are that a pixel sees at once, whatever their order: standard deviations within
    /// blocks of 2³ cells, times the mean extinction per voxel, the largest in the brick. Of colours, in the
    /// channel in which it is largest; of what light makes of directions, over the most that it makes of any;
    /// and the second times the mean colour, in its brightest channel.
    pub fn spread(&self) -> [f32; 3] {
        let Spread { color, direction, lit_color, .. } = self.spread;
        [color, direction, lit_color]
    }

    /// The same of extinction per voxel, which at an end of the grid is 0 beyond it.
    pub fn spread_of_extinction(&self) -> f32 {
        self.spread.extinction
    }

    /// Of colours, the root of the mean of squares over the brick: of voxels in such blocks, times the root
    /// of the extinction; and of steps from one cell to the next, times the lesser extinction.
    pub fn noise(&self) -> [f32; 2] {
        [self.spread.noise, self.step_noise]
    }

    /// Bytes held, with itself.
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.cells) + size_of_val(&*self.moments)
    }
}

/// Pairs of cells across a gap between layers, along either axis, whose differences are averaged: what a
/// pixel sees at once where cells are as wide as footprints.
const BLOCK_SIDE: usize = 2;

/// Blocks across a brick, and gaps between its layers.
const N_BLOCKS: usize = BRICK_SIDE / BLOCK_SIDE;
const N_GAPS: usize = BRICK_SIDE - 1;

/// Differences of red, green, blue, of the normal, and of what has none.
type Difference = [f32; 7];

/// Of colours and of normals.
fn contrast(values: &[CellValues; N_SLOTS], level: u32) -> [f32; 2] {
    let per_block = 1.0 / (BLOCK_SIDE * BLOCK_SIDE) as f32 / f32::from(1_u16 << (2 * level));
    let [mut color, mut normal] = [0.0_f32; 2];
    for strides in [[1, 8, 64], [8, 64, 1], [64, 1, 8]] {
        for sum in differences(values, strides).as_flattened().as_flattened() {
            let [r, g, b, x, y, z, undirected] = sum.map(|sum| per_block * sum);
            let length = (x * x + y * y + z * z).sqrt();
            color = color.max(r.abs()).max(g.abs()).max(b.abs());
            normal = normal.max(length + undirected.abs());
        }
    }
    [color, normal]
}

impl Spread {
    fn of(sums: &CellSums, level: u32) -> Self {
        let mut most = Self::default();
        let (mut squares, mut n_blocks) = (0.0, 0_u16);
        for (mu, [r, g, b, x, y, z, undirected, rr, gg, bb, mean_mu]) in sums.blocks(level) {
            let variances = [rr - r * r, gg - g * g, bb - b * b];
            let variance = variances.into_iter().fold(0.0, f32::max);
            let mean_length = (x * x + y * y + z * z).sqrt();
            let of_directions = mu * variance_of_light(mean_length, undirected).sqrt();
            most.color = most.color.max(mu * variance.sqrt());
            most.direction = most.direction.max(of_directions);
            most.lit_color = most.lit_color.max(of_directions * r.max(g).max(b));
            most.extinction = most.extinction.max((mu * (mean_mu - mu)).max(0.0).sqrt());
            squares += mu * variance;
            n_blocks += 1;
        }
        most.noise = (squares / f32::from(n_blocks.max(1))).sqrt();
        most
    }
}

/// The variance of what light makes of directions whose mean has that length, over the most that it makes of
/// any, which is of a mean length of ½. Those without a direction may be lit as any of the others.
fn variance_of_light(mean_length: f32, undirected: f32) -> f32 {
    let directed = (1.0 - undirected).max(mean_length).min(1.0);
    let alike = mean_length / directed.max(f32::MIN_POSITIVE);
    let square = (alike * alike).min(1.0);
    let among_directed = ((1.0 - square) * (0.75 + 2.7 * square)).min(1.0);
    directed * among_directed + 9.0 * directed * (1.0 - directed)
}

/// How much colours of cells side by side differ in the channel in which they differ most, times the lesser
/// extinction: the root of the mean square.
fn noise(values: &[CellValues; N_SLOTS]) -> f32 {
    let (mut squares, mut n_pairs) = (0.0, 0_u16);
    for (axis, stride) in (0..).zip([1, BRICK_SIDE, BRICK_SIDE * BRICK_SIDE]) {
        for slot in 0..N_SLOTS - stride {
            let [a, b] = [&values[slot], &values[slot + stride]];
            let both = a.extinction.min(b.extinction);
            let is_last = slot / BRICK_SIDE.pow(axis) % BRICK_SIDE == BRICK_SIDE - 1;
            if !is_last && 0.0 < both {
                let pairs = a.color.iter().zip(b.color);
                let most = pairs.fold(0.0, |most: f32, (a, b)| most.max((a - b).abs()));
                squares += (both * most).powi(2);
                n_pairs += 1;
            }
        }
    }
    (squares / f32::from(n_pairs.max(1))).sqrt()
}

/// The sums of differences over blocks of pairs, where cells of a pair lie `across` slots from each other.
fn differences(
    values: &[CellValues; N_SLOTS],
    [across, along, up]: [usize; 3],
) -> [[[Difference; N_BLOCKS]; N_BLOCKS]; N_GAPS] {
    let mut sums = [[[[0.0; 7]; N_BLOCKS]; N_BLOCKS]; N_GAPS];
    for k in 0..BRICK_SIDE {
        for j in 0..BRICK_SIDE {
            for (gap, sums) in sums.iter_mut().enumerate() {
                let first = gap * across + j * along + k * up;
                let [a, b] = [&values[first], &values[first + across]];
                let sum = &mut sums[k / BLOCK_SIDE][j / BLOCK_SIDE];
                let both = a.extinction.min(b.extinction);
                for (sum, (a, b)) in sum.iter_mut().zip(a.looks().into_iter().zip(b.looks())) {
                    *sum += both * (a - b);
                }
            }
        }
    }
    sums
}

impl CellValues {
    /// All that decides how a cell looks but how opaque it is.
    #[inline(always)]
    fn looks(&self) -> Difference {
        let Self { color: [r, g, b], normal: [x, y, z], undirected, .. } = *self;
        [r, g, b, x, y, z, undirected]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NORMAL_STEPS;

    /// Voxels of opaque black before white, in the first 4³ voxels of a brick: 2³ cells of level 1.
    fn halves(is_at_end: bool) -> CellBrick {
        let (mut sums, mut moments) = (CellSums::default(), MomentSums::default());
        sums.clear();
        moments.clear();
        let toward_x = [NORMAL_STEPS as i16, 0, 0];
        let at = (0..64).map(|idx| [idx % 4, idx / 4 % 4, idx / 16]);
        let records: Vec<_> = at
            .map(|[x, y, z]: [u16; 3]| VoxelRecord { slot: (z * 8 + y) * 8 + x, normal: toward_x })
            .collect();
        let color = |record: &VoxelRecord| {
            let gray = if record.coords_in_brick()[0] < 2 { 0.0 } else { 1.0 };
            [gray, gray, gray, 0.3]
        };
        let colors: Vec<_> = records.iter().map(color).collect();
        sums.add(1, [0; 3], &records, &colors);
        moments.add(1, [0; 3], &records, &colors);
        CellBrick::new(&sums, 1, 64, is_at_end).with_moments(&sums, &moments)
    }

    #[test]
    fn cell_brick_holds_its_cells() {
        let brick = halves(false);
        let slots: Vec<_> = brick.slots().map(|record| record.slot).collect();
        assert_eq!(slots, [0, 1, 8, 9, 64, 65, 72, 73]);
        assert_eq!((brick.cells().len(), brick.moments().len(), brick.n_voxels()), (8, 8, 64));
        // Eight voxels of 0.3, over two along an edge.
        assert!(
            (brick.largest() - 1.2).abs() < 1e-6 && (brick.largest_of_voxels() - 0.3).abs() < 1e-6
        );
    }

    /// From one cell to the next colours differ by 1 along x alone, in each of 2×2 pairs.
    #[test]
    fn cell_brick_knows_its_contrast() {
        let [color, normal] = halves(false).contrast();
        assert!((color - 0.3).abs() < 1e-6, "{color}");
        assert_eq!(normal, 0.0, "all face one way");
    }

    /// Blocks have all colours, or those of one half, beside what is empty or not.
    #[test]
    fn cell_brick_knows_its_spread() {
        let brick = halves(false);
        let ([color, direction, _], [noise, step_noise]) = (brick.spread(), brick.noise());
        assert!((color - 0.3 * 0.5).abs() < 1e-6, "{color}");
        assert!(direction < 1e-3, "all face one way: {direction}");
        // Cells of 2³ in the first 2×2×2 slots: eight blocks, the first of all colours, those beside it along
        // y, z and both of half as many voxels and as few again; the others are white.
        let squares: f32 = [1.0, 0.5, 0.5, 0.25].iter().map(|filled| 0.3 * filled * 0.25).sum();
        assert!((noise - (squares / 8.0).sqrt()).abs() < 1e-6, "{noise}");
        // Four of twelve pairs.
        assert!((step_noise - 0.3 * (4.0_f32 / 12.0).sqrt()).abs() < 1e-6, "{step_noise}");
        assert!((brick.spread_of_extinction() - 0.15).abs() < 1e-6, "a half is empty");
        assert!((halves(true).spread_of_extinction() - 0.15).abs() < 1e-6, "so is what is beyond");
    }

    /// `|n·l|` of directions `n` of von Mises–Fisher distributions around the z axis, from all alike likely
    /// to nearly one, for lights `l` at any angle to it: samples by the inverse of their distribution
    /// (Ulrich, "Computer Generation of Distributions on the m-Sphere", Applied Statistics 33(2), 1984).
    #[test]
    fn cell_brick_knows_how_much_light_differs() {
        const N: u16 = 60;
        let evenly = || (0..N).map(|idx| (f32::from(idx) + 0.5) / f32::from(N));
        for concentration in [0.01_f32, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0] {
            let mean_length = 1.0 / concentration.tanh() - 1.0 / concentration;
            let along =
                |u: f32| 1.0 + (u + (1.0 - u) * (-2.0 * concentration).exp()).ln() / concentration;
            let mut most = 0.0_f32;
            for angle in (0..=18_u8).map(|step| f32::from(step) * std::f32::consts::PI / 18.0) {
                let (mut sum, mut squares) = (0.0, 0.0);
                for z in evenly().map(along) {
                    let across = (1.0 - z * z).max(0.0).sqrt();
                    for turn in evenly() {
                        let x = across * (turn * std::f32::consts::TAU).cos();
                        let lit = (z * angle.cos() + x * angle.sin()).abs();
                        sum += lit;
                        squares += lit * lit;
                    }
                }
                let n = f32::from(N).powi(2);
                most = most.max((squares / n - (sum / n).powi(2)).max(0.0).sqrt());
            }
            let of_most = variance_of_light(mean_length, 0.0).sqrt();
            let share = most * 3.0 / of_most;
            assert!((0.8..1.07).contains(&share), "{mean_length}: {most} is {share} of it");
        }
        assert!((variance_of_light(0.0, 1.0), variance_of_light(1.0, 0.0)) == (0.0, 0.0));
    }
}
