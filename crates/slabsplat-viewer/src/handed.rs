//! What page and worker hand each other: volumes once, as they lie in memory, scenes as text over those, and
//! pictures as their pixels.
//!
//! A worker has a memory of its own, so that each volume is there twice.

use crate::frames::{Drawn, Event, Request, Urgency};
use crate::read_elsewhere::ToRead;
use crate::received::{Header, acquisition_of, name_of, urgency_of};
use serde::{Deserialize, Serialize};
use slabsplat::glam::DAffine3;
use slabsplat::io::{ContentHash, LoadedVolume, parse_scene_alone, scene_text};
use slabsplat::{
    Acquisition, ColorSamples, Grid, Image, Layer, OpenScene, SampleType, Samples, Scaling, Volume,
    VoxelColors, with_samples,
};
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// A volume beside its samples.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct VolumeHead {
    pub(crate) key: u32,
    dims: [usize; 3],
    world_from_index: [f64; 12],
    sample_type: String,
    slope: f64,
    intercept: f64,
    /// The bits of a colour's component, if voxels have colours.
    color_bits: Option<u32>,
    modality: Option<String>,
    orientation: String,
    is_metric: bool,
}

/// A picture that is asked for.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct Asked {
    pub(crate) pane: usize,
    pub(crate) number: u64,
    urgency: String,
    /// What draws, as a scene file calls it.
    pub(crate) backend: String,
    /// The volumes of the scene's layers.
    keys: Vec<u32>,
    /// Volumes that nothing shows any more.
    forgotten: Vec<u32>,
    /// The text of a scene file.
    scene: String,
}

/// A picture beside its pixels.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct PictureHead {
    pub(crate) header: Header,
    pub(crate) size: [u32; 2],
    /// What drew it, as a scene file calls that, and as the device calls itself.
    pub(crate) drawn_by: [String; 2],
}

/// What comes to a worker with bytes.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) enum WithBytes {
    /// A volume that pictures are asked for of; its samples, and its colours.
    Volume(VolumeHead),
    /// A file that is to be read; its bytes.
    ToRead(ToRead),
}

/// What a worker says in words.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) enum Said {
    /// It listens.
    Ready,
    /// There is no picture.
    Failed { pane: usize, number: u64, why: String },
    /// Something that people should know.
    Note(String),
    /// The share of a file that is read.
    Read(f64),
    /// Why a file is not read.
    NotRead(String),
}

impl Said {
    /// What the page is to know of it.
    pub(crate) fn into_event(self) -> Option<Event> {
        match self {
            Self::Ready | Self::Read(_) | Self::NotRead(_) => None,
            Self::Failed { pane, number, why } => Some(Event::Failed { pane, number, why }),
            Self::Note(note) => Some(Event::Note(note)),
        }
    }
}

impl Asked {
    pub(crate) fn urgency(&self) -> Urgency {
        urgency_of(&self.urgency)
    }
}

/// Bytes that lie outside of this memory, and are copied to where they belong.
#[derive(Clone, Copy)]
pub(crate) struct Outside<'a> {
    pub(crate) len: usize,
    pub(crate) copy_to: &'a dyn Fn(&mut [u8]),
}

impl Outside<'_> {
    fn to_vec<T: bytemuck::Pod>(self) -> Result<Vec<T>, String> {
        let n = self.len / size_of::<T>();
        if n * size_of::<T>() != self.len {
            return Err("a volume was handed over in part".to_owned());
        }
        let mut items = vec![T::zeroed(); n];
        (self.copy_to)(bytemuck::cast_slice_mut(&mut items));
        Ok(items)
    }
}

/// The page's end: what the worker has been handed.
#[derive(Debug, Default)]
pub(crate) struct Handed {
    volumes: Vec<HandedVolume>,
    n_handed: u32,
}

#[derive(Debug)]
struct HandedVolume {
    key: u32,
    volume: Weak<Volume>,
    /// What scene files call it by; of a large volume that takes a while.
    hash: ContentHash,
}

impl Handed {
    /// What is asked for a request, once each volume has been handed over that `hand` is called with: its
    /// head, its samples and its colours.
    pub(crate) fn asked(
        &mut self,
        request: &Request,
        mut hand: impl FnMut(VolumeHead, &[u8], &[u8]) -> Result<(), String>,
    ) -> Result<String, String> {
        let opened = &request.opened;
        let is_gone = |handed: &HandedVolume| handed.volume.strong_count() == 0;
        let forgotten = self.volumes.extract_if(.., |handed| is_gone(handed));
        let forgotten = forgotten.map(|handed| handed.key).collect();
        let mut keys = Vec::with_capacity(opened.scene.layers.len());
        let mut sources = opened.sources.clone();
        let layers = opened.scene.layers.iter().zip(opened.acquisitions());
        for ((layer, acquisition), source) in layers.zip(&mut sources.layers) {
            let handed = self.handed(layer, acquisition, &mut hand)?;
            keys.push(handed.key);
            source.hash = Some(handed.hash);
        }
        let mut file = sources.at_moment(&opened.scene).map_err(|error| error.to_string())?;
        file.layers.iter_mut().for_each(|layer| layer.hash = None);
        let scene = scene_text(&file, "scene.toml").map_err(|error| error.to_string())?;
        let Request { pane, number, urgency, .. } = *request;
        let urgency = name_of(urgency).to_owned();
        let backend = opened.backend.clone();
        let asked = Asked { pane, number, urgency, backend, keys, forgotten, scene };
        serde_json::to_string(&asked).map_err(|error| error.to_string())
    }

    /// What was handed over of a layer, or is now.
    fn handed(
        &mut self,
        layer: &Layer,
        acquisition: Acquisition,
        hand: &mut impl FnMut(VolumeHead, &[u8], &[u8]) -> Result<(), String>,
    ) -> Result<&HandedVolume, String> {
        let (volume, colors) = (&layer.volume, layer.colors.as_ref());
        let is_it = |handed: &HandedVolume| handed.volume.as_ptr() == Arc::as_ptr(volume);
        if let Some(idx) = self.volumes.iter().position(is_it) {
            return Ok(&self.volumes[idx]);
        }
        let key = self.n_handed;
        let head = VolumeHead::of(key, volume, colors, acquisition);
        hand(head, bytes_of(volume), colors.map_or(&[], bytes_of_colors))?;
        self.n_handed += 1;
        let hash = ContentHash::of_volume(volume, colors);
        self.volumes.push(HandedVolume { key, volume: Arc::downgrade(volume), hash });
        Ok(&self.volumes[self.volumes.len() - 1])
    }
}

/// The worker's end: the volumes that it was handed.
#[derive(Debug, Default)]
pub(crate) struct Volumes {
    of_keys: HashMap<u32, LoadedVolume>,
    colors: HashMap<u32, VoxelColors>,
    /// Scenes of some of them, which others are made of that show them otherwise.
    scenes: HashMap<Vec<u32>, OpenScene>,
}

impl Volumes {
    pub(crate) fn add(
        &mut self,
        head: &VolumeHead,
        samples: Outside<'_>,
        colors: Outside<'_>,
    ) -> Result<(), String> {
        let volume = head.volume(samples)?;
        if let Some(colors) = head.colors(colors)? {
            self.colors.insert(head.key, colors);
        }
        let mut loaded = LoadedVolume::computed(volume);
        loaded.acquisition = head.acquisition()?;
        self.of_keys.insert(head.key, loaded);
        Ok(())
    }

    /// The scene that is asked for.
    pub(crate) fn scene(&mut self, asked: &Asked) -> Result<OpenScene, String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        for key in &asked.forgotten {
            self.of_keys.remove(key);
            self.colors.remove(key);
            self.scenes.retain(|keys, _| !keys.contains(key));
        }
        let file = parse_scene_alone(&asked.scene, "scene.toml").map_err(|e| text(&e))?;
        if !self.scenes.contains_key(&asked.keys) {
            let loaded = asked.keys.iter().map(|key| self.of_keys.get(key).cloned());
            let loaded: Option<Vec<LoadedVolume>> = loaded.collect();
            let loaded = loaded.ok_or("a volume was not handed over")?;
            let mut opened = OpenScene::with_volumes(loaded, &file).map_err(|e| text(&e))?;
            for (layer, key) in opened.scene.layers.iter_mut().zip(&asked.keys) {
                layer.colors = self.colors.get(key).cloned();
            }
            self.scenes.insert(asked.keys.clone(), opened);
        }
        self.scenes[&asked.keys].shown_as(&file).map_err(|e| text(&e))
    }
}

impl PictureHead {
    pub(crate) fn n_pixels(&self) -> usize {
        self.size.map(|side| side as usize).iter().product()
    }

    /// The picture of these pixels.
    pub(crate) fn drawn(self, pixels: Vec<[f32; 4]>) -> Drawn {
        let [width, height] = self.size;
        self.header.drawn(Image::from_pixels(width, height, pixels))
    }
}

impl VolumeHead {
    pub(crate) fn of(
        key: u32,
        volume: &Volume,
        colors: Option<&VoxelColors>,
        acquisition: Acquisition,
    ) -> Self {
        let grid = volume.grid();
        let Scaling { slope, intercept } = volume.scaling();
        Self {
            key,
            dims: grid.dims(),
            world_from_index: grid.world_from_index().to_cols_array(),
            sample_type: volume.sample_type().name().to_owned(),
            slope,
            intercept,
            color_bits: colors.map(|colors| match colors.samples() {
                ColorSamples::U8(_) => 8,
                _ => 16,
            }),
            modality: acquisition.modality.map(|modality| modality.name().to_owned()),
            orientation: acquisition.orientation.name().to_owned(),
            is_metric: acquisition.is_metric,
        }
    }

    pub(crate) fn volume(&self, samples: Outside<'_>) -> Result<Volume, String> {
        let place = DAffine3::from_cols_array(&self.world_from_index);
        let grid = Grid::new(self.dims, place).map_err(|error| error.to_string())?;
        let sample_type: SampleType =
            self.sample_type.parse().map_err(|_| "samples have no type".to_owned())?;
        let scaling = Scaling { slope: self.slope, intercept: self.intercept };
        let samples = samples_of(sample_type, samples)?;
        Volume::new(grid, samples, scaling).map_err(|error| error.to_string())
    }

    pub(crate) fn colors(&self, colors: Outside<'_>) -> Result<Option<VoxelColors>, String> {
        let samples = match self.color_bits {
            None => return Ok(None),
            Some(8) => ColorSamples::U8(colors.to_vec()?),
            Some(_) => ColorSamples::U16(colors.to_vec()?),
        };
        VoxelColors::new(self.dims, samples).map(Some).map_err(|error| error.to_string())
    }

    pub(crate) fn acquisition(&self) -> Result<Acquisition, String> {
        acquisition_of(self.modality.as_deref(), &self.orientation, self.is_metric)
            .map_err(|error| error.to_string())
    }
}

fn samples_of(sample_type: SampleType, samples: Outside<'_>) -> Result<Samples, String> {
    Ok(match sample_type {
        SampleType::U8 => Samples::U8(samples.to_vec()?),
        SampleType::I8 => Samples::I8(samples.to_vec()?),
        SampleType::U16 => Samples::U16(samples.to_vec()?),
        SampleType::I16 => Samples::I16(samples.to_vec()?),
        SampleType::U32 => Samples::U32(samples.to_vec()?),
        SampleType::I32 => Samples::I32(samples.to_vec()?),
        SampleType::F32 => Samples::F32(samples.to_vec()?),
        SampleType::F64 => Samples::F64(samples.to_vec()?),
    })
}

pub(crate) fn bytes_of(volume: &Volume) -> &[u8] {
    with_samples!(volume.samples(), |samples| bytemuck::cast_slice(samples))
}

pub(crate) fn bytes_of_colors(colors: &VoxelColors) -> &[u8] {
    match colors.samples() {
        ColorSamples::U8(colors) => bytemuck::cast_slice(colors),
        ColorSamples::U16(colors) => bytemuck::cast_slice(colors),
        _ => &[],
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use slabsplat::io::{SceneFile, VolumeSource};
    use slabsplat::{Modality, Orientation, Plane, Region};

    /// Calls something with bytes as if they were outside.
    pub(crate) fn outside<T>(bytes: &[u8], call: impl FnOnce(Outside<'_>) -> T) -> T {
        call(Outside { len: bytes.len(), copy_to: &|into| into.copy_from_slice(bytes) })
    }

    fn opened(name: &str) -> OpenScene {
        let source = VolumeSource::Builtin { name: name.to_owned(), size: Some(12) };
        OpenScene::open(&SceneFile::of_volume(source)).unwrap()
    }

    fn request(opened: &OpenScene) -> Request {
        let urgency = Urgency::Moving;
        Request { pane: 1, number: 7, opened: opened.clone(), urgency, is_read_back: false }
    }

    /// What a worker makes of a request, and how many volumes it was handed for it.
    fn handed(
        opened: &OpenScene,
        page: &mut Handed,
        worker: &mut Volumes,
    ) -> (Asked, OpenScene, usize) {
        let mut n_handed = 0;
        let hand = |head: VolumeHead, samples: &[u8], colors: &[u8]| {
            n_handed += 1;
            let told = serde_json::to_string(&WithBytes::Volume(head)).unwrap();
            let WithBytes::Volume(head) = serde_json::from_str(&told).unwrap() else {
                panic!("a volume is handed over, not {told}");
            };
            outside(samples, |samples| outside(colors, |colors| worker.add(&head, samples, colors)))
        };
        let text = page.asked(&request(opened), hand).unwrap();
        let asked: Asked = serde_json::from_str(&text).unwrap();
        let scene = worker.scene(&asked).unwrap();
        (asked, scene, n_handed)
    }

    /// Volumes are other ones in memory, and equal all the same.
    fn assert_equal(made: &OpenScene, expected: &OpenScene) {
        assert_eq!(made.acquisition, expected.acquisition);
        let mut scene = made.scene.clone();
        assert_eq!(scene.layers.len(), expected.scene.layers.len());
        for (layer, expected) in scene.layers.iter_mut().zip(&expected.scene.layers) {
            let (volume, expected_volume) = (&layer.volume, &expected.volume);
            assert_eq!(volume.grid(), expected_volume.grid());
            assert_eq!(volume.scaling(), expected_volume.scaling());
            assert_eq!(volume.samples(), expected_volume.samples());
            let samples = |colors: &VoxelColors| colors.samples().clone();
            assert_eq!(layer.colors.as_ref().map(samples), expected.colors.as_ref().map(samples));
            layer.volume = expected.volume.clone();
            layer.colors.clone_from(&expected.colors);
        }
        assert_eq!(scene, expected.scene);
    }

    #[test]
    fn scenes_are_what_they_were_in_the_page() {
        let (mut page, mut worker) = (Handed::default(), Volumes::default());
        let mut one = opened("neuron");
        one.backend = "cpu".to_owned();
        let (asked, made, n_handed) = handed(&one, &mut page, &mut worker);
        assert_eq!((asked.pane, asked.number, n_handed), (1, 7, 1));
        assert_eq!((asked.backend.as_str(), asked.urgency()), ("cpu", Urgency::Moving));
        assert_equal(&made, &one);
        one.scene.camera = one.scene.camera.orbited(0.3);
        one.scene.settings.slab_width = 1.75;
        one.scene.image.background = [0.1, 0.2, 0.3, 0.7];
        one.scene.layers[0].region =
            Region::default().behind(Plane::new([0.6, 0.0, 0.8], 1.5).unwrap());
        let (_, made, n_handed) = handed(&one, &mut page, &mut worker);
        assert_equal(&made, &one);
        assert_eq!(n_handed, 0, "it has the volume");
        let mut two = one.clone();
        two.add_layers_of(opened("cube"));
        let (_, made, n_handed) = handed(&two, &mut page, &mut worker);
        assert_equal(&made, &two);
        assert_eq!(n_handed, 1, "one more");
        let alone = two.with_layers(&[false, true]);
        assert_equal(&handed(&alone, &mut page, &mut worker).1, &alone);
        drop((two, alone));
        let (asked, made, _) = handed(&one, &mut page, &mut worker);
        assert_eq!(asked.forgotten, [1]);
        assert_equal(&made, &one);
        assert_eq!((worker.of_keys.len(), worker.scenes.len()), (1, 1));
    }

    #[test]
    fn pictures_and_words_are_events() {
        let header = Header::of((2, 5, Urgency::AtRest), 2.5, 9, vec!["hm".to_owned()]);
        let drawn_by = ["cpu".to_owned(), "a CPU".to_owned()];
        let head = PictureHead { header, size: [2, 1], drawn_by };
        let head = serde_json::to_string(&head).unwrap();
        let head: PictureHead = serde_json::from_str(&head).unwrap();
        assert_eq!((head.n_pixels(), &*head.drawn_by[0]), (2, "cpu"));
        let pixels = vec![[0.1, 0.2, 0.3, 0.4], [0.0, 0.0, 0.0, 1.0]];
        let drawn = head.drawn(pixels.clone());
        assert_eq!((drawn.pane, drawn.number, drawn.urgency), (2, 5, Urgency::AtRest));
        assert_eq!(
            (drawn.ms, drawn.n_voxels, &drawn.notes[..]),
            (Some(2.5), 9, &["hm".to_owned()][..])
        );
        assert_eq!(drawn.image, Image::from_pixels(2, 1, pixels));
        let said = |said: Said| {
            let text = serde_json::to_string(&said).unwrap();
            serde_json::from_str::<Said>(&text).unwrap().into_event()
        };
        assert!(said(Said::Ready).is_none());
        let failed = said(Said::Failed { pane: 1, number: 4, why: "no".to_owned() });
        assert!(matches!(failed, Some(Event::Failed { pane: 1, number: 4, why }) if why == "no"));
        assert!(
            matches!(said(Said::Note("hm".to_owned())), Some(Event::Note(note)) if note == "hm")
        );
    }

    #[test]
    fn volumes_of_every_type_are_what_they_were() {
        let place = [2.0, 0.1, 0.0, -0.3, 1.5, 0.2, 0.0, 0.7, 3.0, -7.0, 0.25, 1e3];
        let grid = Grid::new([2, 1, 3], DAffine3::from_cols_array(&place)).unwrap();
        let scaling = Scaling { slope: 0.1, intercept: -1024.0 };
        let mut rng = fastrand::Rng::with_seed(1);
        for &sample_type in SampleType::ALL {
            let bytes: Vec<u8> = (0..6 * sample_type.size_bytes()).map(|_| rng.u8(..)).collect();
            let volume = Volume::new(
                grid,
                outside(&bytes, |it| samples_of(sample_type, it)).unwrap(),
                scaling,
            )
            .unwrap();
            let colors = ColorSamples::U16((0..6).map(|i| [i, 65535, 7 * i]).collect());
            let colors = VoxelColors::new(grid.dims(), colors).unwrap();
            let acquisition = Acquisition::default().modality(Modality::Ct).metric();
            let acquisition = acquisition.orientation(Orientation::Anatomical);
            let head = VolumeHead::of(3, &volume, Some(&colors), acquisition);
            let head: VolumeHead =
                serde_json::from_str(&serde_json::to_string(&head).unwrap()).unwrap();
            let made = outside(bytes_of(&volume), |it| head.volume(it)).unwrap();
            // Some samples are NaN, by chance.
            assert_eq!(bytes_of(&made), bytes, "{sample_type:?}");
            assert_eq!((made.grid(), made.scaling()), (&grid, scaling));
            let made = outside(bytes_of_colors(&colors), |it| head.colors(it)).unwrap().unwrap();
            assert_eq!(made.samples(), colors.samples());
            assert_eq!(head.acquisition(), Ok(acquisition));
            for n_lost in 1..=sample_type.size_bytes() {
                assert!(outside(&bytes[n_lost..], |it| head.volume(it)).is_err());
            }
        }
    }
}
