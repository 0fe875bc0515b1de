//! Layers that come to a scene that is open, or leave it.

use crate::OpenScene;
use crate::automatic::takes_gradients;
use crate::scene_file::Origin;
use slabsplat_core::Acquisition;
use slabsplat_io::{FilmFile, VolumeChoices};

impl OpenScene {
    /// Adds the layers and meshes of another scene, as they look there. Camera, lights, picture and settings
    /// stay, and so does the film; that of the other scene is left out.
    ///
    /// ```
    /// use slabsplat::{OpenScene, io};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let open = |text| OpenScene::open(&io::parse_scene(text, "a.toml").unwrap());
    /// let mut opened = open("volume = { generate = \"sphere\" }")?;
    /// opened.add_layers_of(open("volume = { generate = \"cube\" }")?);
    /// assert_eq!(opened.scene.layers.len(), 2);
    /// let cube = opened.with_layers(&[false, true]);
    /// assert_eq!(cube.scene.layers[0], opened.scene.layers[1]);
    /// # Ok(())
    /// # }
    /// ```
    pub fn add_layers_of(&mut self, other: Self) {
        let Self { scene, warnings, found, acquisition, facing, sources, origins, .. } = other;
        if self.scene.layers.is_empty() && !scene.layers.is_empty() {
            (self.acquisition, self.facing) = (acquisition, facing);
        }
        let takes_gradients = takes_gradients(&self.scene.settings);
        for (mut layer, source) in scene.layers.into_iter().zip(&sources.layers) {
            if !takes_gradients {
                // What was found for a mode that takes them.
                layer.gradient_opacity.clone_from(&source.gradient_opacity);
            }
            self.scene.layers.push(layer);
        }
        self.scene.meshes.extend(scene.meshes);
        self.sources.layers.extend(sources.layers);
        self.sources.meshes.extend(sources.meshes);
        let numbers = self.origins.iter().map(|origin| origin.number);
        let next = numbers.max().map_or(0, |last| last + 1);
        let origins = origins.into_iter().zip(next..);
        self.origins.extend(origins.map(|(origin, number)| Origin { number, ..origin }));
        self.warnings.extend(warnings);
        self.found.extend(found);
    }

    /// The same with some of its layers alone: those for which `keeps` says so. Meshes stay. What a film says
    /// of the others is left out.
    ///
    /// # Panics
    /// If `keeps` does not have one for each layer.
    #[must_use]
    pub fn with_layers(&self, keeps: &[bool]) -> Self {
        assert_eq!(keeps.len(), self.scene.layers.len(), "there is one for each layer");
        let mut with = self.clone();
        retain(&mut with.scene.layers, keeps);
        retain(&mut with.sources.layers, keeps);
        retain(&mut with.origins, keeps);
        if let Some(film) = &mut with.sources.film {
            retain_keys(film, keeps);
        }
        if keeps.first() == Some(&false)
            && let Some(first) = with.origins.first()
        {
            (with.acquisition, with.facing) = (first.acquisition, first.facing);
        }
        with
    }

    /// What the file of each layer's volume says of it beside its values.
    pub fn acquisitions(&self) -> impl Iterator<Item = Acquisition> {
        self.origins.iter().map(|origin| origin.acquisition)
    }

    /// What the file of a layer's volume holds, and what was read of it.
    ///
    /// # Panics
    /// If there is no such layer.
    pub fn choices_of(&self, layer_idx: usize) -> &VolumeChoices {
        &self.origins[layer_idx].choices
    }

    /// The numbers of the layers, rising: as a scene is opened they are counted from 0, and each layer has
    /// its number for as long as it is there, whichever others leave. Those that are added are counted on.
    pub fn layer_numbers(&self) -> Vec<usize> {
        self.origins.iter().map(|origin| origin.number).collect()
    }
}

fn retain<T>(all: &mut Vec<T>, keeps: &[bool]) {
    let mut keeps = keeps.iter();
    all.retain(|_| keeps.next() == Some(&true));
}

/// Keys name layers by their index.
fn retain_keys(film: &mut FilmFile, keeps: &[bool]) {
    let index_now = |idx: usize| keeps[..idx].iter().filter(|keeps| **keeps).count();
    for key in &mut film.keys {
        key.layers.retain(|of_key| keeps[of_key.layer_idx]);
        key.layers.iter_mut().for_each(|of_key| of_key.layer_idx = index_now(of_key.layer_idx));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::Scene;
    use slabsplat_io::{parse_scene, scene_text};

    fn opened(text: &str) -> OpenScene {
        OpenScene::open(&parse_scene(text, "a.toml").unwrap()).unwrap()
    }

    /// The scene of `again` over the volumes of `opened`, which have the same samples: layers are the same
    /// only if they share theirs.
    fn over_volumes_of(opened: &OpenScene, again: &OpenScene) -> Scene {
        let mut scene = again.scene.clone();
        for (layer, shared) in scene.layers.iter_mut().zip(&opened.scene.layers) {
            assert_eq!(layer.volume.samples(), shared.volume.samples());
            layer.volume = shared.volume.clone();
        }
        scene
    }

    const THREE: &str = r#"
        [[layers]]
        name = "a"
        volume = { generate = "sphere", size = 8 }
        [[layers]]
        name = "b"
        volume = { generate = "cube", size = 8 }
        [[layers]]
        name = "c"
        volume = { generate = "neuron", size = 8 }
        [film]
        [[film.keys]]
        at = 0.0
        layers = [{ layer = "a", opacity_scale = 0.5 }, { layer = "c", opacity_scale = 0.25 }]
        [[film.keys]]
        at = 2.0
        azimuth = 90.0
    "#;

    #[test]
    fn layers_that_stay_are_written_and_read_again() {
        let all = opened(THREE);
        for keeps in
            [[true, true, true], [false, true, true], [true, false, true], [false, false, true]]
        {
            let some = all.with_layers(&keeps);
            let text = scene_text(&some.to_file().unwrap(), "a.toml").unwrap();
            let again = opened(&text);
            assert_eq!(over_volumes_of(&some, &again), some.scene, "{keeps:?}");
            assert_eq!(again.sources.film, some.sources.film, "{keeps:?}");
            let keys = &some.sources.film.as_ref().unwrap().keys[0].layers;
            let scales: Vec<_> =
                keys.iter().map(|key| (key.layer_idx, key.opacity_scale)).collect();
            let of_c = (some.scene.layers.len() - 1, Some(0.25));
            let of_a = keeps[0].then_some((0, Some(0.5)));
            assert_eq!(scales, of_a.into_iter().chain([of_c]).collect::<Vec<_>>());
        }
        assert_eq!(all.with_layers(&[true; 3]).scene, all.scene);
    }

    #[test]
    fn numbers_of_layers_stay_theirs() {
        let mut some = opened(THREE).with_layers(&[true, false, true]);
        assert_eq!(some.layer_numbers(), [0, 2]);
        some.add_layers_of(opened(THREE).with_layers(&[false, true, true]));
        assert_eq!(some.layer_numbers(), [0, 2, 3, 4]);
        assert_eq!(some.with_layers(&[false, true, false, true]).layer_numbers(), [2, 4]);
    }

    #[test]
    fn layers_that_are_added_look_as_they_did() {
        let other = opened("volume = { generate = \"neuron\", size = 8 }");
        let mut both = opened("volume = { generate = \"cube\", size = 8 }");
        let (camera, settings) = (both.scene.camera, both.scene.settings.clone());
        both.add_layers_of(other.clone());
        assert_eq!(both.scene.layers[1], other.scene.layers[0]);
        assert_eq!((both.scene.camera, &both.scene.settings), (camera, &settings));
        let text = scene_text(&both.to_file().unwrap(), "a.toml").unwrap();
        assert_eq!(over_volumes_of(&both, &opened(&text)), both.scene);
    }

    #[test]
    fn opacities_by_gradients_are_found_for_modes_that_take_them() {
        let mut other = opened("volume = { generate = \"cube\", size = 8 }");
        let line = slabsplat_core::PiecewiseLinear::new("gradient", [(0.0, [0.0]), (9.0, [1.0])]);
        other.scene.layers[0].gradient_opacity = Some(line.unwrap());
        let mut both =
            opened("volume = { generate = \"cube\", size = 8 }\nrender = { mode = \"maximum\" }");
        both.add_layers_of(other.clone());
        assert_eq!(both.scene.layers[1].gradient_opacity, None);
        let mut both = opened("volume = { generate = \"cube\", size = 8 }");
        both.add_layers_of(other.clone());
        assert_eq!(both.scene.layers[1], other.scene.layers[0]);
    }

    #[test]
    fn what_measured_the_first_volume_goes_with_it() {
        let mut both = opened("volume = { generate = \"cube\", size = 8 }");
        let mut other = opened("volume = { generate = \"sphere\", size = 8 }");
        let metric = Acquisition::default().metric();
        other.acquisition = metric;
        other.origins[0].acquisition = metric;
        both.add_layers_of(other);
        assert!(!both.acquisition.is_metric);
        assert!(both.with_layers(&[false, true]).acquisition.is_metric);
        assert!(!both.with_layers(&[true, false]).acquisition.is_metric);
    }
}
