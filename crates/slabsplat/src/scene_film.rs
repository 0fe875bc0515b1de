//! The film of a scene file.

use crate::{OpenError, OpenScene};
use slabsplat_core::{Camera, Grid};
use slabsplat_film::{Film, Key, LayerKey, Turn};
use slabsplat_io::{FilmFile, KeyFile, KeyLayerFile, TurnFile};

impl OpenScene {
    /// The film of the scene, as it is now, with the key frames of its file, which are in
    /// [`sources`](Self::sources); `None` if that has no key frames.
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
        let grids: Vec<Grid> = self.scene.layers.iter().map(|layer| *layer.volume.grid()).collect();
        self.film_on(&grids)
    }

    /// The same of layers on those grids, for which volumes on others may stand.
    pub(crate) fn film_on(&self, grids: &[Grid]) -> Result<Option<Film>, OpenError> {
        let has_keys = |file: &&FilmFile| !file.keys.is_empty();
        let Some(file) = self.sources.film.as_ref().filter(has_keys) else { return Ok(None) };
        let mut keys = Vec::with_capacity(file.keys.len());
        let mut camera = self.scene.camera;
        for key in &file.keys {
            let easing = key.easing.unwrap_or(file.easing);
            keys.push(Self::key(key, grids, &mut camera)?.easing(easing));
        }
        let last = keys.last().map_or(0.0, |key: &Key| key.at_secs);
        let seconds = file.seconds.unwrap_or(last);
        Ok(Some(Film::on_grids(&self.scene, grids, &keys, (seconds, file.is_loop), file.easing)?))
    }

    /// The turn of the scene, in so many frames, if its file has one instead of key frames.
    pub fn turn(&self, n_frames: u32) -> Option<Turn> {
        let TurnFile { axis, degrees, is_rocking, .. } = self.sources.film.as_ref()?.turn?;
        let turn = Turn::new(axis, degrees, n_frames);
        Some(if is_rocking { turn.rocking() } else { turn })
    }

    /// A key, whose camera has what it leaves out from `camera`, and is that from now on.
    fn key(key: &KeyFile, grids: &[Grid], camera: &mut Camera) -> Result<Key, OpenError> {
        if let Some(desc) = &key.camera {
            *camera = desc.complete(camera)?;
        }
        let layers = key.layers.iter().map(|layer| Self::layer_key(layer, &grids[layer.layer_idx]));
        let mut moment = Key::at(key.at_secs);
        moment.camera = key.camera.map(|_| *camera);
        moment.azimuth_degrees = key.azimuth_degrees;
        moment.slab_width = key.slab_width;
        moment.layers = layers.collect::<Result<_, _>>()?;
        Ok(moment)
    }

    fn layer_key(layer: &KeyLayerFile, grid: &Grid) -> Result<LayerKey, OpenError> {
        let mut moment = LayerKey::new(layer.layer_idx);
        moment.transfer = layer.look.as_ref().and_then(|look| look.transfer.clone());
        moment.isosurfaces = layer.isosurfaces.clone();
        moment.region = layer.region.as_ref().map(|region| region.on(grid)).transpose()?;
        moment.opacity_scale = layer.opacity_scale;
        Ok(moment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::TurnAxis;
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
    fn scene_film_may_be_a_turn() {
        let text =
            |film: &str| format!("volume = {{ generate = \"cube\", size = 8 }}\n[film]\n{film}");
        let open = |film: &str| {
            let file = parse_scene(&text(film), "turn.toml").map_err(|error| error.to_string())?;
            Ok::<_, String>(OpenScene::open(&file).unwrap())
        };
        let opened =
            open("seconds = 2\nturn = { axis = \"x\", degrees = -90, rock = true }").unwrap();
        let turn = opened.turn(5).unwrap();
        assert_eq!(
            (turn.axis, turn.degrees, turn.is_rocking, turn.n_frames),
            (TurnAxis::X, -90.0, true, 5)
        );
        assert!(opened.film().unwrap().is_none(), "it has no key frames");
        let saved = opened.to_file().unwrap();
        let read = parse_scene(&scene_text(&saved, "turn.toml").unwrap(), "turn.toml").unwrap();
        assert_eq!(read, saved);
        let short = open("turn = { degrees = 360 }").unwrap().turn(1).unwrap();
        assert_eq!((short.axis, short.is_rocking), (TurnAxis::Up, false));
        assert!(open("seconds = 3").unwrap().turn(1).is_none());
        for (film, what) in [
            ("turn = { degrees = 9 }\nloop = true", "a film is made by turn or by keys"),
            ("turn = { degrees = 9 }\nkeys = [{ at = 1 }]", "a film is made by turn or by keys"),
            ("turn = { degrees = 1e9 }", "degrees of a turn are up to 360000 either way"),
            ("turn = { degrees = nan }", "degrees of a turn are up to 360000 either way"),
            ("turn = { axis = \"down\", degrees = 9 }", "use one of up, right, x, y, z"),
        ] {
            let error = open(film).err().unwrap();
            assert!(error.contains(what), "{error}");
        }
    }

    #[test]
    fn scene_film_changes_isosurfaces() {
        let text = r#"
            volume = { generate = "cube", size = 8 }
            classify = { preset = "gray", isosurfaces = [{ value = 50, opacity = 0.5 }] }
            render = { mode = "isosurfaces", method = "post-classified" }
            [[film.keys]]
            at = 2
            classify = { isosurfaces = [{ value = 150, opacity = 1 }] }
        "#;
        let opened = OpenScene::open(&parse_scene(text, "iso.toml").unwrap()).unwrap();
        let film = opened.film().unwrap().unwrap();
        let half = film.scene_at(1.0).unwrap().layers[0].clone();
        assert_eq!((half.isosurfaces[0].value(), half.isosurfaces[0].opacity()), (100.0, 0.75));
        assert_eq!(half.transfer, opened.scene.layers[0].transfer);
        let saved = opened.to_file().unwrap();
        let read = parse_scene(&scene_text(&saved, "iso.toml").unwrap(), "iso.toml").unwrap();
        assert_eq!(read, saved);
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
