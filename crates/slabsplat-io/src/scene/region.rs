//! What a scene says of a region, before there is a volume.

use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, Plane, Region, RegionError};

/// Where a layer is seen, as a scene file or flags say it.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RegionDesc {
    /// The least and the greatest corner of a box.
    pub ends: Option<[DVec3; 2]>,
    /// Whether these are voxels of the layer's grid, not points of the world.
    pub is_index: bool,
    /// What lies behind all of these planes as well.
    pub planes: Vec<Plane>,
    /// Whether it is all but that.
    pub is_inverted: bool,
    /// Whether its faces are lit as surfaces.
    pub is_lit: bool,
}

impl RegionDesc {
    /// The region of a layer on that grid.
    ///
    /// # Errors
    /// If the box ends before it starts, or an end is not finite.
    pub fn on(&self, grid: &Grid) -> Result<Region, RegionError> {
        match self.ends {
            Some(ends) if self.is_index => Ok(self.within(Region::in_index_box(grid, ends)?)),
            _ => self.in_world(),
        }
    }

    /// The region of what has no grid. A box that counts voxels is left out.
    ///
    /// # Errors
    /// As [`on`](Self::on).
    pub fn in_world(&self) -> Result<Region, RegionError> {
        let ends = self.ends.filter(|_| !self.is_index);
        Ok(self.within(ends.map_or(Ok(Region::default()), Region::in_box)?))
    }

    /// What planes and switches leave of a box.
    fn within(&self, convex: Region) -> Region {
        let convex = self.planes.iter().fold(convex, |region, plane| region.behind(*plane));
        let region = if self.is_inverted { convex.inverted() } else { convex };
        if self.is_lit { region.lit() } else { region }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::{DAffine3, DMat3};

    #[test]
    fn region_of_box_and_planes() {
        let place =
            DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(2.0)), DVec3::X);
        let grid = Grid::new([9; 3], place).unwrap();
        let everywhere = RegionDesc::default();
        assert!(everywhere.on(&grid).unwrap().is_everywhere());
        let desc = RegionDesc {
            ends: Some([DVec3::ONE, DVec3::splat(3.0)]),
            is_index: true,
            planes: vec![Plane::new(DVec3::Y, 4.0).unwrap()],
            ..everywhere.clone()
        };
        let inverted = RegionDesc { is_inverted: true, ..desc.clone() };
        for (point, expected) in [
            (DVec3::new(4.0, 3.0, 3.0), true),
            (DVec3::new(2.9, 3.0, 3.0), false),
            (DVec3::new(4.0, 4.1, 3.0), false),
        ] {
            assert_eq!(desc.on(&grid).unwrap().contains(point), expected, "{point}");
            assert_eq!(inverted.on(&grid).unwrap().contains(point), !expected, "{point}");
        }
        assert!(RegionDesc { is_lit: true, ..desc }.on(&grid).unwrap().is_lit());
        let backwards = RegionDesc { ends: Some([DVec3::ONE, DVec3::ZERO]), ..everywhere };
        assert!(backwards.on(&grid).is_err());
    }
}
