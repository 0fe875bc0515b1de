//! Faces of a region that are lit as surfaces (model §11).

use slabsplat_backend::LayerPlan;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{RegionInView, ViewAxes};

/// What of a layer is lit by the normals of its region's faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct LitFaces<'a> {
    region: &'a RegionInView,
    axes: &'a ViewAxes,
    unit: f64,
}

/// A face's normal, and how much it counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceNormal {
    /// In view space.
    normal: DVec3,
    share: f64,
}

impl<'a> LitFaces<'a> {
    /// `None` if there are none.
    pub(super) fn of(layer: &'a LayerPlan<'_>) -> Option<Self> {
        let region = layer.region.as_ref().filter(|region| region.is_lit())?;
        let unit = layer.volume.grid().unit();
        Some(Self { region, axes: layer.view.axes(), unit })
    }

    /// The normal of the face near a point of view space, if it counts there.
    #[inline]
    pub(super) fn at(&self, point: DVec3) -> Option<FaceNormal> {
        let (normal, behind) = self.region.face_near(point, RegionInView::HAIR * self.unit)?;
        let share = RegionInView::DEEPEST_LIT - behind / self.unit;
        (0.0 < share).then_some(FaceNormal { normal, share: share.min(1.0) })
    }

    /// Whether the normal of a face counts at any point of a box.
    pub(super) fn may_be_in(&self, center: DVec3, half_extents: DVec3) -> bool {
        self.region.may_light(center, half_extents, self.unit)
    }

    /// The same direction in the world.
    pub(super) fn in_world(&self, v: DVec3) -> DVec3 {
        self.axes.right * v.x + self.axes.up * v.y + self.axes.forward * v.z
    }

    /// What becomes of a normal of the world, whose length counts as 1 unless it is 0; of length 1 but for
    /// rounding, or 0.
    pub(super) fn instead_of(&self, normal: DVec3, face: FaceNormal) -> DVec3 {
        let FaceNormal { normal: of_face, share } = face;
        let own = normal.normalize_or_zero();
        (self.in_world(of_face) * share + own * (1.0 - share)).normalize_or_zero()
    }
}

impl FaceNormal {
    /// What becomes of a normal of view space that may be shorter than 1.
    #[inline]
    pub(super) fn instead_of(&self, normal: [f32; 3]) -> [f32; 3] {
        let own = DVec3::from_array(normal.map(f64::from));
        (self.normal * self.share + own * (1.0 - self.share)).as_vec3().to_array()
    }
}
