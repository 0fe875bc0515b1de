//! Viewers that behave well get what they ask for.

use crate::client::{Viewer, block_on, get, opened, session, started, turned};
use serde_json::json;
use slabsplat::glam::DAffine3;
use slabsplat::io::{SceneFile, VolumeSource};
use slabsplat::{LabelStyle, OpenScene, Renderer, TransferFunction, io};
use slabsplat_serve::{ServeConfig, Server, serve};
use std::path::Path;

/// The picture of a scene, as bytes of straight red, green, blue and opacity.
fn rendered(scene: &str) -> Vec<u8> {
    let file = io::parse_scene(scene, "scene.toml").expect("it is a scene");
    let opened = opened().shown_as(&file).expect("it is of this scene");
    let mut renderer = Renderer::open("cpu", |_| {}).expect("the CPU is always there");
    let picture = renderer.picture(&opened.scene, opened.acquisition).expect("it can be drawn");
    picture.frame.image.to_rgba8()
}

#[test]
fn two_viewers_get_their_pictures() {
    let server = started(ServeConfig::default());
    block_on(async {
        let (mut a, mut b) = (Viewer::connect(&server).await, Viewer::connect(&server).await);
        let scenes = [turned(0.4, [64, 48]), turned(-1.1, [50, 70])];
        a.ask(0, 7, "rest", &scenes[0]).await;
        b.ask(3, 8, "rest", &scenes[1]).await;
        for (viewer, scene, pane, number) in
            [(&mut a, &scenes[0], 0, 7), (&mut b, &scenes[1], 3, 8)]
        {
            let (header, bytes) = viewer.picture().await;
            assert_eq!((&header["pane"], &header["number"]), (&json!(pane), &json!(number)));
            assert_eq!((&header["urgency"], &header["format"]), (&json!("rest"), &json!("png")));
            assert!(header["ms"].is_f64() && header["n_voxels"].is_u64(), "{header}");
            assert_eq!(header["notes"], json!([]));
            let image = image::load_from_memory(&bytes).expect("it is a PNG").into_rgba8();
            assert!(image.into_raw() == rendered(scene), "to the byte");
        }
        a.ask(0, 9, "moving", &scenes[1]).await;
        let (header, bytes) = a.picture().await;
        assert_eq!((&header["format"], &header["number"]), (&json!("jpeg"), &json!(9)));
        let image = image::load_from_memory(&bytes).expect("it is a JPEG").into_rgba8();
        assert_eq!(image.dimensions(), (50, 70));
        let expected = rendered(&scenes[1]);
        let difference = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b));
        let sum: f64 = image.as_raw().iter().zip(&expected).map(difference).sum();
        assert!(sum / (expected.len() as f64) < 3.0, "{sum}");
    });
}

/// What shines through cannot be a JPEG.
#[test]
fn transparent_pictures_stay_so() {
    let server = started(ServeConfig::default());
    let mut opened = opened();
    opened.scene.image.background = [0.2, 0.3, 0.4, 0.5];
    let scene = io::scene_text(&opened.to_file().unwrap(), "scene.toml").unwrap();
    block_on(async {
        let mut viewer = Viewer::connect(&server).await;
        viewer.ask(0, 1, "moving", &scene).await;
        let (header, bytes) = viewer.picture().await;
        assert_eq!(header["format"], json!("png"));
        let image = image::load_from_memory(&bytes).expect("it is a PNG").into_rgba8();
        assert_eq!(image.get_pixel(0, 0).0, [51, 77, 102, 128]);
    });
}

#[test]
fn session_tells_of_the_scene() {
    let server = started(ServeConfig::default().name("a ball"));
    let session = session(&server);
    assert_eq!(session["name"], json!("a ball"));
    assert_eq!(session["warnings"], json!([]));
    assert_eq!(session["found"].as_array().map(Vec::len), Some(1));
    let layer = &session["layers"][0];
    assert_eq!((&layer["range"], &layer["labels"]), (&json!([0.0, 255.0]), &json!([])));
    let told = ["modality", "orientation", "is_metric"].map(|key| &layer[key]);
    assert_eq!(told, [&json!(null), &json!("unknown"), &json!(false)]);
    let counts: Vec<u64> =
        layer["counts"].as_array().unwrap().iter().map(|it| it.as_u64().unwrap()).collect();
    assert_eq!((counts.len(), counts.iter().sum::<u64>()), (256, 16 * 16 * 16));
    let text = session["scene"].as_str().unwrap();
    assert!(!text.contains("hash"), "{text}");
    let file = io::parse_scene(text, "scene.toml").unwrap();
    assert_eq!(opened().shown_as(&file).unwrap().scene.camera, opened().scene.camera);
    let (status, head, body) = get(&server, "/overview/0?token=secret");
    assert!(status == 200 && head.contains("no-cache"), "{head}");
    let files = io::FilesInMemory::from_iter([("a.nrrd", body.as_slice())]);
    let volume = files.read_volume("a.nrrd").unwrap().volume;
    let original = opened().scene.layers.remove(0).volume;
    assert_eq!(volume.grid(), original.grid());
    assert!((0..original.grid().n_voxels()).all(|idx| volume.value(idx) == original.value(idx)));
    for (path, expected) in [("/overview/1", 404), ("/overview/x", 404), ("/overview/", 404)] {
        assert_eq!(get(&server, &format!("{path}?token=secret")).0, expected, "{path}");
    }
}

/// A sphere with labels, and a red triangle.
fn labels_and_mesh(folder: &Path) -> OpenScene {
    let path = |name: &str| folder.join(name).display().to_string();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
               -30 -30 0\n30 0 0\n0 30 4\n3 0 1 2\n";
    std::fs::write(path("a.ply"), ply).expect("the folder is ours");
    let labels = io::builtin_volume("cube", Some(16)).expect("it is built in");
    io::write_volume(path("labels.nrrd"), &labels).expect("the folder is ours");
    let text = format!(
        "image = {{ width = 64, height = 48, background = [0, 0, 0, 1] }}\nrender = {{ backend = \"cpu\" }}\n\
         [[layers]]\nvolume = {{ generate = \"sphere\", size = 16 }}\nlabels = {{ path = {:?} }}\n\
         [[layers]]\nmesh = {{ path = {:?}, color = [1, 0, 0] }}\n",
        path("labels.nrrd"),
        path("a.ply")
    );
    let file = io::parse_scene(&text, "scene.toml").expect("it is a scene");
    OpenScene::open(&file).expect("its files are there")
}

fn picture(opened: &OpenScene) -> Vec<u8> {
    let mut renderer = Renderer::open("cpu", |_| {}).expect("the CPU is always there");
    let picture = renderer.picture(&opened.scene, opened.acquisition).expect("it can be drawn");
    picture.frame.image.to_rgba8()
}

/// What a server answers to a scene, at rest.
fn answered(server: &Server, file: &SceneFile) -> Vec<u8> {
    answered_of(server, file, None)
}

/// The same of some of its layers.
fn answered_of(server: &Server, file: &SceneFile, layers: Option<&[usize]>) -> Vec<u8> {
    let scene = io::scene_text(file, "scene.toml").expect("it has a text");
    let ask = json!({
        "pane": 0, "number": 1, "urgency": "rest", "layers": layers, "scene": scene,
    });
    block_on(async {
        let mut viewer = Viewer::connect(server).await;
        viewer.send(&ask.to_string()).await;
        let (_, bytes) = viewer.picture().await;
        image::load_from_memory(&bytes).expect("it is a PNG").into_rgba8().into_raw()
    })
}

/// A viewer has neither meshes nor labels of voxels, and does not take them away.
#[test]
fn labels_and_meshes_stay() {
    let dir = tempfile::tempdir().unwrap();
    let opened = labels_and_mesh(dir.path());
    let expected = picture(&opened);
    let mut without_labels = opened.clone();
    without_labels.scene.layers[0].labels = None;
    assert!(picture(&without_labels) != expected, "labels are seen");
    let mut file = opened.to_file().unwrap();
    file.layers[0].labels = None;
    (file.meshes[0].color, file.meshes[0].name) = (None, Some("mesh".to_owned()));
    let server = serve(opened, ServeConfig::default().token("secret")).unwrap();
    assert!(session(&server)["layers"][0]["labels"].as_array().is_some_and(|it| 1 < it.len()));
    assert!(answered(&server, &file) == expected);
}

/// And it may have them look otherwise.
#[test]
fn labels_and_meshes_are_edited() {
    let dir = tempfile::tempdir().unwrap();
    let mut opened = labels_and_mesh(dir.path());
    let server = serve(opened.clone(), ServeConfig::default().token("secret")).unwrap();
    let before = picture(&opened);
    opened.scene.meshes[0].color = Some([0.0, 1.0, 0.0]);
    let labels = opened.scene.layers[0].labels.take().unwrap();
    let mut styles = labels.styles().clone();
    let label = *labels.of_voxels().last().unwrap();
    styles.insert(label, LabelStyle::default().opacity(0.25).color([0.0, 0.0, 1.0]));
    opened.scene.layers[0].labels = Some(labels.with_styles(styles).unwrap());
    let expected = picture(&opened);
    assert!(expected != before);
    let mut file = opened.to_file().unwrap();
    // A page knows nothing of where they are.
    file.meshes[0].world_from_mesh = DAffine3::IDENTITY;
    file.meshes[0].path = "elsewhere.ply".into();
    assert!(answered(&server, &file) == expected);
}

/// Layers are hidden, shown alone and removed by a viewer that says which are left; each is then edited as
/// before, with the labels that it has here.
#[test]
fn layers_are_left_out() {
    let dir = tempfile::tempdir().unwrap();
    let mut all = labels_and_mesh(dir.path());
    for name in ["cube", "neuron"] {
        let source = VolumeSource::Builtin { name: name.to_owned(), size: Some(16) };
        all.add_layers_of(OpenScene::open(&SceneFile::of_volume(source)).unwrap());
    }
    let server = serve(all.clone(), ServeConfig::default().token("secret")).unwrap();
    let mut seen = vec![answered(&server, &all.to_file().unwrap())];
    assert!(seen[0] == picture(&all));
    for keeps in [[true, false, true], [false, true, true], [false, false, true], [false; 3]] {
        let mut some = all.with_layers(&keeps);
        for layer in &mut some.scene.layers {
            let (opacity, color) = (layer.transfer.opacity_points(), layer.transfer.color_points());
            layer.transfer = TransferFunction::of_curves(opacity.multiplied(0.5), color.clone());
        }
        let mut file = some.to_file().unwrap();
        file.layers.iter_mut().for_each(|layer| layer.labels = None);
        let answered = answered_of(&server, &file, Some(&some.layer_numbers()));
        assert!(answered == picture(&some), "{keeps:?}");
        assert!(!seen.contains(&answered), "{keeps:?}");
        seen.push(answered);
    }
}
