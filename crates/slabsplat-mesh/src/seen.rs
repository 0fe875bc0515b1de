//! What meshes were seen as in a frame, to find that nothing has changed in the next.

use slabsplat_backend::{MeshPlan, MeshesPlan};
use slabsplat_core::{BlinnPhong, MeshLayer, RegionInView, View};

/// All that hits depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenMeshes {
    view: View,
    meshes: Vec<SeenMesh>,
}

#[derive(Clone, Debug, PartialEq)]
struct SeenMesh {
    layer: MeshLayer,
    light: Option<BlinnPhong>,
    region: Option<RegionInView>,
}

impl SeenMeshes {
    /// That of a plan.
    pub fn of(plan: &MeshesPlan<'_>) -> Self {
        let seen = |MeshPlan { layer, light, region, .. }: &MeshPlan<'_>| SeenMesh {
            layer: (*layer).clone(),
            light: light.clone(),
            region: region.clone(),
        };
        Self { view: plan.view, meshes: plan.meshes.iter().map(seen).collect() }
    }

    /// Whether the hits of a plan are those. Its order of meshes has no meaning, but who shows them keeps it.
    pub fn is_of(&self, plan: &MeshesPlan<'_>) -> bool {
        let is_alike =
            |(seen, MeshPlan { layer, light, region, .. }): (&SeenMesh, &MeshPlan<'_>)| {
                seen.layer == **layer && seen.light == *light && seen.region == *region
            };
        self.view == plan.view
            && self.meshes.len() == plan.meshes.len()
            && self.meshes.iter().zip(&plan.meshes).all(is_alike)
    }
}
