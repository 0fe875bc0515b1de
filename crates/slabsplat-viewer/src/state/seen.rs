//! What decides of how a view is filled, so that all voxels are looked at again only if that has changed.

use slabsplat::{Annotations, Layer, Mode, Region, Scene, TransferFunction, Volume};
use std::sync::Arc;

/// What is to be seen of a scene, from wherever.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    layers: Vec<(Arc<Volume>, TransferFunction, Region)>,
    mode: Mode,
    size: [u32; 2],
    annotations: Annotations,
}

/// Voxels that are looked at again within some tenths of a second. Of more, the first look has to do, unless
/// there are other layers.
const N_LOOKED_AT: usize = 1 << 27;

impl Seen {
    pub(super) fn of(scene: &Scene) -> Self {
        let of_layer =
            |layer: &Layer| (layer.volume.clone(), layer.transfer.clone(), layer.region.clone());
        Self {
            layers: scene.layers.iter().map(of_layer).collect(),
            mode: scene.settings.mode,
            size: [scene.image.width, scene.image.height],
            annotations: scene.finish.annotations.clone(),
        }
    }

    /// Whether this is something else, and worth a look.
    pub(super) fn is_to_be_looked_at_after(&self, before: &Self) -> bool {
        let pairs = || self.layers.iter().zip(&before.layers);
        let has_same_volumes = self.layers.len() == before.layers.len()
            && pairs().all(|(a, b)| Arc::ptr_eq(&a.0, &b.0));
        let looks_same = || pairs().all(|(a, b)| (&a.1, &a.2) == (&b.1, &b.2));
        let is_same = has_same_volumes
            && looks_same()
            && (self.mode, self.size) == (before.mode, before.size)
            && self.annotations == before.annotations;
        !is_same && (!has_same_volumes || self.n_voxels() <= N_LOOKED_AT)
    }

    fn n_voxels(&self) -> usize {
        self.layers.iter().map(|(volume, ..)| volume.grid().n_voxels()).sum()
    }
}
