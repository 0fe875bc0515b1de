//! Regions over time: planes move. Where keys have as many planes each moves to the one in its place; else
//! planes of the same direction are one, and where a key lacks it, it stands where it cuts nothing off.

use super::MotionError;
use super::track::Track;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Grid, Plane, Region};

#[derive(Clone, Debug, PartialEq)]
pub(super) struct RegionPath {
    track: Track,
    /// Of each key, as many.
    planes: Vec<Vec<Plane>>,
    /// What lies behind these planes is all of the layer.
    regions: Vec<Region>,
    corners: Vec<DVec3>,
    /// How far kernels reach beyond the grid.
    margin: f64,
}

/// Voxel steps beyond the grid at which no kernel is seen.
const MARGIN_STEPS: f64 = 4.0;

/// Cosine from which on two normals are one.
const SAME: f64 = 1.0 - 1e-12;

impl RegionPath {
    /// # Errors
    /// If some of them are inverted, and others not.
    pub(super) fn new(
        track: Track,
        regions: Vec<Region>,
        grid: &Grid,
    ) -> Result<Self, MotionError> {
        if regions.windows(2).any(|pair| pair[0].is_inverted() != pair[1].is_inverted()) {
            return Err(MotionError::TwoSides);
        }
        let corners = grid.corners_in_world().collect();
        let longest = grid.spacing().into_iter().fold(0.0, f64::max);
        let mut path =
            Self { track, planes: Vec::new(), regions, corners, margin: MARGIN_STEPS * longest };
        path.planes = path.matched()?;
        Ok(path)
    }

    fn matched(&self) -> Result<Vec<Vec<Plane>>, MotionError> {
        let n_planes = |region: &Region| region.planes().len();
        if self.regions.windows(2).all(|pair| n_planes(&pair[0]) == n_planes(&pair[1])) {
            return Ok(self.regions.iter().map(|region| region.planes().to_vec()).collect());
        }
        let mut normals: Vec<DVec3> = Vec::new();
        for plane in self.regions.iter().flat_map(Region::planes) {
            if !normals.iter().any(|normal| SAME < normal.dot(plane.normal())) {
                normals.push(plane.normal());
            }
        }
        let plane_of = |region: &Region, normal: DVec3| {
            let same = region.planes().iter().filter(|plane| SAME < plane.normal().dot(normal));
            // Of two, the one that cuts off more is the one that counts.
            let nearest = same.map(Plane::distance).reduce(f64::min);
            Ok(Plane::new(normal, nearest.unwrap_or(self.open(normal)))?)
        };
        let planes =
            |region: &Region| normals.iter().map(|&normal| plane_of(region, normal)).collect();
        self.regions.iter().map(planes).collect()
    }

    /// The distance of a plane that has all of the layer behind it.
    fn open(&self, normal: DVec3) -> f64 {
        let farthest =
            self.corners.iter().map(|corner| normal.dot(*corner)).fold(f64::NEG_INFINITY, f64::max);
        farthest + self.margin
    }

    /// # Errors
    /// If numbers do not suffice.
    pub(super) fn at(&self, seconds: f64) -> Result<Region, MotionError> {
        let moment = self.track.at(seconds);
        let key_idx = moment.segment + usize::from(moment.part == 1.0);
        let like = &self.regions[key_idx.min(self.regions.len() - 1)];
        let mut planes = Vec::with_capacity(self.planes[0].len());
        for plane_idx in 0..self.planes[0].len() {
            let number = |of: &dyn Fn(&Plane) -> f64| {
                self.track.number(moment, |key| of(&self.planes[key][plane_idx]))
            };
            let normal =
                DVec3::from_array([0, 1, 2].map(|axis| number(&|plane| plane.normal()[axis])));
            let plane = Plane::new(normal, number(&Plane::distance))?;
            // What cuts nothing off costs time.
            if like.is_inverted() || plane.distance() < self.open(plane.normal()) {
                planes.push(plane);
            }
        }
        let convex = Region::new(planes);
        let region = if like.is_inverted() { convex.inverted() } else { convex };
        Ok(if like.is_lit() { region.lit() } else { region })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::Easing;

    fn path(regions: &[Region]) -> Result<RegionPath, MotionError> {
        let times = (0..regions.len()).map(|idx| (idx as f64, Easing::Linear));
        let grid = Grid::with_spacing([11, 11, 11], [1.0; 3]).unwrap();
        RegionPath::new(Track::new(times, false), regions.to_vec(), &grid)
    }

    #[test]
    fn region_closes_in_from_everywhere() {
        let center = Grid::with_spacing([11, 11, 11], [1.0; 3]).unwrap().center_in_world();
        let half = Region::new(vec![Plane::new(DVec3::X, center.x).unwrap()]);
        let there = path(&[Region::default(), half.clone()]).unwrap();
        assert_eq!(there.at(0.0).unwrap(), Region::default());
        assert_eq!(there.at(1.0).unwrap(), half);
        let now = there.at(0.5).unwrap();
        // Half the way from the far margin, 5 + 4 steps from the middle.
        assert!(now.contains(center + DVec3::X * 4.4) && !now.contains(center + DVec3::X * 4.6));
    }

    #[test]
    fn region_boxes_move() {
        let of =
            |from: f64| Region::in_box([DVec3::splat(from), DVec3::splat(from + 2.0)]).unwrap();
        let there = path(&[of(0.0), of(1.0)]).unwrap();
        let now = there.at(0.5).unwrap();
        assert!(now.contains([0.51; 3]) && now.contains([2.49; 3]));
        assert!(!now.contains([0.49; 3]) && !now.contains([2.51; 3]));
        let planes =
            [DVec3::X, DVec3::Y].map(|normal| Region::new(vec![Plane::new(normal, 0.0).unwrap()]));
        let turned = path(&planes).unwrap().at(0.5).unwrap();
        assert!((turned.planes()[0].normal().x - turned.planes()[0].normal().y).abs() < 1e-12);
    }

    #[test]
    fn region_is_inverted_in_all_keys_or_none() {
        let cut = Region::in_box([[0.0; 3], [1.0; 3]]).unwrap();
        assert_eq!(path(&[cut.clone(), cut.clone().inverted()]), Err(MotionError::TwoSides));
        assert!(
            path(&[cut.clone().inverted(), cut.inverted()]).unwrap().at(0.5).unwrap().is_inverted()
        );
    }
}
