//! Channels of a layer's file: each that is seen is a layer of its own, so that it has its own transfer
//! function, and a scene file names it.

use super::Document;
use slabsplat::PiecewiseLinear;
use slabsplat::io::{ColorUse, LayerFile, SceneFile};

/// A channel of a file, or all of them as its voxels' colours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// What it is called.
    pub name: String,
    /// Which, counted from 0; `None` for colours.
    pub channel: Option<usize>,
    /// The layer that has it, if one has.
    pub layer_idx: Option<usize>,
}

/// What channels are dyed with that are added, from their least value to their largest: dark enough to be
/// seen over each other, and far apart in hue. What was opened first often is green.
const DYES: [[[f64; 3]; 3]; 6] = [
    [[0.55, 0.05, 0.45], [0.95, 0.35, 0.80], [1.0, 0.85, 1.0]],
    [[0.05, 0.30, 0.65], [0.30, 0.65, 1.0], [0.85, 0.95, 1.0]],
    [[0.65, 0.30, 0.05], [1.0, 0.62, 0.25], [1.0, 0.93, 0.82]],
    [[0.60, 0.08, 0.08], [0.98, 0.35, 0.30], [1.0, 0.86, 0.84]],
    [[0.50, 0.48, 0.05], [0.92, 0.88, 0.30], [1.0, 1.0, 0.82]],
    [[0.30, 0.15, 0.60], [0.62, 0.48, 0.98], [0.92, 0.88, 1.0]],
];

impl Document {
    /// The channels of a layer's file; none if it has but one.
    pub fn channels(&self, layer_idx: usize) -> Vec<Channel> {
        let opened = &self.state().opened;
        let choices = opened.choices_of(layer_idx);
        let Some(of) = opened.sources.layers.get(layer_idx).filter(|_| 1 < choices.channel.n)
        else {
            return Vec::new();
        };
        let layers = || opened.sources.layers.iter().enumerate();
        // Of a channel alone its file does not say whether all may be colours.
        let mut of_file = layers().filter(|(_, layer)| are_of_one(layer, of));
        let has_colors = of_file.any(|(idx, _)| opened.choices_of(idx).is_color);
        let all = (0..choices.channel.n).map(Some);
        let listed = has_colors.then_some(None).into_iter().chain(all);
        let of_channel = |channel: Option<usize>| Channel {
            name: self.channel_name(layer_idx, channel),
            channel,
            layer_idx: layers()
                .find(|(_, layer)| layer.options.channel == channel && are_of_one(layer, of))
                .map(|(idx, _)| idx),
        };
        listed.map(of_channel).collect()
    }

    /// What a channel of a layer's file is called.
    pub fn channel_name(&self, layer_idx: usize, channel: Option<usize>) -> String {
        let Some(idx) = channel else { return "colours".to_owned() };
        let names = &self.state().opened.choices_of(layer_idx).channel.names;
        let name = names.get(idx).filter(|name| !name.is_empty());
        name.map_or_else(|| format!("channel {idx}"), Clone::clone)
    }

    /// Which channel of several a layer shows, for people.
    pub fn shown_channel(&self, layer_idx: usize) -> Option<String> {
        let opened = &self.state().opened;
        let is_one = opened.choices_of(layer_idx).channel.n <= 1;
        let channel = opened.sources.layers[layer_idx].options.channel;
        (!is_one && channel.is_some()).then(|| self.channel_name(layer_idx, channel))
    }

    /// The scene of another channel of a layer's file, to be added to this one.
    pub fn file_of_channel(&self, layer_idx: usize, channel: Option<usize>) -> SceneFile {
        let of = &self.state().opened.sources.layers[layer_idx];
        let mut file = SceneFile::of_volume(of.volume.clone());
        let layer = &mut file.layers[0];
        layer.options.clone_from(&of.options);
        layer.options.channel = channel;
        layer.options.colors = channel.is_none().then_some(ColorUse::Own);
        layer.options.opacity_from = None;
        (layer.spacing, layer.raw) = (of.spacing, of.raw.clone());
        layer.fit.colormap = channel.map(|_| self.free_dye(of));
        file
    }

    /// The first dye that no other channel of a file has.
    fn free_dye(&self, of: &LayerFile) -> PiecewiseLinear<3> {
        let opened = &self.state().opened;
        let layers = opened.scene.layers.iter().zip(&opened.sources.layers);
        let dyed: Vec<Vec<[f64; 3]>> = layers
            .filter(|(_, source)| are_of_one(source, of))
            .map(|(layer, _)| {
                layer.transfer.color_points().points().iter().map(|it| it.1).collect()
            })
            .collect();
        let is_free = |dye: &&[[f64; 3]; 3]| !dyed.iter().any(|colors| colors[..] == dye[..]);
        let dye = DYES.iter().find(is_free).unwrap_or(&DYES[0]);
        let points = [0.0, 0.5, 1.0].into_iter().zip(*dye);
        PiecewiseLinear::new("dye", points).expect("positions rise, and colours are within 0 … 1")
    }
}

/// Whether two layers are of the same file, and of the same part of it but for the channel.
fn are_of_one(a: &LayerFile, b: &LayerFile) -> bool {
    let part = |layer: &LayerFile| {
        let options = &layer.options;
        (options.series, options.time, options.level, options.array.clone(), options.voxels.clone())
    };
    (&a.volume, a.spacing, &a.raw) == (&b.volume, b.spacing, &b.raw) && part(a) == part(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::io::{VolumeSource, parse_scene, scene_text};
    use slabsplat::{OpenScene, Renderer};
    use std::path::PathBuf;

    /// A file of as many values a voxel, which differ.
    fn file(name: &str, kind: &str, n_channels: usize) -> PathBuf {
        let folder = std::env::temp_dir();
        let path = folder.join(format!("slabsplat-{name}-{}.nrrd", std::process::id()));
        let header = format!(
            "NRRD0004\ntype: uint8\ndimension: 4\nsizes: {n_channels} 6 6 6\n\
             kinds: {kind} domain domain domain\nencoding: raw\n\n"
        );
        let voxel =
            |idx: usize| (0..n_channels).map(move |channel| ((channel + 2) * idx % 251) as u8);
        let bytes = header.into_bytes().into_iter().chain((0..216).flat_map(voxel));
        std::fs::write(&path, bytes.collect::<Vec<u8>>()).unwrap();
        path
    }

    fn document(path: &std::path::Path) -> Document {
        let source = VolumeSource::File(path.to_owned());
        Document::open(&SceneFile::of_volume(source), "a".to_owned(), [40, 30]).unwrap()
    }

    /// Adds a channel as a viewer does.
    fn add(document: &mut Document, channel: Option<usize>) {
        let file = document.file_of_channel(0, channel);
        document.add(&Document::open(&file, "a".to_owned(), [40, 30]).unwrap());
    }

    fn picture(opened: &OpenScene) -> slabsplat::Image {
        let mut renderer = Renderer::open("cpu", |_| {}).unwrap();
        renderer.picture(&opened.scene, opened.acquisition).unwrap().frame.image
    }

    #[test]
    fn channels_of_a_file_become_layers_and_go() {
        let path = file("channels", "list", 3);
        let mut document = document(&path);
        let layers = |document: &Document| -> Vec<Option<usize>> {
            document.channels(0).iter().map(|channel| channel.layer_idx).collect()
        };
        assert_eq!(layers(&document), [Some(0), None, None], "the first, as render shows it");
        add(&mut document, Some(2));
        add(&mut document, Some(1));
        assert_eq!(layers(&document), [Some(0), Some(2), Some(1)]);
        assert_eq!(document.channels(0)[2].name, "channel 2");
        assert_eq!(document.shown_channel(1).as_deref(), Some("channel 2"));
        let opened = document.shown();
        let colors = |idx: usize| opened.scene.layers[idx].transfer.color_points().at(0.0);
        assert!(colors(0) != colors(1) && colors(1) != colors(2) && colors(0) != colors(2));
        // The scene that is saved gives the same picture.
        let text = scene_text(&opened.to_file().unwrap(), "a.toml").unwrap();
        let again = OpenScene::open(&parse_scene(&text, "a.toml").unwrap()).unwrap();
        assert_eq!(picture(&again), picture(&opened));
        document.remove_layer(1);
        assert_eq!(layers(&document), [Some(0), Some(1), None]);
        document.undo();
        document.undo();
        assert_eq!(layers(&document), [Some(0), None, Some(1)]);
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn colors_are_one_of_the_choices() {
        let path = file("colors", "RGB-color", 3);
        let mut document = document(&path);
        let listed = document.channels(0);
        let names: Vec<_> = listed.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["colours", "red", "green", "blue"]);
        assert_eq!(listed[0].layer_idx, Some(0));
        add(&mut document, Some(1));
        let shown: Vec<_> = document.channels(1).iter().map(|channel| channel.layer_idx).collect();
        assert_eq!(shown, [Some(0), None, Some(1), None], "of whichever layer");
        let both = picture(&document.shown());
        document.remove_layer(0);
        assert_ne!(picture(&document.shown()), both);
        document.undo();
        assert_eq!(picture(&document.shown()), both);
        document.remove_layer(1);
        add(&mut document, Some(2));
        assert_eq!(document.channels(0)[3].layer_idx, Some(1));
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn what_has_one_channel_offers_none() {
        let path = file("single", "list", 1);
        let document = document(&path);
        assert_eq!((document.channels(0), document.shown_channel(0)), (Vec::new(), None));
        std::fs::remove_file(path).unwrap();
    }
}
