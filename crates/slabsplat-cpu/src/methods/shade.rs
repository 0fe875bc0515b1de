//! Voxels of a brick in colour: classified, and lit by their own normals or by those of a region's faces.

use super::Stage;
use super::lit_faces::LitFaces;
use fearless_simd::{Simd, dispatch};
use slabsplat_core::glam::DVec3;
use slabsplat_traverse::{Brick, BrickBounds, VoxelRecord};

impl Stage<'_> {
    /// Writes what a sheet sums of voxels of a brick, at weight 1.
    pub(super) fn color(
        &self,
        faces: Option<&LitFaces<'_>>,
        brick: &Brick,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        let BrickBounds { center, half_extents } = self.bricks.bounds(brick);
        let [center, half_extents] =
            [center, half_extents].map(|v| DVec3::from_array(v.map(f64::from)));
        match faces {
            Some(faces) if faces.may_be_in(center, half_extents) => {
                self.color_by_faces(faces, brick, records, colors);
            }
            _ => self.shade(brick, records, colors),
        }
    }

    fn shade(&self, brick: &Brick, records: &[VoxelRecord], colors: &mut [[f32; 4]]) {
        let Stage { lighting, level, .. } = self;
        lighting.classify_brick(brick, records, colors);
        dispatch!(*level, simd => simd.vectorize(
            #[inline(always)]
            || lighting.light_brick(records, colors),
        ));
    }

    /// Shades voxels of a brick near lit faces, with normals of those.
    fn color_by_faces(
        &self,
        faces: &LitFaces<'_>,
        brick: &Brick,
        records: &[VoxelRecord],
        colors: &mut [[f32; 4]],
    ) {
        let (mut points, mut own) = ([[0.0; 3]; AT_ONCE], [VoxelRecord::default(); AT_ONCE]);
        for (records, colors) in records.chunks(AT_ONCE).zip(colors.chunks_mut(AT_ONCE)) {
            let (points, own) = (&mut points[..records.len()], &mut own[..records.len()]);
            own.copy_from_slice(records);
            self.bricks.project_brick(brick, records, points);
            for (record, point) in own.iter_mut().zip(points) {
                if let Some(face) = faces.at(DVec3::from_array(point.map(f64::from))) {
                    let normal = DVec3::from_array(record.normal.map(f64::from));
                    *record = record.with_normal(faces.instead_of(normal, face).to_array());
                }
            }
            self.shade(brick, own, colors);
        }
    }
}

/// Voxels that are shaded at once where normals are changed.
const AT_ONCE: usize = 64;
