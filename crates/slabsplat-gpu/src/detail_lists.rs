//! A layer where pixels are larger than voxels (model §16): bricks of voxels and of cells, which the host
//! makes as the CPU backend does, and the records that it sends of them.
//!
//! ```text
//! from the coarsest level on:
//!     bricks whose turn has come, but not that of their parents, are made, and listed if they may be drawn
//!     of those that may not, the children are looked at with the next level's
//! ```
//!
//! The lists of all levels are made together and are as many layers to the device. A camera that turns leaves
//! them as they are: rays of a perspective view count as long as the shortest that could meet the volume,
//! however it is turned, and turns of bricks are rounded to a sixteenth of all.

use crate::cells_to_list::{CellsToList, cells_to_list};
use crate::host_list::{RecordPiece, VOXELS_PER_PIECE, fill_brick, rules_of};
use crate::known_volume::KnownVolume;
use crate::params::CellRecord;
use slabsplat_backend::{FramePlan, LayerPlan};
use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Cancelled, Compositing, FrameHandle, IsoRange, Region, RegionInView, StageError,
};
use slabsplat_kernel::CellDifferences;
use slabsplat_traverse::{
    Brick, BrickBounds, BrickGrid, BrickLister, BrickMaker, BrickRoom, BrickView, BricksOnDemand,
    CellBrick, Classification, OwnVoxelRules, VoxelLighting, VoxelRecord, map_for_frame,
};
use std::sync::Arc;

/// Voxels and cells of a layer, level by level, and what they were listed by.
#[derive(Debug)]
pub(crate) struct DetailLists {
    known: Arc<KnownVolume>,
    rules: OwnVoxelRules,
    compositing: Compositing,
    ranges: Vec<IsoRange>,
    /// What decides which bricks of cells are listed, from level 1 on; and near whose faces none is.
    cells: Vec<CellsToList>,
    lit_region: Option<Region>,
    bricks: BricksOnDemand,
    /// Voxels first.
    levels: Vec<LevelList>,
}

#[derive(Debug, Default)]
struct LevelList {
    /// In memory order.
    bricks: Vec<ListedBrick>,
    n_records: u64,
    n_voxels: u64,
}

#[derive(Clone, Copy, Debug)]
struct ListedBrick {
    brick_idx: u32,
    /// The number of its first record among those of the level.
    first: u64,
}

impl DetailLists {
    /// Lists the voxels and cells of a layer of a plan.
    pub(crate) fn new(
        plan: &FramePlan<'_>,
        layer: &LayerPlan<'_>,
        known: &Arc<KnownVolume>,
        frame: &FrameHandle,
    ) -> Result<Self, StageError> {
        let (known, rules) = (known.clone(), OwnVoxelRules::new(&rules_of(layer)));
        let (compositing, ranges) = (plan.compositing, layer.relevant.clone());
        // All that is made is listed, but for what may not be drawn.
        let bricks = BricksOnDemand::new(known.volume.grid(), 0, usize::MAX);
        let (cells, lit_region, levels) = (cells_to_list(layer), lit_region(layer), Vec::new());
        let mut lists =
            Self { known, rules, compositing, ranges, cells, lit_region, bricks, levels };
        let faces = LitBricks::new(layer);
        lists.levels = lists.with_maker(frame, |maker| lists.listed(maker, &faces))?;
        // A brick that was made of less than it holds is not retained, but may have been counted.
        frame.check()?;
        Ok(lists)
    }

    /// Whether they are those of a layer of a plan.
    pub(crate) fn are_of(&self, plan: &FramePlan<'_>, layer: &LayerPlan<'_>) -> bool {
        Arc::ptr_eq(&self.known.volume, layer.volume)
            && self.compositing == plan.compositing
            && self.ranges == layer.relevant
            && self.cells == cells_to_list(layer)
            && self.lit_region == lit_region(layer)
            && self.rules.rules() == rules_of(layer)
    }

    /// Voxels, or cells of a level.
    pub(crate) fn n_records(&self, level: usize) -> u64 {
        self.levels[level].n_records
    }

    /// Relevant voxels that those are, or stand for.
    pub(crate) fn n_voxels(&self, level: usize) -> u64 {
        self.levels[level].n_voxels
    }

    /// The levels of which there are any.
    pub(crate) fn filled_levels(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.levels.len()).filter(|level| self.n_records(*level) != 0)
    }

    /// Calls `send` with the records of all voxels, or of all cells of a level, made piece by piece for a
    /// frame.
    pub(crate) fn for_each_piece<E: From<Cancelled>>(
        &self,
        level: usize,
        frame: &FrameHandle,
        mut send: impl FnMut(RecordPiece) -> Result<(), E>,
    ) -> Result<(), E> {
        let is_same_piece = |a: &ListedBrick, b: &ListedBrick| {
            a.first / u64::from(VOXELS_PER_PIECE) == b.first / u64::from(VOXELS_PER_PIECE)
        };
        let mut pieces = self.levels[level].bricks.chunk_by(is_same_piece);
        self.with_maker(frame, |maker| {
            pieces.try_for_each(|bricks| {
                let records = map_for_frame(bricks, frame, |room: &mut Room, brick| {
                    self.records(maker, level, brick.brick_idx, room)
                })?;
                send(RecordPiece { first: bricks[0].first, records: records.concat() })
            })
        })
    }

    fn with_maker<T>(&self, frame: &FrameHandle, with: impl FnOnce(BrickMaker<'_>) -> T) -> T {
        let (volume, rules) = (&*self.known.volume, self.rules.rules());
        let decide = (!rules.are_by_value()).then_some(&rules);
        let lister = &BrickLister::new(volume, self.known.brick_ranges(), &self.ranges, decide);
        let classification = Classification::new(&rules, self.compositing, volume);
        let lighting = &VoxelLighting::new(&classification, volume, rules, None);
        let moments_from = self.cells.first().map_or(f64::INFINITY, |of| of.limits.by_mean_normals);
        with(BrickMaker { lister, lighting, moments_from: moments_from as f32, frame })
    }

    fn listed(
        &self,
        maker: BrickMaker<'_>,
        faces: &LitBricks<'_>,
    ) -> Result<Vec<LevelList>, Cancelled> {
        let mut levels: Vec<_> = (0..=self.cells.len()).map(|_| LevelList::default()).collect();
        let mut left = Vec::new();
        for (level, list) in levels.iter_mut().enumerate().rev() {
            let mut here = std::mem::take(&mut left);
            here.extend(self.own_bricks(level as u32, maker.lister));
            here.sort_unstable();
            let made = map_for_frame(&here, maker.frame, |room: &mut Room, brick_idx| {
                let is_lit = level != 0 && faces.may_light(level, *brick_idx);
                if is_lit { None } else { self.counts(maker, level, *brick_idx, room) }
            })?;
            for (brick_idx, counts) in here.into_iter().zip(made) {
                match counts {
                    Some(counts) => list.push(brick_idx, counts),
                    None => {
                        left.extend(self.bricks.children(level as u32, brick_idx, maker.lister));
                    }
                }
            }
        }
        Ok(levels)
    }

    /// The bricks that no coarser level has a turn of.
    fn own_bricks(&self, level: u32, lister: &BrickLister<'_>) -> Vec<u32> {
        let has_turn = |level: u32, brick_idx: u32| {
            let Some(idx) = (level as usize).checked_sub(1) else { return true };
            let is_at_end = self.bricks.is_at_end(level, brick_idx);
            let coords = self.bricks.grid(level).coords_in_whole(brick_idx);
            self.cells[idx].share.includes(coords, is_at_end)
        };
        let is_own = |brick_idx: &u32| {
            let parent = || self.bricks.parent(level, *brick_idx);
            let is_coarsest = self.cells.len() <= level as usize;
            has_turn(level, *brick_idx) && (is_coarsest || !has_turn(level + 1, parent()))
        };
        self.bricks.may_hold(level, lister).iter().copied().filter(is_own).collect()
    }

    /// How many records a brick has, and of how many voxels; nothing if its cells may not be drawn.
    fn counts(
        &self,
        maker: BrickMaker<'_>,
        level: usize,
        brick_idx: u32,
        room: &mut Room,
    ) -> Option<[u64; 2]> {
        let Some(idx) = level.checked_sub(1) else {
            let n_voxels = self.bricks.voxels(maker, brick_idx, &mut room.voxels).len() as u64;
            return Some([n_voxels; 2]);
        };
        let CellsToList { limits, lit, .. } = self.cells[idx];
        let cells = self.bricks.cells(maker, level as u32, brick_idx, &mut room.made);
        let differences = CellDifferences {
            contrast: cells.contrast(),
            spread: cells.spread(),
            spread_of_extinction: cells.spread_of_extinction(),
            noise: cells.noise(),
            extinction: cells.largest_of_voxels(),
        };
        limits.allow(lit, &differences).then(|| [cells.cells().len() as u64, cells.n_voxels()])
    }

    fn records(
        &self,
        maker: BrickMaker<'_>,
        level: usize,
        brick_idx: u32,
        room: &mut Room,
    ) -> Vec<[u32; 8]> {
        let grid = self.bricks.grid(level as u32);
        if level != 0 {
            let cells = self.bricks.cells(maker, level as u32, brick_idx, &mut room.made);
            return records_of_cells(cells, grid, brick_idx);
        }
        let voxels = self.bricks.voxels(maker, brick_idx, &mut room.voxels);
        let brick = Brick { brick_idx, first: 0, n_voxels: voxels.len() as u16 };
        let mut records = bytemuck::zeroed_vec(voxels.len());
        fill_brick(grid, &brick, voxels, maker.lighting, &mut records);
        bytemuck::cast_vec(records)
    }
}

/// Which bricks of cells may lie where the light of a lit face begins or ends, which cells would blur.
struct LitBricks<'a> {
    region: Option<&'a RegionInView>,
    unit: f64,
    levels: Vec<BrickView>,
}

impl<'a> LitBricks<'a> {
    fn new(layer: &'a LayerPlan<'_>) -> Self {
        let grid = layer.volume.grid();
        let seen =
            |plan: &LayerPlan<'_>| BrickView::of_cells(grid, plan.level, &plan.grid(), &plan.view);
        let region = layer.region.as_ref().filter(|region| region.is_lit());
        Self { region, unit: grid.unit(), levels: layer.levels().map(seen).collect() }
    }

    fn may_light(&self, level: usize, brick_idx: u32) -> bool {
        self.region.is_some_and(|region| {
            let brick = Brick { brick_idx, first: 0, n_voxels: 0 };
            let BrickBounds { center, half_extents } = self.levels[level].bounds(&brick);
            let [center, half_extents] =
                [center, half_extents].map(|v| DVec3::from_array(v.map(f64::from)));
            region.may_light(center, half_extents, self.unit)
        })
    }
}

fn lit_region(layer: &LayerPlan<'_>) -> Option<Region> {
    let region = layer.region.as_ref().filter(|region| region.is_lit());
    region.map(|region| region.in_world().clone())
}

/// What a thread needs to make bricks.
#[derive(Default)]
struct Room {
    voxels: Vec<VoxelRecord>,
    made: BrickRoom,
}

impl LevelList {
    fn push(&mut self, brick_idx: u32, [n_records, n_voxels]: [u64; 2]) {
        if n_records != 0 {
            self.bricks.push(ListedBrick { brick_idx, first: self.n_records });
        }
        self.n_records += n_records;
        self.n_voxels += n_voxels;
    }
}

fn records_of_cells(cells: &CellBrick, grid: &BrickGrid, brick_idx: u32) -> Vec<[u32; 8]> {
    let slots: Vec<_> = cells.slots().collect();
    let brick = Brick { brick_idx, first: 0, n_voxels: slots.len() as u16 };
    let idxs = grid.voxel_indices(&brick, &slots);
    let record = |(idx, (cell_idx, cell)): (usize, (usize, &slabsplat_traverse::CellRecord))| {
        let moments = cells.moments().get(idx).copied();
        bytemuck::cast(CellRecord::new(cell_idx, &cell.values(cells.largest()), moments))
    };
    idxs.zip(cells.cells()).enumerate().map(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_backend::Planner;
    use slabsplat_core::{
        Camera, Grid, ImageDesc, Layer, Plane, Projection, Scaling, Scene, TransferFunction, Volume,
    };
    use slabsplat_seeds::for_each_seed;

    /// Faint noise, of which a pixel covers some voxels.
    fn scene(rng: &mut fastrand::Rng, steps: [f64; 3]) -> Scene {
        let grid = Grid::with_spacing([40, 37, 33], steps).unwrap();
        let samples: Vec<u8> = (0..grid.n_voxels()).map(|_| rng.u8(..3)).collect();
        let volume = Volume::new(grid, samples.into(), Scaling::IDENTITY).unwrap();
        let opacity = vec![(0.0, [0.0]), (1.0, [0.004]), (2.0, [0.03])];
        let transfer = TransferFunction::new(opacity, vec![(0.0, [0.2; 3]), (2.0, [1.0; 3])]);
        let projection = match rng.bool() {
            true => Projection::Orthographic { view_height: 60.0 },
            false => Projection::Perspective { fov_y_radians: 0.2 },
        };
        let camera = Camera::new(DVec3::ONE, DVec3::ZERO, DVec3::Y, projection).unwrap();
        let scene = Scene::new(Layer::new(volume, transfer.unwrap()), camera);
        turned(scene.image(ImageDesc::new(20, 20)), 0.0)
    }

    fn turned(mut scene: Scene, degrees: f64) -> Scene {
        let target = scene.layers[0].volume.grid().center_in_world();
        let (sin, cos) = degrees.to_radians().sin_cos();
        let eye = target + 300.0 * DVec3::new(cos, 0.3, sin).normalize();
        scene.camera = Camera::new(eye, target, DVec3::Y, scene.camera.projection()).unwrap();
        scene
    }

    fn with_plan<T>(scene: &Scene, with: impl FnOnce(&FramePlan<'_>) -> T) -> T {
        let mut planner = Planner::default();
        planner.plan_cells(true);
        with(&planner.plan(scene).unwrap())
    }

    fn lists_of(scene: &Scene) -> DetailLists {
        let known = Arc::new(KnownVolume::new(scene.layers[0].volume.clone()));
        with_plan(scene, |plan| {
            DetailLists::new(plan, &plan.layers[0], &known, &FrameHandle::new()).unwrap()
        })
    }

    #[test]
    fn detail_lists_hold_every_voxel_once() {
        for_each_seed(5, |mut rng| {
            let scene = scene(&mut rng, [1.0; 3]);
            let lists = lists_of(&scene);
            let volume = &scene.layers[0].volume;
            let n_relevant = (0..volume.grid().n_voxels())
                .filter(|voxel_idx| volume.value(*voxel_idx) != 0.0)
                .count();
            let n_levels = lists.levels.len();
            assert!(1 < n_levels && lists.n_records(1) != 0, "nothing is drawn by cells");
            let n_voxels: u64 = (0..n_levels).map(|level| lists.n_voxels(level)).sum();
            assert_eq!(n_voxels, n_relevant as u64);
            for level in lists.filled_levels() {
                let mut n_records = 0;
                let send = |piece: RecordPiece| {
                    assert_eq!(piece.first, n_records);
                    n_records += piece.records.len() as u64;
                    Ok::<_, Cancelled>(())
                };
                lists.for_each_piece(level, &FrameHandle::new(), send).unwrap();
                assert_eq!(n_records, lists.n_records(level));
            }
        });
    }

    /// A list of millions is not sent in every frame of a turn.
    #[test]
    fn detail_lists_serve_while_a_camera_turns() {
        for_each_seed(3, |mut rng| {
            for z in [1.0, 1.3] {
                let scene = scene(&mut rng, [1.0, 1.0, z]);
                let lists = lists_of(&scene);
                let serve =
                    |scene: &Scene| with_plan(scene, |plan| lists.are_of(plan, &plan.layers[0]));
                for degrees in (0..360).step_by(25) {
                    assert!(serve(&turned(scene.clone(), f64::from(degrees))), "{degrees} degrees");
                }
                let with_cut = |cut: Region| {
                    let mut scene = scene.clone();
                    scene.layers[0].region = cut;
                    scene
                };
                let plane = Plane::new(DVec3::X, scene.layers[0].volume.grid().center_in_world().x);
                let cut = Region::new(vec![plane.unwrap()]);
                assert!(serve(&with_cut(cut.clone())), "a cut that is not lit");
                assert!(!serve(&with_cut(cut.clone().lit())), "voxels near its face");
                let lit = with_cut(cut.lit());
                assert!(lists_of(&lit).n_records(0) > lists.n_records(0));
                let mut brighter = scene;
                brighter.layers[0].transfer =
                    TransferFunction::new(vec![(0.0, [0.01])], vec![(0.0, [1.0; 3])]).unwrap();
                assert!(!serve(&brighter));
            }
        });
    }
}
