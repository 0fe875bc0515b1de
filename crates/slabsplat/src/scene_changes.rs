//! A scene that is open, shown as a scene file says: the way back of [`OpenScene::to_file`], over volumes,
//! labels and meshes that are there already.
//!
//! No file is read, so that a file from a stranger can be shown, too: what it says of where volumes come from
//! does not count.

use crate::automatic::Look;
use crate::transfer::{Fitted, fitted};
use crate::volume_facts::VolumeFacts;
use crate::{OpenError, OpenScene};
use slabsplat_core::{Layer, MeshLayer, Scene, Shading, TransferFunction2d};
use slabsplat_io::{LayerFile, MeshFile, SceneFile};

impl OpenScene {
    /// The same volumes, labels and meshes, shown as `file` says: camera, lights, picture, settings, and how
    /// each of them looks. What a file leaves open stays as it is here. Nothing is read, and names of files
    /// do not count.
    ///
    /// ```
    /// use slabsplat::{OpenScene, io};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let opened = OpenScene::open(&io::parse_scene("volume = { generate = \"sphere\" }", "a.toml")?)?;
    /// let mut turned = opened.clone();
    /// turned.scene.camera = turned.scene.camera.orbited(0.3);
    /// let text = io::scene_text(&turned.to_file()?, "a.toml")?;
    /// let file = io::parse_scene_alone(&text, "a.toml")?;
    /// assert_eq!(opened.shown_as(&file)?.scene, turned.scene);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If `file` has another number of layers or meshes, labels where there are none, or something that
    /// would have to be read; or if a camera, a region or a transfer function makes no sense.
    pub fn shown_as(&self, file: &SceneFile) -> Result<Self, OpenError> {
        let (n_layers, n_meshes) = (self.scene.layers.len(), self.scene.meshes.len());
        if [file.layers.len(), file.meshes.len()] != [n_layers, n_meshes] {
            return Err(OpenError::OtherScene { n_layers, n_meshes });
        }
        let mut shown = self.clone();
        let Self { scene, sources, backend, .. } = &mut shown;
        let layers = scene.layers.iter_mut().zip(&mut sources.layers).zip(&file.layers);
        for (layer_idx, ((layer, source), file_of_layer)) in layers.enumerate() {
            self.show_layer(layer, layer_idx, file_of_layer)?;
            layer.shading = shading_of(file, file_of_layer.shading, layer.shading);
            source.name.clone_from(&file_of_layer.name);
        }
        let meshes = scene.meshes.iter_mut().zip(&mut sources.meshes).zip(&file.meshes);
        for ((mesh, source), file_of_mesh) in meshes {
            *mesh = mesh_as(mesh, file_of_mesh)?;
            mesh.shading = shading_of(file, file_of_mesh.shading, mesh.shading);
            source.name.clone_from(&file_of_mesh.name);
        }
        backend.clone_from(&file.backend);
        show_all(scene, file)?;
        Ok(shown)
    }

    fn show_layer(
        &self,
        layer: &mut Layer,
        layer_idx: usize,
        file: &LayerFile,
    ) -> Result<(), OpenError> {
        let (now, volume) = (layer.transfer.clone(), &layer.volume);
        let water = || Look::of(volume, volume.grid(), self.acquisition).kind.water();
        let scale = VolumeFacts::from(&**volume).scale();
        let Fitted { transfer, gradient_opacity, .. } = fitted(file, scale, || now, water)?;
        layer.region = file.region.on(volume.grid())?;
        layer.transfer_2d = self.transfer_2d_of(layer_idx, file)?;
        layer.labels = match (&file.labels, &layer.labels) {
            (None, _) => None,
            (Some(file), Some(labels)) => Some(file.styled(labels)?),
            (Some(_), None) => return Err(OpenError::NoLabels { layer_idx }),
        };
        layer.transfer = transfer;
        layer.gradient_opacity = gradient_opacity;
        layer.isosurfaces.clone_from(&file.isosurfaces);
        Ok(())
    }

    /// What a picture says by its name alone is what was read of it when the scene was opened.
    fn transfer_2d_of(
        &self,
        layer_idx: usize,
        file: &LayerFile,
    ) -> Result<Option<TransferFunction2d>, OpenError> {
        let Some(image) = file.transfer_image.as_ref().filter(|_| file.transfer_2d.is_none())
        else {
            return Ok(file.transfer_2d.clone());
        };
        let source = &self.sources.layers[layer_idx];
        let is_known = source.transfer_image.as_ref().is_some_and(|known| {
            [known.values, known.gradients] == [image.values, image.gradients]
                && known.path.file_name() == image.path.file_name()
        });
        if is_known {
            return Ok(source.transfer_2d.clone());
        }
        Err(OpenError::NotRead { path: image.path.clone() })
    }
}

/// All but what layers and meshes look like.
fn show_all(scene: &mut Scene, file: &SceneFile) -> Result<(), OpenError> {
    scene.camera = file.camera.complete(&scene.camera)?;
    let background =
        if file.unsaid.background { scene.image.background } else { file.image.background };
    scene.image = file.image.background(background);
    if !file.unsaid.lights {
        scene.lights.clone_from(&file.lights);
    }
    scene.settings.clone_from(&file.settings);
    scene.finish.clone_from(&file.finish);
    Ok(())
}

fn shading_of(file: &SceneFile, said: Shading, now: Shading) -> Shading {
    if file.unsaid.shading { now } else { said }
}

/// All but its shading.
fn mesh_as(mesh: &MeshLayer, file: &MeshFile) -> Result<MeshLayer, OpenError> {
    let mut mesh = mesh.clone().placed(file.world_from_mesh)?;
    mesh.region = file.region.in_world()?;
    mesh.color = file.color;
    (mesh.line_width, mesh.point_size) = (file.line_width, file.point_size);
    Ok(mesh)
}

#[cfg(test)]
mod tests;
