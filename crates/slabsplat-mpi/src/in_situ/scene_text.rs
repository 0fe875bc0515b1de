//! How a simulation is shown, as the text of a scene file.

use super::AnyError;
use slabsplat::io::{LoadedVolume, SceneFile, parse_scene};
use slabsplat::{Aim, OpenScene, Scene, Volume};
use std::sync::Arc;
use thiserror::Error;

/// A scene file without a volume, in whose place a simulation has its fields.
///
/// It says its transfer functions and its camera: no rank sees all values, of which they could be found.
///
/// ```
/// let text = "classify = { opacity = [[0.0, 0.0], [1.0, 0.3]], color = [[0.0, 1.0, 0.5, 0.2]] }
///     [camera]
///     eye = [90.0, 0.0, 0.0]
///     target = [0.0, 0.0, 0.0]
///     up = [0.0, 0.0, 1.0]
///     fov_y = 30.0";
/// slabsplat_mpi::SceneText::parse(text)?;
/// # Ok::<(), Box<dyn std::error::Error + Send + Sync>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SceneText {
    file: SceneFile,
}

/// What a scene does not say, and has to.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("the scene has to say {0}, as no rank sees all values")]
struct Unsaid(&'static str);

/// What stands for the simulation in a scene of one layer.
const VOLUME: &str = "\n[volume]\ngenerate = \"cube\"\n";

impl SceneText {
    /// A scene of one layer without `[volume]`, or of several, `[[layers]]`, each with
    /// `volume = { generate = "cube" }`, in whose place the fields come in their order.
    ///
    /// # Errors
    /// If it is no scene, or leaves to its volumes what it must not.
    pub fn parse(text: &str) -> Result<Self, AnyError> {
        let whole =
            if text.contains("[[layers]]") { text.to_owned() } else { format!("{text}{VOLUME}") };
        let file = parse_scene(&whole, "the simulation's scene")?;
        let is_open = |layer: &slabsplat::io::LayerFile| {
            layer.transfer.is_none() && layer.transfer_2d.is_none()
        };
        let camera = &file.camera;
        let has_size = camera.fov_y.or(camera.fov_y_radians).or(camera.view_height).is_some();
        let unsaid = if file.layers.iter().any(is_open) || !file.is_fitted() {
            Some("which opacities and colours values have, in [classify]")
        } else if camera.eye.is_none() || camera.target.is_none() || camera.up.is_none() {
            Some("the camera's eye, target and up, in [camera]")
        } else if !has_size {
            Some("the camera's fov_y or view_height, in [camera]")
        } else {
            None
        };
        unsaid.map_or(Ok(Self { file }), |what| Err(Unsaid(what).into()))
    }

    /// How many fields it shows.
    pub fn n_fields(&self) -> usize {
        self.file.layers.len()
    }

    /// Pixels in a row, and rows.
    pub fn size(&self) -> [u32; 2] {
        [self.file.image.width, self.file.image.height]
    }

    /// The scene of those volumes, for [`InSitu::picture`](crate::InSitu::picture).
    ///
    /// # Errors
    /// If there are more or fewer, or it cannot be.
    pub fn scene(&self, volumes: Vec<Arc<Volume>>) -> Result<Scene, AnyError> {
        if volumes.len() != self.n_fields() {
            return Err(Unsaid("as many layers as there are fields").into());
        }
        let loaded = volumes.into_iter().map(LoadedVolume::computed).collect();
        let mut opened = OpenScene::unframed(loaded, &self.file)?;
        opened.frame(&self.file, &Aim::default())?;
        Ok(opened.scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scene_text_says_all_that_voxels_could() {
        let look =
            "[classify]\nopacity = [[0.0, 0.0], [1.0, 0.3]]\ncolor = [[0.0, 1.0, 0.5, 0.2]]\n";
        let camera =
            "[camera]\neye = [9.0, 0.0, 0.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, 1.0]\n";
        let error = |text: &str| SceneText::parse(text).unwrap_err().to_string();
        assert!(error(camera).contains("[classify]"));
        assert!(error(look).contains("eye"));
        assert!(error(&format!("{look}{camera}")).contains("fov_y"));
        assert!(error("wrong = 1").contains("wrong"));
        let whole = SceneText::parse(&format!("{look}{camera}view_height = 3.0\n")).unwrap();
        assert_eq!((whole.n_fields(), whole.size()), (1, [512, 512]));
        assert!(whole.scene(Vec::new()).is_err());
    }
}
