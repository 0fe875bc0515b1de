//! What is written is read back as it was.

use std::fs;

use slabsplat_core::glam::{DMat3, DVec3};
use slabsplat_core::{
    Annotations, Camera, Easing, Finish, Grid, Isosurface, LabelMap, Labels, Layer, Light, Mesh,
    MeshLayer, Plane, Projection, Region, SampleType, Scaling, Scene, TransferBox, TurnAxis,
    Volume,
};

use super::*;
use crate::transfer::TransferFit;
use crate::{
    ContentHash, FilmFile, KeyFile, KeyLayerFile, KeyLook, TransferImageFile, TurnFile,
    VolumeOptions, parse_scene,
};

/// Writes a scene, and reads it back as the same.
fn check(scene: &SceneFile) -> String {
    let text = scene_text(scene, "scene.toml").unwrap();
    let read = parse_scene(&text, "scene.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(read, *scene, "{text}");
    text
}

/// A scene that leaves nothing to be found from its volume.
fn of_volume(path: impl Into<std::path::PathBuf>) -> SceneFile {
    let file = SceneFile::of_volume(VolumeSource::File(path.into()));
    SceneFile { unsaid: Unsaid::default(), ..file }
}

fn of_mesh() -> SceneFile {
    SceneFile { unsaid: Unsaid::default(), ..SceneFile::of_mesh("a.ply") }
}

fn transfer() -> TransferFunction {
    let color = vec![(-1e-9, [0.1, 0.2, 1.0 / 3.0]), (1e9, [1.0; 3])];
    TransferFunction::new([(0.1 + 0.2, 0.0), (80.0, 0.7), (80.0, 1.0)], color).unwrap()
}

/// All that a layer can say, with numbers that have no short decimals.
fn full_layer() -> LayerFile {
    let ends = [DVec3::splat(-1.0 / 3.0), DVec3::new(1.0, 2.0, 1e20)];
    let style = LabelStyle::default().transfer(transfer()).color([0.3; 3]).opacity(0.1);
    let red = LabelStyle::default().color([1.0, 0.0, 0.0]);
    let options = VolumeOptions::default().series(3).channel(1).time(0).level(2);
    let hash = "xxh3:0123456789abcdef0123456789abcdef".parse().ok();
    LayerFile {
        name: Some("a \"name\"\nof two lines".to_owned()),
        options,
        spacing: Some([0.1, 0.2, 0.3]),
        raw: Some(RawDesc {
            dims: [3, 4, 5],
            sample_type: SampleType::U16,
            endian: Endian::Big,
            spacing: [1.0; 3],
            header_bytes: 352,
        }),
        hash,
        transfer: Some(transfer()),
        gradient_opacity: PiecewiseLinear::new("", [(0.0, 0.0), (1.0 / 7.0, 1.0)]).ok(),
        labels: Some(LabelsFile {
            hash,
            colors: Some(LabelColors::None),
            styles: [(-3, red.clone()), (1, style), (7, red)].into(),
            only: Some(vec![1, 7, -3]),
            ..LabelsFile::new("labels.nii".into())
        }),
        isosurfaces: vec![
            Isosurface::new(80.0, 0.5, Some([0.5; 3])).unwrap(),
            Isosurface::new(-1.5, 1.0, None).unwrap(),
        ],
        shading: Shading::Phong(Phong::default().diffuse(1.0 / 3.0).two_sided(false)),
        region: RegionDesc {
            ends: Some(ends),
            is_index: true,
            planes: vec![Plane::new(DVec3::new(1.0, -2.0, 0.3), 0.7).unwrap()],
            is_inverted: true,
            is_lit: true,
        },
        ..LayerFile::of_volume(VolumeSource::File("data/grün \\ 1.nii".into()))
    }
}

fn full_mesh() -> MeshFile {
    let turned = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.3);
    MeshFile {
        name: Some("implant".to_owned()),
        hash: "xxh3:0123456789abcdef0123456789abcdef".parse().ok(),
        color: Some([0.1, 0.2, 0.3]),
        line_width: Some(0.1 + 0.2),
        point_size: Some(1e9),
        world_from_mesh: DAffine3::from_mat3_translation(turned, DVec3::new(0.1, 2.0, 3.0)),
        shading: Shading::None,
        ..MeshFile::new("implant.stl")
    }
}

#[test]
fn written_scene_has_all_keys() {
    let mut scene = of_volume("a.nii");
    check(&scene);
    scene.layers = vec![full_layer()];
    let text = check(&scene);
    assert!(text.contains("[[layers]]") && text.contains("of = [-3, 7]"), "{text}");
    scene.layers[0].name = None;
    let text = check(&scene);
    assert!(text.contains("\n[volume]") && text.contains("[[labels.styles]]"), "{text}");
    let boxes = vec![
        TransferBox::new([0.0, 1.0 / 3.0], [0.5, f64::INFINITY]).unwrap().fade([0.1, 0.0]).unwrap(),
        TransferBox::new([f64::NEG_INFINITY, 3.0], [f64::NEG_INFINITY, f64::INFINITY]).unwrap(),
    ];
    scene.layers[0].transfer_2d = Some(TransferFunction2d::Boxes(boxes));
    check(&scene);
    let pixels = vec![[0.1, 0.2, 1.0 / 3.0, 1.0], [0.0, f32::MIN_POSITIVE, 0.7, 0.25]];
    let image = TransferImage::new(2, pixels, [-1.0, 1.0 / 3.0], [0.0, 9.0]).unwrap();
    scene.layers[0].transfer_2d = Some(TransferFunction2d::Image(image));
    check(&scene);
    let builtin = VolumeSource::Builtin { name: "cube".to_owned(), size: Some(8) };
    scene.layers.push(LayerFile::of_volume(builtin));
    scene.meshes = vec![full_mesh(), MeshFile::new("b.ply")];
    scene.lights = vec![
        Light::towards(DVec3::new(1.0, 2.0, 3.0)).unwrap().color([0.1, 0.2, 3.5]),
        Light::default(),
    ];
    scene.image.background = [0.1, 0.2, 0.3, 1.0 / 3.0];
    check(&scene);
    scene.lights.clear();
    assert!(!check(&scene).contains("[annotations]"), "nothing is said of none");
    let annotations = Annotations::default()
        .title("a \"title\" – µ")
        .axes()
        .scale_bar()
        .color_bar()
        .orientation_marker();
    let below = [1.0 / 3.0, 0.0, 1.0, 0.7];
    scene.finish = Finish::default().samples(16).background_below(below).annotations(annotations);
    check(&scene);
    let mut mesh = of_mesh();
    check(&mesh);
    mesh.meshes[0] = MeshFile { name: None, ..full_mesh() };
    let text = check(&mesh);
    assert!(text.contains("\n[mesh]"), "{text}");
}

#[test]
fn written_film_has_all_keys() {
    let mut scene = of_volume("a.nii");
    scene.film = Some(FilmFile::default());
    check(&scene);
    scene.layers.push(full_layer());
    scene.meshes = vec![full_mesh()];
    let look = KeyLook { transfer: Some(transfer()), fit: TransferFit::default() };
    let full = KeyLayerFile {
        layer_idx: 1,
        look: Some(look.clone()),
        isosurfaces: Some(full_layer().isosurfaces),
        region: Some(full_layer().region),
        opacity_scale: Some(1.0 / 3.0),
    };
    let everywhere =
        KeyLayerFile { region: Some(RegionDesc::default()), ..KeyLayerFile::default() };
    let camera = CameraDesc { eye: Some(DVec3::new(0.1, 1e20, 3.0)), ..CameraDesc::default() };
    let first = KeyFile { at_secs: 0.1, layers: vec![everywhere, full], ..KeyFile::default() };
    let second = KeyFile {
        at_secs: 1.0 / 3.0,
        easing: Some(Easing::EaseOut),
        camera: Some(camera),
        azimuth_degrees: Some(-720.1),
        slab_width: Some(0.7),
        layers: Vec::new(),
    };
    scene.film = Some(FilmFile {
        frames_per_second: Some(29.97),
        seconds: Some(1.0 / 7.0),
        is_loop: true,
        easing: Easing::EaseInOut,
        keys: vec![first, second],
        turn: None,
    });
    check(&scene);
    let film = scene.film.as_mut().unwrap();
    let fit = TransferFit { opacity_scale: 2.0, ..TransferFit::default() };
    film.keys[0].layers[1].look = Some(KeyLook { fit, ..look });
    let error = scene_text(&scene, "x.toml").unwrap_err().to_string();
    assert!(error.contains("it leaves open what is found"), "{error}");
    let turn = TurnFile::new(TurnAxis::Right, -1.0 / 3.0, true);
    scene.film = Some(FilmFile { turn: Some(turn), seconds: Some(0.1), ..FilmFile::default() });
    check(&scene);
}

#[test]
fn written_transfer_image_is_named_if_it_has_a_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("transfer.png");
    image::RgbaImage::from_pixel(2, 2, image::Rgba([255, 0, 0, 51])).save(&path).unwrap();
    let file = TransferImageFile { path, values: [0.0, 1.0], gradients: [0.0, 2.0] };
    let mut scene = of_volume(dir.path().join("a.nii"));
    scene.layers[0].transfer_2d = Some(file.load().unwrap());
    scene.layers[0].transfer_image = Some(file);
    let written = dir.path().join("scene.toml");
    write_scene(&written, &scene).unwrap();
    let text = fs::read_to_string(&written).unwrap();
    assert!(
        text.contains("file = \"transfer.png\"") && text.contains("path = \"a.nii\""),
        "{text}"
    );
    assert_eq!(crate::read_scene(&written).unwrap(), scene);
}

#[test]
fn written_scenes_show_something() {
    let mut scene = of_mesh();
    scene.meshes.clear();
    let error = scene_text(&scene, "x.toml").unwrap_err().to_string();
    assert_eq!(error, "cannot write the scene x.toml: it shows nothing");
}

#[test]
fn written_scenes_leave_nothing_open_that_text_cannot() {
    let unsaid = SceneFile::of_mesh("a.ply");
    let text = "volume = { path = \"a.nii\" }\n[classify]\n";
    let fits =
        ["window = [0, 1]", "preset = \"gray\"", "colormap = \"turbo\"", "opacity_scale = 2"];
    let fitted = fits.map(|key| parse_scene(&format!("{text}{key}"), "x.toml").unwrap());
    for scene in fitted.into_iter().chain([unsaid]) {
        let error = scene_text(&scene, "x.toml").unwrap_err().to_string();
        assert!(error.contains("it leaves open what is found"), "{error}");
    }
}

#[cfg(unix)]
#[test]
fn written_paths_are_text() {
    use std::os::unix::ffi::OsStrExt;
    let path = Path::new(std::ffi::OsStr::from_bytes(b"a\xff.nii"));
    let scene = of_volume(path);
    let error = scene_text(&scene, "x.toml").unwrap_err().to_string();
    assert!(error.starts_with("cannot write the scene x.toml: path contains invalid"), "{error}");
}

fn volume() -> Volume {
    let grid = Grid::with_spacing([2, 2, 1], [1.0; 3]).unwrap();
    Volume::new(grid, vec![0_u8, 1, 2, 3].into(), Scaling::IDENTITY).unwrap()
}

#[test]
fn completed_scene_leaves_nothing_open() {
    let file = SceneFile {
        layers: vec![LayerFile {
            labels: Some(LabelsFile::new("labels.nii".into())),
            ..LayerFile::of_volume(VolumeSource::File("a.nii".into()))
        }],
        ..SceneFile::of_mesh("a.ply")
    };
    let volume = volume();
    let map = LabelMap::new(&volume, volume.grid()).unwrap();
    let red = LabelStyle::default().color([1.0, 0.0, 0.0]);
    let labels = Labels::new(map, [(2, red.clone())]).unwrap();
    let region = Region::in_box([[0.0; 3], [1.0; 3]]).unwrap().inverted();
    let layer = Layer::new(volume, transfer()).labels(labels.clone()).region(region.clone());
    // An angle that no number of degrees is.
    let fov_y_radians = (0..99).map(|n| 0.7 + 1e-3 * f64::from(n));
    let fov_y_radians =
        fov_y_radians.into_iter().find(|a| slabsplat_core::exact_degrees(*a).is_none());
    let projection = Projection::Perspective { fov_y_radians: fov_y_radians.unwrap() };
    let camera = Camera::new([9.0, 0.1, 0.2], [0.0; 3], [0.0, 0.0, 3.0], projection).unwrap();
    let scene = Scene::new(layer, camera).meshes(vec![MeshLayer::new(Mesh::default())]);
    let completed = file.completed(&scene).unwrap();
    check(&completed);
    let [layer] = completed.layers.as_slice() else { panic!("{completed:?}") };
    assert_eq!(layer.hash, Some(ContentHash::of_volume(&scene.layers[0].volume, None)));
    assert_eq!(layer.warning_of(&scene.layers[0].volume, None), None);
    assert_eq!(layer.transfer, Some(transfer()));
    assert_eq!(layer.region.on(scene.layers[0].volume.grid()), Ok(region));
    let of_labels = layer.labels.as_ref().unwrap();
    assert_eq!(of_labels.styles, [(2, red)].into());
    assert_eq!(completed.meshes[0].hash, Some(ContentHash::of_mesh(&scene.meshes[0].mesh)));
    let fallback = Camera::new(
        [1.0; 3],
        [0.0; 3],
        [0.0, 0.0, 1.0],
        Projection::Orthographic { view_height: 1.0 },
    );
    assert_eq!(completed.camera.complete(&fallback.unwrap()), Ok(camera));
    let unnamed = SceneFile {
        layers: vec![LayerFile::of_volume(VolumeSource::File("a.nii".into()))],
        ..file
    };
    let error = unnamed.completed(&scene).unwrap_err().to_string();
    assert!(error.contains("the labels of layer 0 come from no file"), "{error}");
}
