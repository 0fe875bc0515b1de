//! A film: a scene, and key frames of what changes.

use super::camera::CameraPath;
use super::isosurfaces::IsosurfacePath;
use super::region::RegionPath;
use super::track::Track;
use super::transfer::TransferPath;
use slabsplat_core::{
    Camera, CameraError, Easing, Grid, Isosurface, IsosurfaceError, LabelError, LabelStyle, Labels,
    Layer, LightError, Region, RegionError, Scene, TransferError, TransferFunction,
};
use thiserror::Error;

/// How things are at a moment. What a key leaves out continues from the key before that says it to the next.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Key {
    /// When, in seconds.
    pub at_secs: f64,
    /// How time passes from here to the next key.
    pub easing: Easing,
    /// Where the scene is seen from.
    pub camera: Option<Camera>,
    /// How far that camera has then gone to its own right around what it looks at, in degrees: beyond half a
    /// turn, which two cameras cannot say.
    pub azimuth_degrees: Option<f64>,
    /// Width of slabs, in voxel steps.
    pub slab_width: Option<f64>,
    /// What changes of layers.
    pub layers: Vec<LayerKey>,
}

/// How a layer is at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LayerKey {
    /// Which of the scene's layers.
    pub layer_idx: usize,
    /// Which of its values are visible, and in which colour.
    pub transfer: Option<TransferFunction>,
    /// Where it is seen.
    pub region: Option<Region>,
    /// The densities at which it has surfaces: as many as in the scene, each with a colour in all keys or in
    /// none.
    pub isosurfaces: Option<Vec<Isosurface>>,
    /// What its opacities are multiplied with, at least 0: with 0 it is not there.
    pub opacity_scale: Option<f64>,
}

impl Key {
    /// A moment, at which nothing changes yet.
    pub fn at(at_secs: f64) -> Self {
        Self { at_secs, ..Self::default() }
    }

    /// The same with time that passes so until the next key.
    #[must_use]
    pub fn easing(self, easing: Easing) -> Self {
        Self { easing, ..self }
    }

    /// The same seen by that camera.
    #[must_use]
    pub fn camera(self, camera: Camera) -> Self {
        Self { camera: Some(camera), ..self }
    }

    /// The same with a camera that has gone so far around what it looks at.
    #[must_use]
    pub fn azimuth_degrees(self, degrees: f64) -> Self {
        Self { azimuth_degrees: Some(degrees), ..self }
    }

    /// The same in slabs of that width.
    #[must_use]
    pub fn slab_width(self, slab_width: f64) -> Self {
        Self { slab_width: Some(slab_width), ..self }
    }

    /// The same with another layer that changes.
    #[must_use]
    pub fn layer(mut self, layer: LayerKey) -> Self {
        self.layers.push(layer);
        self
    }
}

impl LayerKey {
    /// One of the scene's layers, of which nothing changes yet.
    pub fn new(layer_idx: usize) -> Self {
        Self { layer_idx, ..Self::default() }
    }

    /// The same with that transfer function.
    #[must_use]
    pub fn transfer(self, transfer: TransferFunction) -> Self {
        Self { transfer: Some(transfer), ..self }
    }

    /// The same seen there.
    #[must_use]
    pub fn region(self, region: Region) -> Self {
        Self { region: Some(region), ..self }
    }

    /// The same with these surfaces.
    #[must_use]
    pub fn isosurfaces(self, isosurfaces: Vec<Isosurface>) -> Self {
        Self { isosurfaces: Some(isosurfaces), ..self }
    }

    /// The same with opacities multiplied with that.
    #[must_use]
    pub fn opacity_scale(self, opacity_scale: f64) -> Self {
        Self { opacity_scale: Some(opacity_scale), ..self }
    }
}

/// A scene that changes.
///
/// ```
/// # use slabsplat_core::*;
/// # let grid = Grid::with_spacing([2, 2, 2], [1.0; 3])?;
/// # let volume = Volume::new(grid, vec![0_u8; 8].into(), Scaling::IDENTITY)?;
/// # let transfer = TransferFunction::new([(0.0, 0.5)], [(0.0, [1.0; 3])])?;
/// # let view = Projection::Orthographic { view_height: 4.0 };
/// # let camera = Camera::new([9.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0], view)?;
/// # let scene = Scene::new(Layer::new(volume, transfer), camera);
/// use slabsplat_film::{Film, Key};
///
/// let above = Camera::new([0.1, 0.0, 9.0], [0.0; 3], [0.0, 0.0, 1.0], view)?;
/// let keys = [Key::at(2.0).camera(above)];
/// let film = Film::new(&scene, &keys, 2.0, Easing::EaseInOut, false)?;
/// assert_eq!(film.scene_at(0.0)?.camera, scene.camera);
/// assert_eq!(film.scene_at(2.0)?.camera, above);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Film {
    scene: Scene,
    seconds: f64,
    is_loop: bool,
    camera: Option<CameraPath>,
    azimuth_degrees: Option<Numbers>,
    slab_width: Option<Numbers>,
    layers: Vec<LayerPath>,
}

#[derive(Clone, Debug, Default)]
struct LayerPath {
    transfer: Option<TransferPath>,
    isosurfaces: Option<IsosurfacePath>,
    region: Option<RegionPath>,
    opacity_scale: Option<Numbers>,
}

/// Why there is no such film.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MotionError {
    /// Keys are not in order.
    #[error(
        "key {key_idx} is at {at_secs} seconds: keys begin at 0, each is later than the one before"
    )]
    OutOfOrder {
        /// Which, from 0 on.
        key_idx: usize,
        /// When.
        at_secs: f64,
    },
    /// A key is never reached.
    #[error("key {key_idx} is at {at_secs} seconds, and the film ends at {seconds}")]
    BehindEnd {
        /// Which, from 0 on.
        key_idx: usize,
        /// When.
        at_secs: f64,
        /// How long the film is.
        seconds: f64,
    },
    /// The film has no length.
    #[error(
        "a film lasts a positive number of seconds, and not {0}: its last key, or `seconds`, says how long"
    )]
    NoLength(f64),
    /// A number is out of its range.
    #[error("{what} of key {key_idx} is {value}, and must be {range}")]
    BadNumber {
        /// Which, from 0 on.
        key_idx: usize,
        /// What.
        what: &'static str,
        /// What it is.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// There is no such layer.
    #[error("key {key_idx} is about layer {layer_idx}, and the scene has {n_layers}, from 0 on")]
    NoLayer {
        /// Which key, from 0 on.
        key_idx: usize,
        /// Which layer.
        layer_idx: usize,
        /// How many there are.
        n_layers: usize,
    },
    /// A layer is not shown by a transfer function of its values.
    #[error("a key changes the {what} of layer {layer_idx}, which is shown by {by}")]
    NotByValue {
        /// Which layer.
        layer_idx: usize,
        /// What.
        what: &'static str,
        /// What shows it.
        by: &'static str,
    },
    /// Nothing lies between a surface and none.
    #[error(
        "keys change the isosurfaces of layer {layer_idx}: the scene and each of these keys need as many, each with \
         a colour in all of them or in none; one of opacity 0 is not seen"
    )]
    OtherIsosurfaces {
        /// Which layer.
        layer_idx: usize,
    },
    /// Nothing lies between parallel rays and rays from an eye.
    #[error("the cameras of a film are all orthographic, or all perspective")]
    TwoProjections,
    /// Nothing lies between a region and its complement.
    #[error("a layer's region is inverted in the scene and all keys, or in none")]
    TwoSides,
    /// Numbers do not suffice for a camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// Or for a light.
    #[error(transparent)]
    Light(#[from] LightError),
    /// Or for a transfer function.
    #[error(transparent)]
    Transfer(#[from] TransferError),
    /// Or for a region.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// Or for an isosurface.
    #[error(transparent)]
    Isosurface(#[from] IsosurfaceError),
    /// Or for labels.
    #[error(transparent)]
    Labels(#[from] LabelError),
}

/// A number over time.
#[derive(Clone, Debug)]
struct Numbers {
    track: Track,
    values: Vec<f64>,
}

impl Numbers {
    fn at(&self, seconds: f64) -> f64 {
        self.track.number(self.track.at(seconds), |idx| self.values[idx])
    }
}

impl Film {
    /// A scene that changes from key to key.
    ///
    /// The scene itself is how things are at 0 seconds, where no key says otherwise, and `easing` how time
    /// passes from there to the first key. If the film `is_loop`, all goes back from the last key to the
    /// beginning until `seconds` are over, unless the last key is at the end.
    ///
    /// # Errors
    /// If keys are not in order or beyond the end, or a number or a layer is none.
    pub fn new(
        scene: &Scene,
        keys: &[Key],
        seconds: f64,
        easing: Easing,
        is_loop: bool,
    ) -> Result<Self, MotionError> {
        let grids: Vec<Grid> = scene.layers.iter().map(|layer| *layer.volume.grid()).collect();
        Self::on_grids(scene, &grids, keys, (seconds, is_loop), easing)
    }

    /// The same of layers on those grids, for which volumes on others may stand, as overviews do for volumes
    /// that are drawn box by box.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    ///
    /// # Panics
    /// If there are fewer grids than layers.
    pub fn on_grids(
        scene: &Scene,
        grids: &[Grid],
        keys: &[Key],
        (seconds, is_loop): (f64, bool),
        easing: Easing,
    ) -> Result<Self, MotionError> {
        check(scene, keys, seconds)?;
        let spans = Spans { keys, seconds, easing, is_loop };
        let camera = spans.of(&scene.camera, |key| key.camera);
        let numbers = |(track, values)| Numbers { track, values };
        let layers = scene.layers.iter().enumerate();
        let layers = layers.map(|(idx, layer)| LayerPath::new(&spans, layer, idx, &grids[idx]));
        Ok(Self {
            camera: camera.map(|(track, cameras)| CameraPath::new(track, cameras)).transpose()?,
            azimuth_degrees: spans.of(&0.0, |key| key.azimuth_degrees).map(numbers),
            slab_width: spans.of(&scene.settings.slab_width, |key| key.slab_width).map(numbers),
            layers: layers.collect::<Result<_, _>>()?,
            scene: scene.clone(),
            seconds,
            is_loop,
        })
    }

    /// How long it is.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The moment of a frame. The last frame is the end, or of what loops, one step before the first.
    pub fn seconds_of(&self, frame_idx: u32, n_frames: u32) -> f64 {
        let n_steps = if self.is_loop { n_frames } else { n_frames.saturating_sub(1) };
        self.seconds * f64::from(frame_idx) / f64::from(n_steps.max(1))
    }

    /// The scene at a moment.
    ///
    /// # Errors
    /// If numbers do not suffice.
    pub fn scene_at(&self, seconds: f64) -> Result<Scene, MotionError> {
        let mut scene = self.scene.clone();
        if let Some(path) = &self.camera {
            scene.camera = path.at(seconds)?;
        }
        if let Some(degrees) = &self.azimuth_degrees {
            scene.camera = scene.camera.orbited(degrees.at(seconds).to_radians());
        }
        if let Some(width) = &self.slab_width {
            scene.settings.slab_width = width.at(seconds);
        }
        for (layer, path) in scene.layers.iter_mut().zip(&self.layers) {
            path.lay_on(layer, seconds)?;
        }
        Ok(scene)
    }
}

impl LayerPath {
    fn new(
        spans: &Spans<'_>,
        layer: &Layer,
        layer_idx: usize,
        grid: &Grid,
    ) -> Result<Self, MotionError> {
        let of_key = |key: &Key| key.layers.iter().find(|it| it.layer_idx == layer_idx).cloned();
        let transfer = spans.of(&layer.transfer, |key| of_key(key)?.transfer);
        let isosurfaces = spans.of(&layer.isosurfaces, |key| of_key(key)?.isosurfaces);
        let region = spans.of(&layer.region, |key| of_key(key)?.region);
        let opacity_scale = spans.of(&1.0, |key| of_key(key)?.opacity_scale);
        let what =
            [("transfer function", transfer.is_some()), ("opacity", opacity_scale.is_some())];
        let what = what.into_iter().find_map(|(what, changes)| changes.then_some(what));
        if let (Some(what), true) = (what, layer.transfer_2d.is_some()) {
            let by = "values and gradients together";
            return Err(MotionError::NotByValue { layer_idx, what, by });
        }
        Ok(Self {
            transfer: transfer.map(|(track, keys)| TransferPath::new(track, &keys)),
            isosurfaces: isosurfaces
                .map(|(track, keys)| IsosurfacePath::new(track, keys, layer_idx))
                .transpose()?,
            region: region.map(|(track, keys)| RegionPath::new(track, keys, grid)).transpose()?,
            opacity_scale: opacity_scale.map(|(track, values)| Numbers { track, values }),
        })
    }

    fn lay_on(&self, layer: &mut Layer, seconds: f64) -> Result<(), MotionError> {
        if let Some(path) = &self.transfer {
            layer.transfer = path.at(seconds)?;
        }
        if let Some(path) = &self.isosurfaces {
            layer.isosurfaces = path.at(seconds)?;
        }
        if let Some(path) = &self.region {
            layer.region = path.at(seconds)?;
        }
        if let Some(scale) = self.opacity_scale.as_ref().map(|numbers| numbers.at(seconds)) {
            layer.transfer = scaled(&layer.transfer, scale);
            let surfaces = layer.isosurfaces.iter().map(|surface| scaled_surface(surface, scale));
            layer.isosurfaces = surfaces.collect::<Result<_, _>>()?;
            layer.labels =
                layer.labels.take().map(|labels| scaled_labels(&labels, scale)).transpose()?;
        }
        Ok(())
    }
}

fn scaled(transfer: &TransferFunction, scale: f64) -> TransferFunction {
    let opacity = transfer.opacity_points().multiplied(scale);
    TransferFunction::of_curves(opacity, transfer.color_points().clone())
}

fn scaled_surface(surface: &Isosurface, scale: f64) -> Result<Isosurface, IsosurfaceError> {
    Isosurface::new(surface.value(), (surface.opacity() * scale).min(1.0), surface.color())
}

/// Styles with a transfer function of their own are scaled as the layer's is.
fn scaled_labels(labels: &Labels, scale: f64) -> Result<Labels, LabelError> {
    let style = |style: &LabelStyle| {
        let mut style = style.clone();
        style.transfer = style.transfer.map(|transfer| scaled(&transfer, scale));
        style
    };
    let styles = labels.styles().iter().map(|(label, its)| (*label, style(its)));
    labels.with_styles(styles)
}

/// What tells which keys are about something.
struct Spans<'a> {
    keys: &'a [Key],
    seconds: f64,
    easing: Easing,
    is_loop: bool,
}

impl Spans<'_> {
    /// Moments and values of something that is `at_first` in the scene; `None` if no key is about it.
    fn of<T: Clone>(
        &self,
        at_first: &T,
        of_key: impl Fn(&Key) -> Option<T>,
    ) -> Option<(Track, Vec<T>)> {
        let said = self.keys.iter().filter_map(|key| Some((key.at_secs, key.easing, of_key(key)?)));
        let mut said: Vec<(f64, Easing, T)> = said.collect();
        if 0.0 < said.first()?.0 {
            said.insert(0, (0.0, self.easing, at_first.clone()));
        }
        let (first, last) = (said.first()?.2.clone(), said.last()?);
        if self.is_loop && last.0 < self.seconds {
            said.push((self.seconds, Easing::Linear, first));
        }
        let track = Track::new(said.iter().map(|(at, easing, _)| (*at, *easing)), self.is_loop);
        Some((track, said.into_iter().map(|(_, _, value)| value).collect()))
    }
}

fn check(scene: &Scene, keys: &[Key], seconds: f64) -> Result<(), MotionError> {
    if !(seconds.is_finite() && 0.0 < seconds) {
        return Err(MotionError::NoLength(seconds));
    }
    let mut before = f64::NEG_INFINITY;
    for (key_idx, key) in keys.iter().enumerate() {
        let at_secs = key.at_secs;
        if !(at_secs.is_finite() && 0.0 <= at_secs && before < at_secs) {
            return Err(MotionError::OutOfOrder { key_idx, at_secs });
        }
        if seconds < at_secs {
            return Err(MotionError::BehindEnd { key_idx, at_secs, seconds });
        }
        before = at_secs;
        check_numbers(key, key_idx)?;
        for layer in &key.layers {
            let (layer_idx, n_layers) = (layer.layer_idx, scene.layers.len());
            if n_layers <= layer_idx {
                return Err(MotionError::NoLayer { key_idx, layer_idx, n_layers });
            }
        }
    }
    Ok(())
}

fn check_numbers(key: &Key, key_idx: usize) -> Result<(), MotionError> {
    let scales =
        key.layers.iter().map(|layer| ("opacity_scale", layer.opacity_scale, 0.0, "at least 0"));
    let own = [
        ("azimuth", key.azimuth_degrees, f64::NEG_INFINITY, "finite"),
        ("slab_width", key.slab_width, f64::MIN_POSITIVE, "positive"),
    ];
    for (what, value, least, range) in own.into_iter().chain(scales) {
        if let Some(value) = value.filter(|value| !value.is_finite() || *value < least) {
            return Err(MotionError::BadNumber { key_idx, what, value, range });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat_core::{Grid, Projection, Samples, Scaling, Volume};

    fn scene() -> Scene {
        let grid = Grid::with_spacing([4, 4, 4], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, Samples::U8(vec![7; 64]), Scaling::IDENTITY).unwrap();
        let transfer = TransferFunction::new([(0.0, 0.0), (9.0, 0.8)], [(0.0, [1.0; 3])]).unwrap();
        let view = Projection::Orthographic { view_height: 8.0 };
        let camera = Camera::new([9.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0], view).unwrap();
        Scene::new(Layer::new(volume, transfer), camera)
    }

    fn key(at_secs: f64) -> Key {
        Key { at_secs, ..Key::default() }
    }

    fn film(keys: &[Key], seconds: f64, is_loop: bool) -> Result<Film, MotionError> {
        Film::new(&scene(), keys, seconds, Easing::Linear, is_loop)
    }

    #[test]
    fn film_without_keys_stands_still() {
        let scene = scene();
        let film = Film::new(&scene, &[], 3.0, Easing::Linear, false).unwrap();
        assert_eq!([0.0, 1.0, 3.0].map(|at| film.scene_at(at).unwrap() == scene), [true; 3]);
    }

    #[test]
    fn film_begins_with_the_scene() {
        let keys = [Key { slab_width: Some(3.0), ..key(2.0) }];
        let there = film(&keys, 4.0, false).unwrap();
        let width = |at| there.scene_at(at).unwrap().settings.slab_width;
        assert_eq!([0.0, 1.0, 2.0, 4.0].map(width), [1.0, 2.0, 3.0, 3.0]);
        let again = film(&keys, 4.0, true).unwrap();
        let width = |at| again.scene_at(at).unwrap().settings.slab_width;
        assert_eq!([0.0, 2.0, 4.0].map(width), [1.0, 3.0, 1.0]);
        let at_first = [Key { slab_width: Some(5.0), ..key(0.0) }];
        let one = film(&at_first, 4.0, false).unwrap();
        assert_eq!([0.0, 4.0].map(|at| one.scene_at(at).unwrap().settings.slab_width), [5.0; 2]);
    }

    #[test]
    fn film_goes_around_more_than_half() {
        let keys = [Key { azimuth_degrees: Some(360.0), ..key(4.0) }];
        let film = film(&keys, 4.0, true).unwrap();
        let eye = |at| film.scene_at(at).unwrap().camera.eye();
        assert!(eye(1.0).abs_diff_eq([0.0, 9.0, 0.0].into(), 1e-9), "{}", eye(1.0));
        assert!(eye(2.0).abs_diff_eq([-9.0, 0.0, 0.0].into(), 1e-9));
        assert_eq!([0, 1, 3].map(|idx| film.seconds_of(idx, 4)), [0.0, 1.0, 3.0]);
    }

    #[test]
    fn film_fades_a_layer() {
        let hidden = LayerKey { opacity_scale: Some(0.0), ..LayerKey::default() };
        let keys = [Key { layers: vec![hidden], ..key(2.0) }];
        let film = film(&keys, 2.0, false).unwrap();
        let opacity = |at| film.scene_at(at).unwrap().layers[0].transfer.opacity(9.0);
        assert_eq!([0.0, 1.0, 2.0].map(opacity), [0.8, 0.4, 0.0]);
        assert_eq!([0, 1, 2].map(|idx| film.seconds_of(idx, 3)), [0.0, 1.0, 2.0]);
    }

    #[test]
    fn film_changes_isosurfaces() {
        let mut scene = scene();
        let surfaces = |value, opacity| vec![Isosurface::new(value, opacity, None).unwrap()];
        scene.layers[0].isosurfaces = surfaces(2.0, 0.5);
        let moved = LayerKey { isosurfaces: Some(surfaces(6.0, 1.0)), ..LayerKey::default() };
        let faded = LayerKey { opacity_scale: Some(0.0), ..LayerKey::default() };
        let keys =
            [Key { layers: vec![moved], ..key(2.0) }, Key { layers: vec![faded], ..key(4.0) }];
        let film = Film::new(&scene, &keys, 4.0, Easing::Linear, false).unwrap();
        let at = |seconds| film.scene_at(seconds).unwrap().layers[0].isosurfaces.clone();
        assert_eq!(at(0.0), surfaces(2.0, 0.5));
        assert_eq!(at(1.0), surfaces(4.0, 0.75 * 0.75));
        assert_eq!(at(4.0), surfaces(6.0, 0.0));
        let none = LayerKey { isosurfaces: Some(Vec::new()), ..LayerKey::default() };
        let keys = [Key { layers: vec![none], ..key(2.0) }];
        let error = Film::new(&scene, &keys, 4.0, Easing::Linear, false).unwrap_err();
        assert_eq!(error, MotionError::OtherIsosurfaces { layer_idx: 0 });
    }

    #[test]
    fn film_says_what_is_wrong() {
        let check = |keys: &[Key], seconds: f64, expected: &str| {
            assert_eq!(film(keys, seconds, false).unwrap_err().to_string(), expected);
        };
        check(
            &[],
            0.0,
            "a film lasts a positive number of seconds, and not 0: its last key, or `seconds`, says how long",
        );
        check(
            &[key(1.0), key(1.0)],
            2.0,
            "key 1 is at 1 seconds: keys begin at 0, each is later than the one before",
        );
        check(&[key(3.0)], 2.0, "key 0 is at 3 seconds, and the film ends at 2");
        let thin = Key { slab_width: Some(0.0), ..key(1.0) };
        check(&[thin], 2.0, "slab_width of key 0 is 0, and must be positive");
        let layers = vec![LayerKey { layer_idx: 1, ..LayerKey::default() }];
        check(
            &[Key { layers, ..key(1.0) }],
            2.0,
            "key 0 is about layer 1, and the scene has 1, from 0 on",
        );
    }
}
