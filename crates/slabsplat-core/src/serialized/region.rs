//! A region is its planes; a box is written as its six.

use serde::{Deserialize, Serialize};

use crate::{Plane, Region, RegionError};

/// The keys of a region.
#[derive(Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct RegionKeys {
    /// The least and the greatest corner of a box.
    #[serde(rename = "box", skip_serializing)]
    ends: Option<[[f64; 3]; 2]>,
    /// Normals and distances.
    planes: Vec<[f64; 4]>,
    invert: bool,
    lit: bool,
}

impl TryFrom<RegionKeys> for Region {
    type Error = RegionError;

    fn try_from(keys: RegionKeys) -> Result<Self, RegionError> {
        let mut region = keys.ends.map_or(Ok(Self::default()), Self::in_box)?;
        for [x, y, z, distance] in keys.planes {
            region = region.behind(Plane::new([x, y, z], distance)?);
        }
        let region = if keys.invert { region.inverted() } else { region };
        Ok(if keys.lit { region.lit() } else { region })
    }
}

impl From<Region> for RegionKeys {
    fn from(region: Region) -> Self {
        let keys = |plane: &Plane| {
            let [x, y, z] = plane.normal().to_array();
            [x, y, z, plane.distance()]
        };
        Self {
            ends: None,
            planes: region.planes().iter().map(keys).collect(),
            invert: region.is_inverted(),
            lit: region.is_lit(),
        }
    }
}
