//! The slabs that all layers of a scene share (model §§3, 10), and what is drawn in them.

use super::frame::{LayerInView, Sheet, SheetSplat};
use super::view::View;
use slabsplat_core::Scene;
use slabsplat_core::glam::DVec3;
use std::collections::BTreeMap;

/// Where the slabs are: slab `n` begins at the depth `center + n·width·unit`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs {
    /// `z_c`.
    center: f64,
    /// In `unit`s.
    width: f64,
    /// The least of all layers.
    unit: f64,
}

/// What slabs have of a layer, by the number of the slab.
pub(super) type SplatsBySlab = BTreeMap<i64, Vec<SheetSplat>>;

impl Slabs {
    /// The slabs of the scene's width.
    pub(super) fn new(scene: &Scene, view: &View) -> Self {
        let units = scene.layers.iter().map(|layer| layer.volume.grid().unit());
        Self {
            center: view.view_from_world(center_in_world(scene)).z,
            width: scene.settings.slab_width,
            unit: units.fold(f64::INFINITY, f64::min),
        }
    }

    /// Their halves, numbered in turn.
    pub(super) fn halves(self) -> Self {
        Self { width: 0.5 * self.width, ..self }
    }

    /// The depth of slab `n`'s front face.
    pub(super) fn face(&self, n: i64) -> f64 {
        self.center + n as f64 * self.width * self.unit
    }

    /// The slab at a depth.
    pub(super) fn at(&self, depth: f64) -> i64 {
        ((depth - self.center) / (self.width * self.unit)).floor() as i64
    }

    /// A length of so many `unit`s in those of a layer.
    pub(super) fn in_units_of(&self, layer_unit: f64, length: f64) -> f64 {
        length * (self.unit / layer_unit)
    }

    /// Width of a slab in `unit`s of a layer.
    pub(super) fn width_in(&self, layer_unit: f64) -> f64 {
        self.in_units_of(layer_unit, self.width)
    }

    /// The sheets, from front to back, of which each layer has so much.
    pub(super) fn sheets(
        &self,
        view: &View,
        layers: &[LayerInView],
        splats: impl Fn(&LayerInView) -> SplatsBySlab,
    ) -> Vec<Sheet> {
        let mut by_slab: BTreeMap<i64, Sheet> = BTreeMap::new();
        for (layer_idx, layer) in layers.iter().enumerate() {
            for (slab, splats) in splats(layer) {
                let faces = [slab, slab + 1].map(|face| self.face(face));
                if view.draws_slab(faces, layer.stretch.unit()) {
                    let empty =
                        || Sheet { splats: vec![Vec::new(); layers.len()], faces: Some(faces) };
                    by_slab.entry(slab).or_insert_with(empty).splats[layer_idx] = splats;
                }
            }
        }
        by_slab.into_values().collect()
    }
}

/// The centre of the only grid, or of the box around the corner voxels of all.
fn center_in_world(scene: &Scene) -> DVec3 {
    if let [only] = &scene.layers[..] {
        return only.volume.grid().center_in_world();
    }
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for layer in &scene.layers {
        let grid = layer.volume.grid();
        for corner in 0..8 {
            let ends = [0, 1, 2].map(|axis| (corner >> axis & 1) * (grid.dims()[axis] - 1));
            let in_index = DVec3::from_array(ends.map(|coord| coord as f64));
            let in_world = grid.world_from_index().transform_point3(in_index);
            (min, max) = (min.min(in_world), max.max(in_world));
        }
    }
    0.5 * (min + max)
}
