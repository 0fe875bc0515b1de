//! What a scene says of a mesh, before its file is read.

use std::path::{Path, PathBuf};

use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{Mesh, MeshLayer, Phong, Shading};

use super::RegionDesc;
use super::completed::DIFFERS;
use super::diagnostic::Diagnostic;
use super::document::{LayerSection, MeshSection};
use crate::printable::shown_path;
use crate::{ContentHash, IoError, read_mesh};

/// What a scene file says of an opaque mesh.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeshFile {
    /// What it is called, for people.
    pub name: Option<String>,
    /// A file in any format that [`read_mesh`] knows.
    pub path: PathBuf,
    /// Of the mesh that the scene was made of.
    pub hash: Option<ContentHash>,
    /// Red, green and blue, 0 to 1, of all of it.
    pub color: Option<[f64; 3]>,
    /// How thick lines are, in world units.
    pub line_width: Option<f64>,
    /// The diameter of points, in world units.
    pub point_size: Option<f64>,
    /// What takes the file's coordinates to the world.
    pub world_from_mesh: DAffine3,
    /// What light does to it.
    pub shading: Shading,
    /// Where it is seen. A box that counts voxels means nothing here, and is left out.
    pub region: RegionDesc,
}

impl MeshFile {
    /// A mesh with all by default.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self {
            name: None,
            path: path.into(),
            hash: None,
            color: None,
            line_width: None,
            point_size: None,
            world_from_mesh: DAffine3::IDENTITY,
            shading: Shading::Phong(Phong::default()),
            region: RegionDesc::default(),
        }
    }

    /// Reads the mesh; returns what is worth knowing about it, too, one line each.
    ///
    /// # Errors
    /// As [`read_mesh`]; or if it cannot be where it should.
    pub fn load(&self) -> Result<(MeshLayer, Vec<String>), IoError> {
        let loaded = read_mesh(&self.path)?;
        let in_file = |what: String| IoError::malformed(&self.path, what);
        let region = self.region.in_world().map_err(|error| in_file(error.to_string()))?;
        let layer = MeshLayer::new(loaded.mesh).shading(self.shading).region(region);
        let layer = layer.placed(self.world_from_mesh);
        let layer = layer.map_err(|error| in_file(error.to_string()))?;
        let mut layer = self.color.map_or(layer.clone(), |color| layer.color(color));
        (layer.line_width, layer.point_size) = (self.line_width, self.point_size);
        let mut warnings = loaded.warnings;
        if self.hash.is_some_and(|hash| hash != ContentHash::of_mesh(&layer.mesh)) {
            let path = shown_path(&self.path);
            warnings.push(format!("{path} is not the mesh that the scene was made of: {DIFFERS}"));
        }
        Ok((layer, warnings))
    }
}

impl LayerSection {
    /// The mesh of a layer that has one.
    pub(super) fn into_mesh(
        self,
        mesh: &MeshSection,
        folder: &Path,
    ) -> Result<MeshFile, Diagnostic> {
        let of_volumes = [
            ("volume", self.volume.is_some()),
            ("classify", self.classify.is_some()),
            ("labels", self.labels.is_some()),
        ];
        if let Some((section, _)) = of_volumes.into_iter().find(|(_, is_there)| *is_there) {
            let what = format!("a layer with a mesh has no [{section}]: make two layers of it");
            return Err(Diagnostic::at(section, "", what));
        }
        let region = self.region.unwrap_or_default().into_desc()?;
        if region.is_index {
            let what = "a mesh has no voxels that index could count: give the box in the world";
            return Err(Diagnostic::at("region", "index", what));
        }
        let path = mesh.path.as_ref();
        let path = path.ok_or_else(|| Diagnostic::at("mesh", "", "[mesh] needs a path"))?;
        Ok(MeshFile {
            name: self.name,
            path: folder.join(path),
            hash: mesh.hash,
            color: mesh.checked_color()?,
            line_width: checked_width("line_width", mesh.line_width)?,
            point_size: checked_width("point_size", mesh.point_size)?,
            world_from_mesh: mesh.place()?,
            shading: self.shading.unwrap_or_default().into_shading()?,
            region,
        })
    }
}

fn checked_width(key: &'static str, width: Option<f64>) -> Result<Option<f64>, Diagnostic> {
    if width.is_none_or(|width| 0.0 < width && width.is_finite()) {
        return Ok(width);
    }
    Err(Diagnostic::at("mesh", key, format!("{key} must be above 0, in world units")))
}

impl MeshSection {
    fn checked_color(&self) -> Result<Option<[f64; 3]>, Diagnostic> {
        let is_bad = |color: &[f64; 3]| !color.iter().all(|it| (0.0..=1.0).contains(it));
        if self.color.as_ref().is_some_and(is_bad) {
            let what = "color must be red, green and blue, 0 to 1 each";
            return Err(Diagnostic::at("mesh", "color", what));
        }
        Ok(self.color)
    }

    fn place(&self) -> Result<DAffine3, Diagnostic> {
        let Some(rows) = self.affine else { return Ok(DAffine3::IDENTITY) };
        let column = |idx: usize| DVec3::from_array(rows.map(|row| row[idx]));
        let matrix = DMat3::from_cols(column(0), column(1), column(2));
        let place = DAffine3::from_mat3_translation(matrix, column(3));
        let placed = MeshLayer::new(Mesh::default()).placed(place);
        placed.map_err(|error| Diagnostic::at("mesh", "affine", error.to_string()))?;
        Ok(place)
    }
}
