//! Small pictures of a volume by each preset: drawn when nothing else is to be, one at a time, and kept until
//! the volume is another.

use super::Document;
use super::thinned::thinned;
use slabsplat::io::{PRESET_NAMES, TransferSource, preset};
use slabsplat::{Aim, Finish, Fit, ImageDesc, OpenScene, RenderSettings, TransferFunction, Volume};
use std::sync::Arc;

/// Pixels of a side.
pub const THUMBNAIL_SIDE: u32 = 64;

/// What is not seen in so few pixels, and takes its time.
const TOLERANCE: f64 = 0.2;

/// Volumes whose pictures are kept, as of several layers.
const N_VOLUMES: usize = 4;

/// Larger volumes would take as much memory again, for what is retained of each of them for frames: they are
/// thinned, to voxels that still are smaller than the pixels.
const MAX_VOXELS: usize = if cfg!(target_arch = "wasm32") { 1 << 23 } else { 1 << 26 };
const N_THINNED: usize = 1 << 21;

/// Numbers of requests for small pictures, so that no other has them.
const FIRST_NUMBER: u64 = 1 << 63;

/// Small pictures by presets, as `P` has them.
pub struct Thumbnails<P> {
    /// The newest last.
    volumes: Vec<(Arc<Volume>, Vec<Part<P>>)>,
    n_asked: u64,
    pending: Option<Pending>,
}

#[derive(Clone)]
enum Part<P> {
    Wanted,
    Drawn(P),
    Impossible,
}

/// What is being made. It is of the newest volume, or else it is forgotten.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pending {
    preset_idx: usize,
    /// The number of the request, once it is asked for.
    number: Option<u64>,
}

impl<P> std::fmt::Debug for Thumbnails<P> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Thumbnails").field("n_asked", &self.n_asked).finish_non_exhaustive()
    }
}

impl<P> Default for Thumbnails<P> {
    fn default() -> Self {
        Self { volumes: Vec::new(), n_asked: 0, pending: None }
    }
}

impl<P: Clone> Thumbnails<P> {
    /// Whether a request's number is of a small picture.
    pub fn is_number(number: u64) -> bool {
        FIRST_NUMBER <= number
    }

    /// The pictures that are wanted are of that volume from now on.
    pub fn are_of(&mut self, volume: &Arc<Volume>) {
        let known = self.volumes.iter().position(|(of, _)| Arc::ptr_eq(of, volume));
        if known.is_none_or(|idx| idx + 1 < self.volumes.len()) {
            self.pending = None;
            let parts = known.map(|idx| self.volumes.remove(idx).1);
            let parts = parts.unwrap_or_else(|| vec![Part::Wanted; PRESET_NAMES.len()]);
            self.volumes.push((volume.clone(), parts));
            let n_over = self.volumes.len().saturating_sub(N_VOLUMES);
            self.volumes.drain(..n_over);
        }
    }

    /// The preset whose picture is to be made next, if any is and nothing is being made.
    pub fn begin_next(&mut self) -> Option<usize> {
        if self.pending.is_some() {
            return None;
        }
        let (_, parts) = self.volumes.last()?;
        let preset_idx = parts.iter().position(|part| matches!(part, Part::Wanted))?;
        self.pending = Some(Pending { preset_idx, number: None });
        Some(preset_idx)
    }

    /// The scene of what is being made is there: the number to ask for it by.
    pub fn asked(&mut self) -> Option<u64> {
        let pending = self.pending.as_mut()?;
        self.n_asked += 1;
        let number = FIRST_NUMBER + self.n_asked;
        pending.number = Some(number);
        Some(number)
    }

    /// What is being made has come, or cannot be. What nobody waits for is dropped.
    pub fn came(&mut self, number: Option<u64>, picture: Option<P>) {
        let Some(pending) = self.pending.filter(|pending| pending.number == number) else { return };
        self.pending = None;
        if let Some((_, parts)) = self.volumes.last_mut() {
            parts[pending.preset_idx] = picture.map_or(Part::Impossible, Part::Drawn);
        }
    }

    /// A frame is asked for, for which what is being made is given up. It is made later.
    pub fn give_way(&mut self) {
        self.pending = None;
    }

    /// The picture by a preset, once it is there.
    pub fn picture(&self, volume: &Arc<Volume>, preset_idx: usize) -> Option<&P> {
        let (_, parts) = self.volumes.iter().find(|(of, _)| Arc::ptr_eq(of, volume))?;
        match &parts[preset_idx] {
            Part::Drawn(picture) => Some(picture),
            Part::Wanted | Part::Impossible => None,
        }
    }
}

/// A layer alone, before nothing else, as a preset shows it: small, and filled by what is visible, from where
/// it is seen. It looks at all voxels: not on a thread that draws a window.
///
/// # Errors
/// If the preset cannot be fitted to the volume, or nothing can be seen of it, in a sentence.
pub fn thumbnail(mut opened: OpenScene, preset_idx: usize) -> Result<OpenScene, String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let preset = preset(PRESET_NAMES[preset_idx]).map_err(|error| text(&error))?;
    opened.scene.settings = RenderSettings::default().tolerance(TOLERANCE);
    let is_large = MAX_VOXELS < opened.scene.layers[0].volume.grid().n_voxels();
    show_thinned_by(&mut opened, preset.source, if is_large { N_THINNED } else { usize::MAX })?;
    let scene = &mut opened.scene;
    let background = scene.image.background;
    scene.image = ImageDesc::new(THUMBNAIL_SIDE, THUMBNAIL_SIDE).background(background);
    scene.finish = Finish::default();
    let aim = Aim::default().fit(Fit::Visible);
    let framing = opened.framing();
    let scene = &mut opened.scene;
    let camera = framing.aimed(&scene.camera, &aim, true, &scene.image);
    scene.camera = camera.map_err(|error| text(&error))?;
    Ok(opened)
}

/// Shows the layer by a preset, of so many voxels at most.
fn show_thinned_by(
    opened: &mut OpenScene,
    source: TransferSource,
    n_at_most: usize,
) -> Result<(), String> {
    let thin = thinned(&opened.scene.layers[0], n_at_most);
    let longer = thin.as_ref().map_or(1.0, |(_, longer)| *longer);
    if let Some((layer, _)) = thin {
        opened.scene.layers[0] = layer;
    }
    opened.show_by(0, source).map_err(|error| error.to_string())?;
    let transfer = &mut opened.scene.layers[0].transfer;
    let opacity = transfer.opacity_points().over_distance(longer);
    *transfer = TransferFunction::of_curves(opacity, transfer.color_points().clone());
    Ok(())
}

impl Document {
    /// A layer alone, without meshes, as [`thumbnail`] takes it.
    pub fn layer_alone(&self, layer_idx: usize) -> OpenScene {
        let opened = &self.state().opened;
        let keeps: Vec<bool> = (0..opened.scene.layers.len()).map(|idx| idx == layer_idx).collect();
        let mut alone = opened.with_layers(&keeps);
        alone.scene.meshes.clear();
        alone.sources.meshes.clear();
        alone
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::Renderer;
    use slabsplat::io::{SceneFile, VolumeSource};

    fn document(name: &str) -> Document {
        let source = VolumeSource::Builtin { name: name.to_owned(), size: Some(20) };
        Document::open(&SceneFile::of_volume(source), name.to_owned(), [80, 60]).unwrap()
    }

    fn volume(document: &Document) -> Arc<Volume> {
        document.state().opened.scene.layers[0].volume.clone()
    }

    #[test]
    fn each_is_made_once_and_kept_until_the_volume_is_another() {
        let [sphere, cube] = ["sphere", "cube"].map(|name| volume(&document(name)));
        let mut thumbnails = Thumbnails::default();
        assert_eq!(thumbnails.begin_next(), None);
        thumbnails.are_of(&sphere);
        for preset_idx in 0..PRESET_NAMES.len() {
            assert_eq!(thumbnails.begin_next(), Some(preset_idx));
            assert_eq!(thumbnails.begin_next(), None, "one at a time");
            let number = thumbnails.asked();
            assert!(Thumbnails::<usize>::is_number(number.unwrap()));
            thumbnails.came(number, (preset_idx != 3).then_some(preset_idx));
        }
        thumbnails.are_of(&sphere);
        assert_eq!((thumbnails.begin_next(), thumbnails.picture(&sphere, 2)), (None, Some(&2)));
        assert_eq!(thumbnails.picture(&sphere, 3), None, "what cannot be is not tried again");
        thumbnails.are_of(&cube);
        assert_eq!((thumbnails.begin_next(), thumbnails.picture(&cube, 2)), (Some(0), None));
        thumbnails.are_of(&sphere);
        assert_eq!((thumbnails.begin_next(), thumbnails.picture(&sphere, 2)), (None, Some(&2)));
    }

    #[test]
    fn frames_that_are_asked_for_go_before() {
        let sphere = volume(&document("sphere"));
        let mut thumbnails = Thumbnails::default();
        thumbnails.are_of(&sphere);
        thumbnails.begin_next();
        let given_up = thumbnails.asked();
        thumbnails.give_way();
        assert_eq!(thumbnails.begin_next(), Some(0), "it is made later");
        let again = thumbnails.asked();
        assert_ne!(given_up, again);
        thumbnails.came(given_up, Some(1));
        assert_eq!(thumbnails.picture(&sphere, 0), None);
        thumbnails.came(again, Some(2));
        assert_eq!(thumbnails.picture(&sphere, 0), Some(&2));
    }

    #[test]
    fn pictures_show_the_volume_by_their_preset() {
        let mut document = document("neuron");
        document.add(&self::document("cube"));
        let mut renderer = Renderer::open("cpu", |_| {}).unwrap();
        let mut picture = |name: &str| {
            let preset_idx = PRESET_NAMES.iter().position(|it| *it == name).unwrap();
            let opened = thumbnail(document.layer_alone(0), preset_idx).unwrap();
            assert_eq!(opened.scene.layers.len(), 1);
            renderer.picture(&opened.scene, opened.acquisition).unwrap().frame.image
        };
        let [angio, xray] = ["mr-angio", "xray"].map(&mut picture);
        assert_eq!([angio.width(), angio.height()], [THUMBNAIL_SIDE; 2]);
        assert!(0.1 < angio.max_color_difference(&xray), "they look different");
    }

    /// Of volumes that are too large there were none.
    #[test]
    fn pictures_of_fewer_voxels_look_alike() {
        let source = VolumeSource::Builtin { name: "neuron".to_owned(), size: Some(64) };
        let file = SceneFile::of_volume(source);
        let document = Document::open(&file, "neuron".to_owned(), [80, 60]).unwrap();
        let mut renderer = Renderer::open("cpu", |_| {}).unwrap();
        for name in ["mr-t1", "xray", "gray"] {
            let mut picture = |n_at_most: usize| {
                let preset_idx = PRESET_NAMES.iter().position(|it| *it == name).unwrap();
                let mut opened = thumbnail(document.layer_alone(0), preset_idx).unwrap();
                let source = preset(name).unwrap().source;
                show_thinned_by(&mut opened, source, n_at_most).unwrap();
                renderer.picture(&opened.scene, opened.acquisition).unwrap().frame.image
            };
            let [whole, thin, empty] = [usize::MAX, 33_000, 8].map(&mut picture);
            let [off, far] = [&thin, &empty].map(|it| whole.mean_difference(it));
            assert!(0.0 < off && off < 0.02, "{name}: {off}, and of next to nothing {far}");
        }
    }
}
