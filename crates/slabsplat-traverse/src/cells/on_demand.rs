//! Bricks of voxels and of cells, each made when a frame first sees it, within a budget of memory.
//!
//! What has been made serves until values, rules or the transfer function change. Once the budget is spent, a
//! brick is made for the frame that asks and not retained; the frame after such a one first forgets what the
//! last one did not see, and voxels where cells had no room.

use super::brick::CellBrick;
use super::lazy_bricks::LazyBricks;
use super::retained::Retained;
use super::sums::{CellSums, MomentSums};
use crate::{BRICK_SIDE, Brick, BrickGrid, BrickLister, VoxelLighting, VoxelRecord};
use slabsplat_core::{FrameHandle, Grid};
use std::sync::OnceLock;

/// Levels of cells: a cell of the last has 8³ voxels, and a brick of those 64³.
pub const CELL_LEVELS: usize = 3;

/// Bricks of a volume by level, of voxels and of cells.
#[derive(Debug)]
pub struct BricksOnDemand {
    grids: [BrickGrid; CELL_LEVELS + 1],
    /// Those that may hold relevant voxels, by level, in memory order.
    may_hold: [OnceLock<Vec<u32>>; CELL_LEVELS + 1],
    voxels: LazyBricks<Box<[VoxelRecord]>>,
    cells: [LazyBricks<Box<CellBrick>>; CELL_LEVELS],
    n_voxels: u64,
    /// Bricks along each axis of the whole of which the volume is a part.
    n_in_whole: [[usize; 3]; CELL_LEVELS + 1],
    /// Counts up.
    frame: u32,
    retained: Retained,
}

/// What bricks are made of: of the same volume, values and rules as long as a [`BricksOnDemand`] lives.
#[derive(Clone, Copy, Debug)]
pub struct BrickMaker<'a> {
    /// Lists their voxels.
    pub lister: &'a BrickLister<'a>,
    /// Classifies them.
    pub lighting: &'a VoxelLighting<'a>,
    /// The mean extinction per voxel from which cells have second moments of normals.
    pub moments_from: f32,
    /// For which they are made. If it is cancelled, bricks may be made of less than they hold, and are not
    /// retained.
    pub frame: &'a FrameHandle,
}

/// What a thread needs to make bricks.
#[derive(Debug, Default)]
pub struct BrickRoom {
    records: Vec<VoxelRecord>,
    colors: Vec<[f32; 4]>,
    sums: CellSums,
    moments: MomentSums,
    /// Bricks of voxels whose moments are not among these.
    without_moments: Vec<u32>,
    /// What the budget has no room for.
    unretained: Option<CellBrick>,
}

impl BricksOnDemand {
    /// The bricks of a grid, of whose voxels so many are relevant; what is retained of them takes no more
    /// than that many bytes, and a few beside them that do not grow with it.
    pub fn new(grid: &Grid, n_voxels: u64, budget_bytes: usize) -> Self {
        // Where there are no cells, as their steps would be too long, nobody asks for them.
        let of_level = |level| {
            grid.of_cells(level).as_ref().map_or_else(|_| BrickGrid::default(), BrickGrid::new)
        };
        let grids = [0, 1, 2, 3].map(of_level);
        let whole = grid.whole().dims();
        let n_in_whole = [0, 1, 2, 3].map(|level| whole.map(|n| n.div_ceil(BRICK_SIDE << level)));
        Self {
            grids,
            n_in_whole,
            may_hold: Default::default(),
            voxels: LazyBricks::new(grids[0].n_bricks()),
            cells: [1, 2, 3].map(|level| LazyBricks::new(grids[level].n_bricks())),
            n_voxels,
            frame: 0,
            retained: Retained::new(budget_bytes),
        }
    }

    /// Relevant voxels in all.
    pub fn n_voxels(&self) -> u64 {
        self.n_voxels
    }

    /// Makes room for another frame, if the last one had not enough: what that did not ask for is forgotten,
    /// and all voxels if cells need their room.
    pub fn start_frame(&mut self) {
        let Self { frame, voxels, cells, retained, .. } = self;
        if retained.was_spent() {
            let mut forget_voxels_before =
                |frame| voxels.forget_before(frame, |records| size_of_val(&**records));
            retained.forget_voxels(forget_voxels_before(*frame));
            for of_level in cells {
                retained.forget_cells(of_level.forget_before(*frame, |brick| brick.bytes()));
            }
            if retained.make_room_for_cells() {
                retained.forget_voxels(forget_voxels_before(*frame + 1));
            }
        }
        self.frame += 1;
    }

    /// How a level is cut into bricks.
    pub fn grid(&self, level: u32) -> &BrickGrid {
        &self.grids[level as usize]
    }

    /// The bricks of a level that may hold relevant voxels, in memory order.
    pub fn may_hold(&self, level: u32, lister: &BrickLister<'_>) -> &[u32] {
        self.may_hold[level as usize].get_or_init(|| match level {
            0 => (0..self.grids[0].n_bricks() as u32).filter(|&idx| lister.may_hold(idx)).collect(),
            _ => {
                let mut may_hold = vec![false; self.grid(level).n_bricks()];
                for &child in self.may_hold(level - 1, lister) {
                    may_hold[self.parent(level - 1, child) as usize] = true;
                }
                (0..).zip(may_hold).filter_map(|(idx, may_hold)| may_hold.then_some(idx)).collect()
            }
        })
    }

    /// The brick of the next coarser level in which a brick lies.
    #[inline]
    pub fn parent(&self, level: u32, brick_idx: u32) -> u32 {
        let parent = self.grid(level).coords_in_whole(brick_idx).map(|at| at / 2..at / 2 + 1);
        let coarser = self.grid(level + 1);
        coarser.brick_idx(coarser.here(&parent).map(|range| range.start))
    }

    /// The bricks of the next finer level that lie in one, of which each may hold relevant voxels.
    pub fn children<'a>(
        &'a self,
        level: u32,
        brick_idx: u32,
        lister: &'a BrickLister<'_>,
    ) -> impl Iterator<Item = u32> + 'a {
        let all = self.may_hold(level - 1, lister);
        within(self.grid(level), self.grid(level - 1), brick_idx, 1)
            .filter(|child| all.binary_search(child).is_ok())
    }

    /// The voxels of a brick; `room` is where the budget has none.
    pub fn voxels<'a>(
        &'a self,
        maker: BrickMaker<'_>,
        brick_idx: u32,
        room: &'a mut Vec<VoxelRecord>,
    ) -> &'a [VoxelRecord] {
        if let Some(records) = self.voxels.get(brick_idx, self.frame) {
            return records;
        }
        room.clear();
        maker.lister.list(brick_idx, room);
        if self.retained.spends_on_voxels(size_of_val(&**room)) {
            return self.voxels.retain(brick_idx, self.frame, room.as_slice().into());
        }
        room
    }

    /// The cells of a brick, of level 1 … [`CELL_LEVELS`].
    pub fn cells<'a>(
        &'a self,
        maker: BrickMaker<'_>,
        level: u32,
        brick_idx: u32,
        room: &'a mut BrickRoom,
    ) -> &'a CellBrick {
        let of_level = &self.cells[level as usize - 1];
        if let Some(brick) = of_level.get(brick_idx, self.frame) {
            return brick;
        }
        let brick = self.made(maker, level, brick_idx, room);
        if !maker.frame.is_cancelled() && self.retained.spends_on_cells(brick.bytes()) {
            return of_level.retain(brick_idx, self.frame, Box::new(brick));
        }
        room.unretained.insert(brick)
    }

    /// A cell lies in one brick of voxels. Whether moments are needed is known once all sums are; they are
    /// made beside these wherever a voxel is so opaque that a cell may be, and later of the others.
    fn made(
        &self,
        maker: BrickMaker<'_>,
        level: u32,
        brick_idx: u32,
        BrickRoom { records, colors, sums, moments, without_moments, .. }: &mut BrickRoom,
    ) -> CellBrick {
        let mut n_voxels = 0;
        sums.clear();
        moments.clear();
        without_moments.clear();
        let children = within(self.grid(level), self.grid(0), brick_idx, level);
        self.for_each(maker, children, (records, colors), |child, records, colors| {
            let first = self.first_cell(level, brick_idx, child);
            sums.add(level, first, records, colors);
            n_voxels += records.len() as u32;
            if colors.iter().any(|[.., mu]| maker.moments_from < *mu) {
                moments.add(level, first, records, colors);
            } else {
                without_moments.push(child);
            }
        });
        let brick = CellBrick::new(sums, level, n_voxels, self.is_at_end(level, brick_idx));
        if brick.largest_of_voxels() <= maker.moments_from {
            return brick;
        }
        let others = without_moments.drain(..);
        self.for_each(maker, others, (records, colors), |child, records, colors| {
            moments.add(level, self.first_cell(level, brick_idx, child), records, colors);
        });
        brick.with_moments(sums, moments)
    }

    /// Whether a brick is the first or last along any axis.
    pub fn is_at_end(&self, level: u32, brick_idx: u32) -> bool {
        let at = self.grid(level).coords_in_whole(brick_idx);
        let n_along = self.n_in_whole[level as usize];
        at.iter().zip(n_along).any(|(&at, n)| at == 0 || at + 1 == n)
    }

    /// Where the first cell of a brick of voxels is in a brick of cells.
    fn first_cell(&self, level: u32, brick_idx: u32, child: u32) -> [usize; 3] {
        let first = self.grid(level).coords_in_whole(brick_idx).map(|at| at << level);
        let at = self.grid(0).coords_in_whole(child);
        [0, 1, 2].map(|axis| (at[axis] - first[axis]) * (BRICK_SIDE >> level))
    }

    /// Calls `with` for each of some bricks of voxels that holds any: its voxels, and these classified. If
    /// the frame is cancelled it does not go on.
    fn for_each(
        &self,
        BrickMaker { lister, lighting, frame, .. }: BrickMaker<'_>,
        bricks: impl Iterator<Item = u32>,
        (records, colors): (&mut Vec<VoxelRecord>, &mut Vec<[f32; 4]>),
        mut with: impl FnMut(u32, &[VoxelRecord], &[[f32; 4]]),
    ) {
        for brick_idx in bricks {
            if frame.is_cancelled() {
                break;
            }
            records.clear();
            lister.list(brick_idx, records);
            if !records.is_empty() {
                colors.resize(records.len(), [0.0; 4]);
                let brick = Brick { brick_idx, first: 0, n_voxels: records.len() as u16 };
                lighting.classify_brick(&brick, records, colors);
                with(brick_idx, records, colors);
            }
        }
    }

    /// Bytes held.
    pub fn resident_bytes(&self) -> usize {
        let of_cells: usize = self.cells.iter().map(LazyBricks::resident_bytes).sum();
        let lists = self.may_hold.iter().filter_map(OnceLock::get).map(|list| list.capacity() * 4);
        self.retained.bytes() + self.voxels.resident_bytes() + of_cells + lists.sum::<usize>()
    }
}

/// The bricks of a level that lie in a brick of one that is so many levels coarser, in memory order.
fn within(
    coarse: &BrickGrid,
    fine: &BrickGrid,
    brick_idx: u32,
    n_levels: u32,
) -> impl Iterator<Item = u32> + use<> {
    let fine = *fine;
    let in_whole = coarse.coords_in_whole(brick_idx);
    let [xs, ys, zs] = fine.here(&in_whole.map(|at| at << n_levels..(at + 1) << n_levels));
    let rows = zs.flat_map(move |z| ys.clone().map(move |y| (y, z)));
    rows.flat_map(move |(y, z)| xs.clone().map(move |x| fine.brick_idx([x, y, z])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{random_ranges, random_volume};
    use crate::{BrickRanges, Classification, RelevantList, VoxelRules};
    use slabsplat_core::{Compositing, IsoRange, Scaling, TransferFunction, Volume};
    use slabsplat_seeds::for_each_seed;
    use std::ops::Range;

    /// Calls `check` with what makes the bricks of a volume, all in one colour.
    fn with_maker(volume: &Volume, ranges: &[IsoRange], check: impl FnOnce(BrickMaker<'_>, u64)) {
        let brick_ranges = BrickRanges::new(volume);
        let lister = BrickLister::new(volume, &brick_ranges, ranges, None);
        let transfer =
            TransferFunction::new(vec![(0.0, [0.01]), (255.0, [0.9])], vec![(0.0, [0.5; 3])]);
        let transfer = transfer.expect("the points rise");
        let rules = VoxelRules::by_value(&transfer);
        let classification = Classification::new(&rules, Compositing::Extinction, volume);
        let lighting = VoxelLighting::new(&classification, volume, rules, None);
        let frame = FrameHandle::new();
        let n_voxels = lister.count_all(&frame).expect("nobody cancels the frame");
        let (lister, lighting, frame) = (&lister, &lighting, &frame);
        check(BrickMaker { lister, lighting, moments_from: 0.2, frame }, n_voxels);
    }

    /// Extinction times voxels, and voxels, of all bricks of a level.
    fn sums(bricks: &BricksOnDemand, maker: BrickMaker<'_>, level: u32) -> (f64, u64) {
        let (mut extinction, mut n_voxels, mut room) = (0.0, 0, BrickRoom::default());
        let side = f64::from(1 << level);
        for &brick_idx in bricks.may_hold(level, maker.lister) {
            let brick = bricks.cells(maker, level, brick_idx, &mut room);
            let values = brick.cells().iter().map(|cell| cell.values(brick.largest()).extinction);
            extinction += side * values.map(f64::from).sum::<f64>();
            n_voxels += brick.n_voxels();
            assert_eq!(brick.slots().count(), brick.cells().len());
            let n_moments = if 0.2 < brick.largest_of_voxels() { brick.cells().len() } else { 0 };
            assert_eq!(brick.moments().len(), n_moments);
        }
        (extinction, n_voxels)
    }

    #[test]
    fn on_demand_conserves_extinction_at_all_levels() {
        for_each_seed(1, |mut rng| {
            for _ in 0..5 {
                let volume = random_volume(&mut rng);
                let ranges = random_ranges(&mut rng, &volume);
                with_maker(&volume, &ranges, |maker, n_voxels| {
                    let bricks = BricksOnDemand::new(volume.grid(), n_voxels, 1 << 30);
                    let of_levels = [1, 2, 3].map(|level| sums(&bricks, maker, level));
                    let of_voxels = voxel_sum(&bricks, maker);
                    for (extinction, n_of_level) in of_levels {
                        assert_eq!(n_of_level, n_voxels);
                        let off = (extinction - of_voxels).abs() / of_voxels.max(1e-9);
                        assert!(off < 0.02, "{extinction} of {of_voxels}");
                    }
                });
            }
        });
    }

    fn voxel_sum(bricks: &BricksOnDemand, maker: BrickMaker<'_>) -> f64 {
        let (mut sum, mut room) = (0.0, Vec::new());
        for &brick_idx in bricks.may_hold(0, maker.lister) {
            let records = bricks.voxels(maker, brick_idx, &mut room);
            let brick = Brick { brick_idx, first: 0, n_voxels: records.len() as u16 };
            let mut colors = vec![[0.0; 4]; records.len()];
            maker.lighting.classify_brick(&brick, records, &mut colors);
            sum += colors.iter().map(|color| f64::from(color[3])).sum::<f64>();
        }
        sum
    }

    #[test]
    fn on_demand_lists_what_the_list_has() {
        for_each_seed(1, |mut rng| {
            let volume = random_volume(&mut rng);
            let ranges = random_ranges(&mut rng, &volume);
            let mut list = RelevantList::default();
            list.update(&volume, &BrickRanges::new(&volume), &ranges, None);
            with_maker(&volume, &ranges, |maker, n_voxels| {
                let bricks = BricksOnDemand::new(volume.grid(), n_voxels, 1 << 30);
                assert_eq!(bricks.n_voxels(), list.len() as u64);
                let mut room = Vec::new();
                // Twice, as the second time they are retained.
                for _ in 0..2 {
                    let idxs = bricks.may_hold(0, maker.lister).iter();
                    let all: Vec<VoxelRecord> = idxs
                        .flat_map(|&idx| bricks.voxels(maker, idx, &mut room).to_vec())
                        .collect();
                    assert_eq!(all, list.records());
                }
            });
        });
    }

    #[test]
    fn on_demand_children_are_those_of_their_parent() {
        let grid = Grid::with_spacing([70, 33, 40], [1.0; 3]).unwrap();
        let samples = (0..grid.n_voxels()).map(|idx| (idx % 251) as u8).collect::<Vec<_>>();
        let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
        let ranges = [IsoRange { lo: 10.0, hi: 20.0 }];
        with_maker(&volume, &ranges, |maker, n_voxels| {
            let bricks = BricksOnDemand::new(&grid, n_voxels, 0);
            for level in [1, 2, 3] {
                let mut all: Vec<u32> = Vec::new();
                for &parent in bricks.may_hold(level, maker.lister) {
                    for child in bricks.children(level, parent, maker.lister) {
                        assert_eq!(bricks.parent(level - 1, child), parent);
                        all.push(child);
                    }
                }
                all.sort_unstable();
                assert_eq!(all, bricks.may_hold(level - 1, maker.lister));
            }
        });
    }

    #[test]
    fn on_demand_keeps_to_its_budget() {
        let grid = Grid::with_spacing([64; 3], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, vec![9_u8; 1 << 18].into(), Scaling::IDENTITY).unwrap();
        let ranges = [IsoRange { lo: 0.0, hi: 20.0 }];
        with_maker(&volume, &ranges, |maker, n_voxels| {
            // A brick of voxels takes 4 KiB, and one of cells a little more.
            let mut bricks = BricksOnDemand::new(&grid, n_voxels, 100 << 10);
            let retained = |bricks: &BricksOnDemand| bricks.retained.bytes();
            let read = |bricks: &BricksOnDemand, voxels: Range<u32>, cells: Range<u32>| {
                let (mut room, mut records) = (BrickRoom::default(), Vec::new());
                for idx in voxels {
                    assert_eq!(bricks.voxels(maker, idx, &mut records).len(), 512);
                }
                for idx in cells {
                    assert_eq!(bricks.cells(maker, 1, idx, &mut room).cells().len(), 512);
                }
            };
            bricks.start_frame();
            read(&bricks, 0..512, 0..64);
            let of_all = retained(&bricks);
            assert!((90 << 10..=100 << 10).contains(&of_all), "{of_all}");
            bricks.start_frame();
            assert_eq!(retained(&bricks), 0, "cells had no room beside voxels");
            read(&bricks, 0..512, 0..64);
            let of_cells = retained(&bricks);
            assert!((90 << 10..=100 << 10).contains(&of_cells), "{of_cells}");
            bricks.start_frame();
            assert_eq!(retained(&bricks), of_cells, "the last frame saw them");
            read(&bricks, 100..101, 40..43);
            assert_eq!(retained(&bricks), of_cells, "there was no room");
            bricks.start_frame();
            assert_eq!(retained(&bricks), 0, "nobody has asked for them any more");
            read(&bricks, 100..101, 7..10);
            let of_some = retained(&bricks);
            assert!((16 << 10..20 << 10).contains(&of_some), "{of_some}");
            bricks.start_frame();
            assert_eq!(retained(&bricks), of_some);
        });
    }
}
