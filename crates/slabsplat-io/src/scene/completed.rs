//! The scene file that leaves nothing open: where a scene came from, and all that it became.

use slabsplat_core::{
    Camera, Labels, Layer, MeshLayer, Projection, Region, Scene, Volume, VoxelColors, exact_degrees,
};

use super::{
    CameraDesc, LabelColors, LabelsFile, LayerFile, MeshFile, RegionDesc, SceneFile, Unsaid,
};
use crate::printable::shown_path;
use crate::transfer::TransferFit;
use crate::{ContentHash, IoError};

/// What a wrong hash means.
pub(super) const DIFFERS: &str = "the picture will be another";

impl SceneFile {
    /// What this scene file has become: the same volumes and meshes, and everything else as `scene` has it,
    /// which was made of it, with hashes of what it shows. Read again, it gives that scene, and to the last
    /// bit the same picture by the same backend.
    ///
    /// ```
    /// use slabsplat_core::{Camera, Layer, Projection, Scene, TransferFunction};
    /// use slabsplat_io::{SceneFile, VolumeSource, builtin_volume, parse_scene, scene_text};
    ///
    /// let source = VolumeSource::Builtin { name: "cube".to_owned(), size: Some(8) };
    /// let transfer = TransferFunction::new([(0.0, 0.0), (255.0, 0.9)], [(0.0, [1.0; 3])])?;
    /// let parallel = Projection::Orthographic { view_height: 12.0 };
    /// let camera = Camera::new([9.0, 5.0, 7.0], [0.0; 3], [0.0, 0.0, 1.0], parallel)?;
    /// let scene = Scene::new(Layer::new(builtin_volume("cube", Some(8))?, transfer.clone()), camera);
    ///
    /// let file = SceneFile::of_volume(source).completed(&scene)?;
    /// assert_eq!(file.layers[0].transfer, Some(transfer));
    /// let text = scene_text(&file, "scene.toml")?;
    /// assert_eq!(parse_scene(&text, "scene.toml")?, file);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a layer has labels of which no file is named.
    ///
    /// # Panics
    /// If there are not as many layers and meshes in both.
    pub fn completed(&self, scene: &Scene) -> Result<Self, IoError> {
        self.completed_by(scene, Hashes::OfScene)
    }

    /// Of a scene file that is [`completed`](Self::completed), that of the same volumes, labels and meshes at
    /// a moment of its film; what is in them is not looked at.
    ///
    /// # Errors
    /// As [`completed`](Self::completed).
    ///
    /// # Panics
    /// If there are not as many layers and meshes in both.
    pub fn at_moment(&self, scene: &Scene) -> Result<Self, IoError> {
        Ok(Self { film: None, ..self.completed_by(scene, Hashes::Known)? })
    }

    fn completed_by(&self, scene: &Scene, hashes: Hashes) -> Result<Self, IoError> {
        let n_both = |n: usize, of_scene: usize| {
            assert_eq!(n, of_scene, "a scene has as many layers and meshes as its file");
        };
        n_both(self.layers.len(), scene.layers.len());
        n_both(self.meshes.len(), scene.meshes.len());
        let layers = self.layers.iter().zip(&scene.layers);
        let layers =
            layers.enumerate().map(|(idx, (file, layer))| file.completed(layer, idx, hashes));
        let meshes = self.meshes.iter().zip(&scene.meshes);
        Ok(Self {
            layers: layers.collect::<Result<_, _>>()?,
            meshes: meshes.map(|(file, mesh)| file.completed(mesh, hashes)).collect(),
            camera: CameraDesc::of(&scene.camera),
            lights: scene.lights.clone(),
            image: scene.image,
            settings: scene.settings.clone(),
            finish: scene.finish.clone(),
            film: self.film.clone(),
            backend: self.backend.clone(),
            unsaid: Unsaid::default(),
        })
    }
}

/// Where hashes come from.
#[derive(Clone, Copy)]
enum Hashes {
    OfScene,
    /// They are in the file already.
    Known,
}

impl Hashes {
    fn of(self, known: Option<ContentHash>, of_scene: impl FnOnce() -> ContentHash) -> ContentHash {
        match self {
            Self::OfScene => of_scene(),
            Self::Known => known.unwrap_or_else(of_scene),
        }
    }
}

impl LayerFile {
    /// Says so if `volume`, with the colours that its voxels have of their own, is not the one that the scene
    /// was made of.
    pub fn warning_of(&self, volume: &Volume, colors: Option<&VoxelColors>) -> Option<String> {
        let is_other = self.hash? != ContentHash::of_volume(volume, colors);
        let path = self.volume.path();
        let what = "is not the volume that the scene was made of";
        is_other.then(|| format!("{} {what}: {DIFFERS}", shown_path(&path)))
    }

    fn completed(&self, layer: &Layer, layer_idx: usize, hashes: Hashes) -> Result<Self, IoError> {
        let labels = match (&self.labels, &layer.labels) {
            (_, None) => None,
            (Some(file), Some(labels)) => Some(file.completed(labels, hashes)),
            (None, Some(_)) => return Err(IoError::LabelsWithoutFile { layer_idx }),
        };
        let is_of_file = self.transfer_2d == layer.transfer_2d;
        Ok(Self {
            hash: Some(
                hashes
                    .of(self.hash, || ContentHash::of_volume(&layer.volume, layer.colors.as_ref())),
            ),
            transfer: Some(layer.transfer.clone()),
            fit: TransferFit::default(),
            transfer_2d: layer.transfer_2d.clone(),
            transfer_image: self.transfer_image.clone().filter(|_| is_of_file),
            gradient_opacity: layer.gradient_opacity.clone(),
            labels,
            isosurfaces: layer.isosurfaces.clone(),
            shading: layer.shading,
            region: match self.region.on(layer.volume.grid()) {
                Ok(region) if region == layer.region => self.region.clone(),
                _ => RegionDesc::of(&layer.region),
            },
            ..self.clone()
        })
    }
}

impl LabelsFile {
    fn completed(&self, labels: &Labels, hashes: Hashes) -> Self {
        Self {
            path: self.path.clone(),
            hash: Some(hashes.of(self.hash, || ContentHash::of_labels(labels.map()))),
            colors: Some(LabelColors::None),
            styles: labels.styles().clone(),
            only: None,
        }
    }
}

impl MeshFile {
    fn completed(&self, mesh: &MeshLayer, hashes: Hashes) -> Self {
        Self {
            hash: Some(hashes.of(self.hash, || ContentHash::of_mesh(&mesh.mesh))),
            color: mesh.color,
            line_width: mesh.line_width,
            point_size: mesh.point_size,
            world_from_mesh: mesh.world_from_mesh(),
            shading: mesh.shading,
            region: match self.region.in_world() {
                Ok(region) if region == mesh.region => RegionDesc {
                    ends: self.region.ends.filter(|_| !self.region.is_index),
                    is_index: false,
                    ..self.region.clone()
                },
                _ => RegionDesc::of(&mesh.region),
            },
            ..self.clone()
        }
    }
}

impl RegionDesc {
    /// The planes of a region.
    fn of(region: &Region) -> Self {
        Self {
            ends: None,
            is_index: false,
            planes: region.planes().to_vec(),
            is_inverted: region.is_inverted(),
            is_lit: region.is_lit(),
        }
    }
}

impl CameraDesc {
    /// All parts of a camera.
    pub fn of(camera: &Camera) -> Self {
        let (view_height, radians) = match camera.projection() {
            Projection::Orthographic { view_height } => (Some(view_height), None),
            Projection::Perspective { fov_y_radians } => (None, Some(fov_y_radians)),
        };
        let fov_y = radians.and_then(exact_degrees);
        Self {
            projection: Some(camera.projection().kind()),
            eye: Some(camera.eye()),
            target: Some(camera.target()),
            up: Some(camera.up()),
            view_height,
            fov_y,
            fov_y_radians: radians.filter(|_| fov_y.is_none()),
        }
    }
}
