//! Relevant voxels that the host lists, as the CPU backend does, and the records that it sends of them.

use crate::known_volume::KnownVolume;
use crate::params::Record;
use slabsplat_backend::{FramePlan, LayerPlan};
use slabsplat_core::{Compositing, FrameHandle, StageError, Volume};
use slabsplat_traverse::{
    Brick, BrickGrid, Classification, OwnVoxelRules, RelevantList, VoxelLighting, VoxelRecord,
    VoxelRules,
};
use std::sync::Arc;

/// The relevant voxels of a layer, and what they were listed by.
#[derive(Debug)]
pub(crate) struct HostList {
    volume: Arc<Volume>,
    rules: OwnVoxelRules,
    compositing: Compositing,
    list: RelevantList,
}

/// What decides which voxels of a layer are relevant, and in which colour.
pub(crate) fn rules_of<'a>(layer: &LayerPlan<'a>) -> VoxelRules<'a> {
    let LayerPlan { transfer, transfer_2d, colors, labels, gradient_opacity, .. } = *layer;
    VoxelRules { transfer, transfer_2d, colors, labels, gradient_opacity }
}

/// Records of voxels, or of cells, that follow each other in a list.
#[derive(Debug)]
pub(crate) struct RecordPiece {
    /// The index of the first one in the list.
    pub(crate) first: u64,
    pub(crate) records: Vec<[u32; 8]>,
}

/// Voxels whose records are made at a time, but for those of one brick more: 8 MiB, so that sending them does
/// not cost a submission's time. All records of a list may take gigabytes.
pub(crate) const VOXELS_PER_PIECE: u32 = if cfg!(test) { 100 } else { 1 << 18 };

/// Voxels of a brick.
const MAX_VOXELS: usize = slabsplat_traverse::BRICK_SIDE.pow(3);

impl HostList {
    /// Lists the voxels of a layer of a plan.
    pub(crate) fn new(
        plan: &FramePlan<'_>,
        layer: &LayerPlan<'_>,
        known: &KnownVolume,
        frame: &FrameHandle,
    ) -> Result<Self, StageError> {
        let (volume, rules) = (layer.volume.clone(), rules_of(layer));
        let (bricks, ranges) = (known.brick_ranges(), &layer.relevant);
        let mut list = RelevantList::default();
        list.update_for_frame(&volume, bricks, ranges, Some(&rules), frame)?;
        Ok(Self { volume, rules: OwnVoxelRules::new(&rules), compositing: plan.compositing, list })
    }

    /// Whether it is that of a layer of a plan.
    pub(crate) fn is_of(&self, plan: &FramePlan<'_>, layer: &LayerPlan<'_>) -> bool {
        Arc::ptr_eq(&self.volume, layer.volume)
            && self.compositing == plan.compositing
            && self.list.ranges() == layer.relevant
            && self.rules.rules() == rules_of(layer)
    }

    pub(crate) fn n_voxels(&self) -> u64 {
        self.list.len() as u64
    }

    /// The records of all voxels, made piece by piece.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = RecordPiece> + '_ {
        let rules = self.rules.rules();
        let classification = Classification::new(&rules, self.compositing, &self.volume);
        let is_same_piece =
            |a: &Brick, b: &Brick| a.first / VOXELS_PER_PIECE == b.first / VOXELS_PER_PIECE;
        self.list.bricks().chunk_by(is_same_piece).map(move |bricks| {
            let unlit = VoxelLighting::new(&classification, &self.volume, rules, None);
            self.piece(bricks, &unlit)
        })
    }

    fn piece(&self, bricks: &[Brick], unlit: &VoxelLighting<'_>) -> RecordPiece {
        let n_voxels = bricks.iter().map(|brick| usize::from(brick.n_voxels)).sum();
        let mut records = bytemuck::zeroed_vec(n_voxels);
        self.list.fill_bricks(bricks, &mut records, |brick, voxels, records| {
            fill_brick(self.list.grid(), brick, voxels, unlit, records);
        });
        RecordPiece { first: bricks[0].first.into(), records: bytemuck::cast_vec(records) }
    }
}

/// Writes the records of a brick's voxels.
pub(crate) fn fill_brick(
    grid: &BrickGrid,
    brick: &Brick,
    voxels: &[VoxelRecord],
    unlit: &VoxelLighting<'_>,
    records: &mut [Record],
) {
    let mut colors = [[0.0; 4]; MAX_VOXELS];
    let colors = &mut colors[..voxels.len()];
    unlit.classify_brick(brick, voxels, colors);
    let indices = grid.voxel_indices(brick, voxels);
    for (((record, voxel), voxel_idx), color) in
        records.iter_mut().zip(voxels).zip(indices).zip(colors)
    {
        // A grid has fewer voxels than 2³².
        let voxel_idx = voxel_idx as u32;
        *record = Record { normal: voxel.normal_in_world(), voxel_idx, color: *color };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_backend::Planner;
    use slabsplat_core::glam::DVec3;
    use slabsplat_core::{
        Camera, Grid, LabelMap, LabelStyle, Labels, Layer, Projection, Scaling, Scene,
        TransferFunction,
    };
    use slabsplat_seeds::for_each_seed;

    const RED: [f64; 3] = [1.0, 0.0, 0.25];

    /// Voxels of value 0 and of label 2 are invisible, and those of label 1 red and half as opaque.
    fn layer(rng: &mut fastrand::Rng) -> Layer {
        let grid = Grid::with_spacing([0; 3].map(|_| rng.usize(1..30)), [1.0; 3]).unwrap();
        let mut random = |end: u8| (0..grid.n_voxels()).map(|_| rng.u8(..end)).collect::<Vec<_>>();
        let [samples, labels] = [random(5), random(3)];
        let volume = |samples: Vec<u8>| Volume::new(grid, samples.into(), Scaling::IDENTITY);
        let map = LabelMap::new(&volume(labels).unwrap(), &grid).unwrap();
        let red = LabelStyle::default().color(RED).opacity(0.5);
        let nothing = LabelStyle::default().opacity(0.0);
        let colors = vec![(0.0, [0.0; 3]), (4.0, [1.0; 3])];
        let transfer = TransferFunction::new(vec![(0.0, [0.0]), (4.0, [0.8])], colors).unwrap();
        let labels = Labels::new(map, [(1, red), (2, nothing)]).unwrap();
        Layer::new(volume(samples).unwrap(), transfer).labels(labels)
    }

    fn scene(layer: Layer) -> Scene {
        let target = layer.volume.grid().center_in_world();
        let projection = Projection::Orthographic { view_height: 9.0 };
        let camera = Camera::new(target + 50.0 * DVec3::Z, target, DVec3::Y, projection);
        let mut scene = Scene::new(layer, camera.unwrap());
        scene.settings.mode = Compositing::Separate.into();
        scene
    }

    /// Every relevant voxel is in one piece, with its own colour, and no piece is much larger than it should
    /// be.
    #[test]
    fn host_list_pieces_are_all_voxels() {
        for_each_seed(20, |mut rng| {
            let scene = scene(layer(&mut rng));
            let mut planner = Planner::default();
            let plan = planner.plan(&scene).unwrap();
            let Layer { volume, labels, .. } = &scene.layers[0];
            let (known, frame) = (KnownVolume::new(volume.clone()), FrameHandle::new());
            let list = HostList::new(&plan, &plan.layers[0], &known, &frame).unwrap();
            assert!(list.is_of(&plan, &plan.layers[0]));
            let mut voxels = Vec::new();
            for piece in list.pieces() {
                assert_eq!(piece.first, voxels.len() as u64);
                assert!(piece.records.len() < VOXELS_PER_PIECE as usize + MAX_VOXELS);
                voxels.extend_from_slice(bytemuck::cast_slice::<_, Record>(&piece.records));
            }
            assert_eq!(list.n_voxels(), voxels.len() as u64);
            voxels.sort_by_key(|record| record.voxel_idx);
            let labels = labels.as_ref().unwrap().map().indices();
            let relevant =
                |&voxel_idx: &usize| volume.value(voxel_idx) != 0.0 && labels[voxel_idx] != 2;
            let relevant: Vec<_> = (0..labels.len()).filter(relevant).collect();
            let listed = voxels.iter().map(|record| record.voxel_idx as usize);
            assert!(listed.eq(relevant.iter().copied()));
            for (record, voxel_idx) in voxels.iter().zip(relevant) {
                let share = volume.value(voxel_idx) / 4.0;
                let [r, g, b] = if labels[voxel_idx] == 1 { RED } else { [share; 3] };
                let factor = if labels[voxel_idx] == 1 { 0.5 } else { 1.0 };
                let expected = [r, g, b, 0.8 * share * factor].map(|channel| channel as f32);
                let is_near = |(a, b): (f32, f32)| (a - b).abs() < 1e-6;
                assert!(record.color.into_iter().zip(expected).all(is_near), "{record:?}");
            }
        });
    }
}
