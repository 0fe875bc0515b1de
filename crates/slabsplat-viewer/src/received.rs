//! What page and server say to each other: scenes as text, pictures as files with a header.
//!
//! A request is JSON: `pane`, `number`, `urgency` (`moving` or `rest`), `scene`, the text of a scene file,
//! and `layers`, the numbers of those of the server's layers that this has. An answer in bytes is the length
//! of a header (32 bits, little-endian), the header in JSON and the picture as JPEG or PNG; an answer in text
//! is JSON with an `error`, of a pane and a number, or with a `note`.

use crate::frames::{Drawn, Event, Request, Urgency};
use serde::{Deserialize, Serialize};
use slabsplat::io::{IoError, MeshFile, SceneFile, scene_text};
use slabsplat::{
    Acquisition, Image, LabelMap, Labels, Mesh, MeshLayer, NotAChoice, OpenScene, ValueCounts,
    Volume,
};

#[derive(Serialize)]
struct Asked<'a> {
    pane: usize,
    number: u64,
    urgency: &'a str,
    layers: Vec<usize>,
    scene: String,
}

/// What is said before a picture.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct Header {
    pub(crate) pane: usize,
    pub(crate) number: u64,
    urgency: String,
    ms: f64,
    n_voxels: u64,
    #[serde(default)]
    notes: Vec<String>,
}

impl Header {
    /// What a picture that is asked for so will be.
    pub(crate) fn of(
        (pane, number, urgency): (usize, u64, Urgency),
        ms: f64,
        n_voxels: u64,
        notes: Vec<String>,
    ) -> Self {
        Self { pane, number, urgency: name_of(urgency).to_owned(), ms, n_voxels, notes }
    }

    pub(crate) fn drawn(self, image: Image) -> Drawn {
        Drawn {
            pane: self.pane,
            number: self.number,
            urgency: urgency_of(&self.urgency),
            image,
            notes: self.notes,
            ms: Some(self.ms),
            n_voxels: self.n_voxels,
        }
    }
}

/// What messages call it.
pub(crate) fn name_of(urgency: Urgency) -> &'static str {
    match urgency {
        Urgency::Moving => "moving",
        Urgency::AtRest => "rest",
    }
}

pub(crate) fn urgency_of(name: &str) -> Urgency {
    if name == name_of(Urgency::Moving) { Urgency::Moving } else { Urgency::AtRest }
}

/// What a server shows, without its volumes.
#[derive(Deserialize)]
pub(crate) struct Session {
    pub(crate) name: String,
    pub(crate) scene: String,
    #[serde(default)]
    warnings: Vec<String>,
    #[serde(default)]
    found: Vec<String>,
    layers: Vec<SessionLayer>,
}

#[derive(Deserialize)]
struct SessionLayer {
    range: Option<[f64; 2]>,
    counts: Vec<u64>,
    #[serde(default)]
    labels: Vec<i64>,
    modality: Option<String>,
    orientation: String,
    is_metric: bool,
}

/// An acquisition of names.
pub(crate) fn acquisition_of(
    modality: Option<&str>,
    orientation: &str,
    is_metric: bool,
) -> Result<Acquisition, NotAChoice> {
    let mut acquisition = Acquisition::default().orientation(orientation.parse()?);
    acquisition.modality = modality.map(str::parse).transpose()?;
    acquisition.is_metric = is_metric;
    Ok(acquisition)
}

impl SessionLayer {
    fn acquisition(&self) -> Result<Acquisition, NotAChoice> {
        acquisition_of(self.modality.as_deref(), &self.orientation, self.is_metric)
    }
}

impl Session {
    pub(crate) fn of_json(json: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(json).map_err(|error| format!("the server says nothing: {error}"))
    }

    /// What the server's files say of its volumes.
    pub(crate) fn acquisitions(&self) -> Result<Vec<Acquisition>, String> {
        let acquisitions = self.layers.iter().map(SessionLayer::acquisition);
        acquisitions.collect::<Result<_, _>>().map_err(|error| error.to_string())
    }

    /// Has a scene of overviews say what the server knows of the volumes, and have the labels and meshes
    /// that the server's has: here there is nothing of them but how they look, which can be edited.
    pub(crate) fn tell(&self, opened: &mut OpenScene, file: SceneFile) -> Result<(), IoError> {
        opened.warnings.clone_from(&self.warnings);
        opened.found.clone_from(&self.found);
        let OpenScene { scene, sources, .. } = opened;
        let layers = scene.layers.iter_mut().zip(&mut sources.layers);
        for ((layer, source), said) in layers.zip(file.layers) {
            if let Some(labels) = said.labels {
                layer.labels = Some(labels.styled(&unlabelled(&layer.volume)?)?);
                source.labels = Some(labels);
            }
        }
        scene.meshes = file.meshes.iter().map(looking).collect();
        sources.meshes = file.meshes;
        Ok(())
    }

    /// How many voxels of each layer have which values, and which labels.
    pub(crate) fn facts(&self) -> Vec<(Option<ValueCounts>, Vec<i64>)> {
        let of_layer = |layer: &SessionLayer| {
            let counts =
                layer.range.map(|range| ValueCounts::of_counts(range, layer.counts.clone()));
            (counts, layer.labels.clone())
        };
        self.layers.iter().map(of_layer).collect()
    }
}

/// Labels of a volume whose voxels have none.
fn unlabelled(volume: &Volume) -> Result<Labels, IoError> {
    let nothing = Volume::from_fn(*volume.grid(), |_| 0_u8);
    let labels = LabelMap::new(&nothing, volume.grid()).and_then(|map| Labels::new(map, []));
    labels.map_err(|source| IoError::Labels { path: "labels".into(), source })
}

/// A mesh that is nowhere, and looks as a file says.
fn looking(file: &MeshFile) -> MeshLayer {
    let mut mesh = MeshLayer::new(Mesh::default()).shading(file.shading);
    (mesh.color, mesh.line_width, mesh.point_size) = (file.color, file.line_width, file.point_size);
    mesh
}

/// What a server says in words.
#[derive(Deserialize)]
#[serde(untagged)]
pub(crate) enum Answer {
    Failed { pane: usize, number: u64, error: String },
    Note { note: String },
}

impl Answer {
    /// What a text says, if it is an answer.
    pub(crate) fn of_text(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }

    pub(crate) fn into_event(self) -> Event {
        match self {
            Self::Failed { pane, number, error } => Event::Failed { pane, number, why: error },
            Self::Note { note } => Event::Note(note),
        }
    }
}

/// What is sent for a request.
pub(crate) fn request_text(request: &Request) -> Result<String, String> {
    let file = request.opened.to_file().map_err(|error| error.to_string())?;
    let scene = scene_text(&file, "scene.toml").map_err(|error| error.to_string())?;
    let urgency = name_of(request.urgency);
    let layers = request.opened.layer_numbers();
    let asked = Asked { pane: request.pane, number: request.number, urgency, layers, scene };
    serde_json::to_string(&asked).map_err(|error| error.to_string())
}

/// The picture that came.
pub(crate) fn drawn_of(bytes: &[u8]) -> Result<Drawn, String> {
    const SHORT: &str = "the server sent half a picture";
    let (length, rest) = bytes.split_first_chunk::<4>().ok_or(SHORT)?;
    let length = u32::from_le_bytes(*length) as usize;
    let (header, picture) = rest.split_at_checked(length).ok_or(SHORT)?;
    let header: Header = serde_json::from_slice(header).map_err(|error| error.to_string())?;
    Ok(header.drawn(decoded(picture)?))
}

/// A file's pixels, premultiplied.
fn decoded(bytes: &[u8]) -> Result<Image, String> {
    let picture = image::load_from_memory(bytes).map_err(|error| error.to_string())?.into_rgba8();
    let premultiplied = |pixel: &image::Rgba<u8>| {
        let [r, g, b, a] = pixel.0.map(|byte| f32::from(byte) / 255.0);
        [r * a, g * a, b * a, a]
    };
    let pixels = picture.pixels().map(premultiplied).collect();
    Ok(Image::from_pixels(picture.width(), picture.height(), pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slabsplat::io::{SceneFile, VolumeSource, png_bytes};
    use slabsplat::{Modality, Orientation};

    #[test]
    fn pictures_come_as_they_were_sent() {
        let image = Image::filled(3, 2, [0.2, 0.4, 0.6, 1.0]);
        let header =
            r#"{"pane":1,"number":7,"urgency":"rest","format":"png","ms":2.5,"n_voxels":9}"#;
        let mut bytes = (header.len() as u32).to_le_bytes().to_vec();
        bytes.extend_from_slice(header.as_bytes());
        bytes.extend(png_bytes(&image).unwrap());
        let drawn = drawn_of(&bytes).unwrap();
        assert_eq!((drawn.pane, drawn.number, drawn.urgency), (1, 7, Urgency::AtRest));
        assert!(drawn.image.max_difference(&image) < 1e-6);
        // All of a PNG is there before its last chunk, which has nothing in it.
        for length in 0..bytes.len() - 12 {
            assert!(drawn_of(&bytes[..length]).is_err(), "{length} bytes");
        }
    }

    #[test]
    fn a_session_says_what_is_shown() {
        let json = r#"{"name":"head","scene":"","layers":[
            {"range":[0,8],"counts":[3,1],"labels":[2,5],
             "modality":"ct","orientation":"anatomical","is_metric":true},
            {"range":null,"counts":[],"labels":[],
             "modality":null,"orientation":"unknown","is_metric":false}]}"#;
        let session = Session::of_json(json.as_bytes()).unwrap();
        assert_eq!((session.name.as_str(), session.scene.as_str()), ("head", ""));
        let source = VolumeSource::Builtin { name: "cube".to_owned(), size: Some(8) };
        let mut opened = OpenScene::open(&SceneFile::of_volume(source)).unwrap();
        let file = opened.sources.clone();
        session.tell(&mut opened, file).unwrap();
        assert!(opened.found.is_empty());
        let metric = Acquisition::default().modality(Modality::Ct).metric();
        let metric = metric.orientation(Orientation::Anatomical);
        assert_eq!(session.acquisitions(), Ok(vec![metric, Acquisition::default()]));
        let odd = Session::of_json(json.replace("unknown", "odd").as_bytes()).unwrap();
        assert!(odd.acquisitions().is_err());
        let facts = session.facts();
        assert_eq!(facts[0].0.as_ref().map(|counts| counts.range), Some([0.0, 8.0]));
        assert_eq!((&facts[0].1[..], &facts[1]), (&[2, 5][..], &(None, Vec::new())));
        assert!(Session::of_json(b"{}").is_err());
    }

    /// The scene of the server, as it is opened in a page, and what is edited there.
    #[test]
    fn labels_and_meshes_of_a_server_are_edited() {
        let text = r#"
            [[layers]]
            volume = { generate = "cube", size = 8 }
            labels = { path = "atlas.nii.gz", colors = "none", styles = [{ of = [3], color = [1, 0, 0] }] }
            [[layers]]
            mesh = { path = "skull.ply", color = [0.5, 0.5, 0.25] }
        "#;
        let mut file = slabsplat::io::parse_scene_alone(text, "scene.toml").unwrap();
        let said = file.clone();
        file.meshes.clear();
        file.layers[0].labels = None;
        let mut opened = OpenScene::open(&file).unwrap();
        let json = r#"{"name":"","scene":"","layers":[]}"#;
        Session::of_json(json.as_bytes()).unwrap().tell(&mut opened, said).unwrap();
        assert_eq!(opened.scene.meshes[0].color, Some([0.5, 0.5, 0.25]));
        let labels = opened.scene.layers[0].labels.clone().unwrap();
        let mut styles = labels.styles().clone();
        assert_eq!(styles[&3].color, Some([1.0, 0.0, 0.0]));
        styles.insert(5, slabsplat::LabelStyle::default().opacity(0.0));
        opened.scene.layers[0].labels = Some(labels.with_styles(styles.clone()).unwrap());
        opened.scene.meshes[0].color = Some([0.0, 1.0, 0.0]);
        let urgency = Urgency::AtRest;
        let request = Request { pane: 0, number: 1, opened, urgency, is_read_back: true };
        let value: serde_json::Value =
            serde_json::from_str(&request_text(&request).unwrap()).unwrap();
        let scene = value["scene"].as_str().unwrap();
        let sent = slabsplat::io::parse_scene_alone(scene, "scene.toml").unwrap();
        assert_eq!(sent.layers[0].labels.as_ref().unwrap().styles, styles);
        assert_eq!(sent.meshes[0].color, Some([0.0, 1.0, 0.0]));
    }

    #[test]
    fn words_are_errors_and_notes() {
        let failed = Answer::of_text(r#"{"pane":2,"number":5,"error":"no"}"#).unwrap().into_event();
        assert!(matches!(failed, Event::Failed { pane: 2, number: 5, .. }));
        let note = Answer::of_text(r#"{"note":"hm"}"#).unwrap().into_event();
        assert!(matches!(note, Event::Note(_)));
        assert!(Answer::of_text("hm").is_none());
    }

    #[test]
    fn a_request_has_the_scene() {
        let source = VolumeSource::Builtin { name: "cube".to_owned(), size: Some(8) };
        let one = OpenScene::open(&SceneFile::of_volume(source)).unwrap();
        let mut opened = one.clone();
        opened.add_layers_of(one);
        let opened = opened.with_layers(&[false, true]);
        let request =
            Request { pane: 0, number: 3, opened, urgency: Urgency::Moving, is_read_back: false };
        let text = request_text(&request).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!((&value["number"], &value["urgency"]), (&3.into(), &"moving".into()));
        assert_eq!(value["layers"], serde_json::json!([1]), "of the server's two");
        let scene = value["scene"].as_str().unwrap();
        let again = slabsplat::io::parse_scene(scene, "scene.toml").unwrap();
        assert_eq!(again.settings, request.opened.scene.settings);
    }
}
