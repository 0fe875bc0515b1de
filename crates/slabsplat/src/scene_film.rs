//! The film of a scene file.

use crate::{OpenError, OpenScene};
use slabsplat_core::Camera;
use slabsplat_film::{Film, Key, LayerKey};
use slabsplat_io::{KeyFile, KeyLayerFile};

impl OpenScene {
    /// The film of the scene, as it is now, with the key frames of its file, which are in
    /// [`sources`](Self::sources); `None` if that has none.
    ///
    /// ```
    /// use slabsplat::{OpenScene, io};
    ///
    /// let text = r#"
    ///     volume = { generate = "cube", size = 16 }
    ///     [film]
    ///     loop = true
    ///     [[film.keys]]
    ///     at = 4
    ///     azimuth = 360
    /// "#;
    /// let scene = OpenScene::open(&io::parse_scene(text, "cube.toml")?)?;
    /// let film = scene.film()?.expect("there is one");
    /// assert_eq!(film.seconds(), 4.0);
    /// let beside = film.scene_at(1.0)?.camera;
    /// assert!(0.9 < beside.axes().right.dot(-scene.scene.camera.axes().forward).abs());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If keys make no film, or what one says of a camera or a region makes none.
    pub fn film(&self) -> Result<Option<Film>, OpenError> {
        let Some(file) = &self.sources.film else { return Ok(None) };
        let mut keys = Vec::with_capacity(file.keys.len());
        let mut camera = self.scene.camera;
        for key in &file.keys {
            let easing = key.easing.unwrap_or(file.easing);
            keys.push(Key { easing, ..self.key(key, &mut camera)? });
        }
        let last = keys.last().map_or(0.0, |key: &Key| key.at_secs);
        let seconds = file.seconds.unwrap_or(last);
        Ok(Some(Film::new(&self.scene, &keys, seconds, file.easing, file.is_loop)?))
    }

    /// A key, whose camera has what it leaves out from `camera`, and is that from now on.
    fn key(&self, key: &KeyFile, camera: &mut Camera) -> Result<Key, OpenError> {
        if let Some(desc) = &key.camera {
            *camera = desc.complete(camera)?;
        }
        let layers = key.layers.iter().map(|layer| self.layer_key(layer));
        Ok(Key {
            at_secs: key.at_secs,
            camera: key.camera.map(|_| *camera),
            azimuth_degrees: key.azimuth_degrees,
            slab_width: key.slab_width,
            layers: layers.collect::<Result<_, _>>()?,
            ..Key::default()
        })
    }

    fn layer_key(&self, layer: &KeyLayerFile) -> Result<LayerKey, OpenError> {
        let grid = self.scene.layers[layer.layer_idx].volume.grid();
        Ok(LayerKey {
            layer_idx: layer.layer_idx,
            transfer: layer.look.as_ref().and_then(|look| look.transfer.clone()),
            region: layer.region.as_ref().map(|region| region.on(grid)).transpose()?,
            opacity_scale: layer.opacity_scale,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::glam::DVec3;
    use slabsplat_io::{parse_scene, scene_text};

    const TWO: &str = r#"
        [[layers]]
        name = "first"
        volume = { generate = "cube", size = 8 }
        [[layers]]
        name = "hidden"
        visible = false
        volume = { generate = "cube", size = 8 }
        [[layers]]
        name = "second"
        volume = { generate = "sphere", size = 8 }
        classify = { preset = "gray" }
        [camera]
        eye = [0, -50, 0]
        target = [0, 0, 0]
        up = [0, 0, 1]
        view_height = 20
        [film]
        seconds = 5
        easing = "ease-in"
        [[film.keys]]
        at = 2
        camera = { target = [3, 0, 0] }
        layers = [{ layer = "second", opacity_scale = 0.0, region = { planes = [[1, 0, 0, 0]] } },
            { layer = "hidden", opacity_scale = 0.5 }]
        [[film.keys]]
        at = 4.5
        camera = { view_height = 5 }
        slab_width = 2
        layers = [{ layer = 0, classify = { opacity = [[0, 0], [255, 0.5]] } }]
    "#;

    #[test]
    fn scene_film_is_that_of_the_file() {
        let opened = OpenScene::open(&parse_scene(TWO, "two.toml").unwrap()).unwrap();
        let film = opened.film().unwrap().unwrap();
        assert_eq!(film.seconds(), 5.0);
        let at = |seconds| film.scene_at(seconds).unwrap();
        // A target alone moves the eye along, and stays.
        assert_eq!(at(2.0).camera.eye(), DVec3::new(3.0, -50.0, 0.0));
        assert_eq!(at(4.5).camera.target(), DVec3::new(3.0, 0.0, 0.0));
        assert_eq!(at(5.0).layers[1].transfer.opacity(200.0), 0.0);
        assert!(
            at(5.0).layers[0].transfer.opacity(255.0) == 0.5
                && at(0.0).layers[1] == opened.scene.layers[1]
        );
        assert!(at(2.0).layers[1].region.contains([-1.0, 0.0, 0.0]));
        assert!(!at(2.0).layers[1].region.contains([1.0, 0.0, 0.0]));
        assert_eq!(at(4.5).settings.slab_width, 2.0);
    }

    #[test]
    fn scene_film_goes_on_in_a_saved_scene() {
        let opened = OpenScene::open(&parse_scene(TWO, "two.toml").unwrap()).unwrap();
        let saved = opened.to_file().unwrap();
        let text = scene_text(&saved, "two.toml").unwrap();
        let read = parse_scene(&text, "two.toml").unwrap();
        assert_eq!(read, saved, "{text}");
        let again = OpenScene::open(&read).unwrap().film().unwrap().unwrap();
        let film = opened.film().unwrap().unwrap();
        for seconds in [0.0, 1.0, 3.0, 4.6] {
            let [a, b] = [&film, &again].map(|film| film.scene_at(seconds).unwrap());
            assert_eq!((a.camera, a.settings), (b.camera, b.settings), "{seconds}");
            for (a, b) in a.layers.iter().zip(&b.layers) {
                assert_eq!((&a.transfer, &a.region), (&b.transfer, &b.region), "{seconds}");
            }
        }
    }
}
