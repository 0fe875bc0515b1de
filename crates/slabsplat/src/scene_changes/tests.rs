//! What is changed, written and shown again is the same scene.

use super::*;
use fastrand::Rng;
use slabsplat_core::glam::{DAffine3, DMat3, DVec3};
use slabsplat_core::{
    Annotations, Camera, Finish, ImageDesc, Isosurface, LabelStyle, Light, Method, Mode, Phong,
    PiecewiseLinear, Plane, Projection, Region, RenderSettings, TransferBox, TransferFunction,
    TransferImage,
};
use slabsplat_io::{
    LabelsFile, VolumeSource, builtin_volume, parse_scene, parse_scene_alone, scene_text,
    write_volume,
};
use slabsplat_seeds::for_each_seed;
use std::fs;
use std::path::Path;

/// Two volumes, one of them with labels, and a mesh.
fn opened(folder: &Path) -> OpenScene {
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
               0 0 0\n9 0 0\n0 9 4\n3 0 1 2\n";
    fs::write(folder.join("a.ply"), ply).unwrap();
    let labels = folder.join("labels.nrrd");
    write_volume(&labels, &builtin_volume("cube", Some(8)).unwrap()).unwrap();
    let builtin = |name: &str| VolumeSource::Builtin { name: name.to_owned(), size: Some(8) };
    let mut file = SceneFile::of_volume(builtin("sphere"));
    file.layers.push(LayerFile::of_volume(builtin("cube")));
    file.layers[1].labels = Some(LabelsFile::new(labels));
    file.meshes.push(MeshFile::new(folder.join("a.ply")));
    OpenScene::open(&file).unwrap()
}

fn vector(rng: &mut Rng) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| 20.0 * rng.f64() - 10.0))
}

fn color(rng: &mut Rng) -> [f64; 3] {
    [(); 3].map(|()| rng.f64())
}

fn transfer(rng: &mut Rng) -> TransferFunction {
    let n_points = rng.u8(1..5);
    let at = |rng: &mut Rng| 300.0 * rng.f64() - 20.0;
    let mut opacity: Vec<_> = (0..n_points).map(|_| (at(rng), [rng.f64()])).collect();
    let mut colors: Vec<_> = (0..n_points).map(|_| (at(rng), color(rng))).collect();
    opacity.sort_by(|a, b| a.0.total_cmp(&b.0));
    colors.sort_by(|a, b| a.0.total_cmp(&b.0));
    TransferFunction::new(opacity, colors).unwrap()
}

fn transfer_2d(rng: &mut Rng) -> TransferFunction2d {
    if rng.bool() {
        let ends = |rng: &mut Rng| [rng.f64(), 1.0 + 90.0 * rng.f64()];
        let one = TransferBox::new(ends(rng), ends(rng)).unwrap();
        return TransferFunction2d::Boxes(vec![one.color(color(rng)).unwrap()]);
    }
    let pixels: Vec<_> = (0..6).map(|_| [(); 4].map(|()| rng.f32())).collect();
    let image = TransferImage::new(3, pixels, [rng.f64(), 9.0], [rng.f64(), 7.0]);
    TransferFunction2d::Image(image.unwrap())
}

fn region(rng: &mut Rng) -> Region {
    let plane = |rng: &mut Rng| Plane::new(vector(rng) + 11.0, rng.f64()).unwrap();
    let region = Region::new((0..rng.u8(..3)).map(|_| plane(rng)).collect());
    let region = if rng.bool() { region.inverted() } else { region };
    if rng.bool() { region.lit() } else { region }
}

fn shading(rng: &mut Rng) -> Shading {
    match rng.u8(..3) {
        0 => Shading::None,
        _ => Shading::Phong(Phong::default().diffuse(rng.f64()).two_sided(rng.bool())),
    }
}

fn camera(rng: &mut Rng) -> Camera {
    let projection = match rng.bool() {
        true => Projection::Orthographic { view_height: 1.0 + 9.0 * rng.f64() },
        false => Projection::Perspective { fov_y_radians: 0.1 + rng.f64() },
    };
    Camera::new(vector(rng), vector(rng), vector(rng), projection).unwrap()
}

fn change_layer(rng: &mut Rng, layer: &mut Layer) {
    layer.transfer = transfer(rng);
    layer.transfer_2d = rng.bool().then(|| transfer_2d(rng));
    let by_gradient = |rng: &mut Rng| PiecewiseLinear::new("", [(0.0, 0.1), (rng.f64(), 1.0)]);
    layer.gradient_opacity = rng.bool().then(|| by_gradient(rng).unwrap());
    let surface = |rng: &mut Rng| {
        let own = rng.bool().then(|| color(rng));
        Isosurface::new(200.0 * rng.f64(), rng.f64(), own).unwrap()
    };
    layer.isosurfaces = (0..rng.u8(..3)).map(|_| surface(rng)).collect();
    layer.shading = shading(rng);
    layer.region = region(rng);
    layer.labels = layer.labels.take().filter(|_| rng.u8(..4) != 0).map(|labels| {
        let style = |rng: &mut Rng| match rng.u8(..3) {
            0 => LabelStyle::default().color(color(rng)),
            1 => LabelStyle::default().opacity(rng.f64()),
            _ => LabelStyle::default().transfer(transfer(rng)),
        };
        let styles: Vec<_> = (0..rng.u8(..4)).map(|_| (rng.i64(-2..256), style(rng))).collect();
        labels.with_styles(styles).unwrap()
    });
}

fn change_mesh(rng: &mut Rng, mesh: &mut MeshLayer) {
    let turned = DMat3::from_axis_angle(DVec3::Z, rng.f64()) * (0.1 + rng.f64());
    let place = DAffine3::from_mat3_translation(turned, vector(rng));
    *mesh = mesh.clone().placed(place).unwrap().shading(shading(rng)).region(region(rng));
    mesh.color = rng.bool().then(|| color(rng));
    mesh.line_width = rng.bool().then(|| 0.1 + rng.f64());
    mesh.point_size = rng.bool().then(|| 0.1 + rng.f64());
}

fn change(rng: &mut Rng, scene: &mut Scene) {
    scene.layers.iter_mut().for_each(|layer| change_layer(rng, layer));
    scene.meshes.iter_mut().for_each(|mesh| change_mesh(rng, mesh));
    scene.camera = camera(rng);
    let light = |rng: &mut Rng| Light::towards(vector(rng)).unwrap().color(color(rng));
    scene.lights = (0..rng.u8(..3)).map(|_| light(rng)).collect();
    let background = [(); 4].map(|()| rng.f32());
    scene.image = ImageDesc::new(rng.u32(1..900), rng.u32(1..900)).background(background);
    scene.settings = RenderSettings::default()
        .slab_width(0.1 + rng.f64())
        .method(*rng.choice(Method::ALL).unwrap())
        .mode(*rng.choice(Mode::ALL).unwrap());
    let finish = Finish::default().samples(rng.u32(1..9).pow(2));
    scene.finish = finish.annotations(Annotations::default().title(format!("{}", rng.u64(..))));
    scene.finish.background_below = rng.bool().then(|| [(); 4].map(|()| rng.f32()));
}

#[test]
fn scene_is_shown_as_it_was_written() {
    let dir = tempfile::tempdir().unwrap();
    let opened = opened(dir.path());
    assert_eq!(opened.shown_as(&opened.to_file().unwrap()).unwrap().scene, opened.scene);
    for_each_seed(400, |mut rng| {
        let mut changed = opened.clone();
        change(&mut rng, &mut changed.scene);
        changed.backend = "cpu".to_owned();
        let text = scene_text(&changed.to_file().unwrap(), "scene.toml").unwrap();
        let file = parse_scene_alone(&text, "scene.toml").unwrap();
        assert_eq!(parse_scene(&text, "scene.toml").unwrap(), file);
        let shown = opened.shown_as(&file).unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(shown.scene, changed.scene, "{text}");
        assert_eq!(shown.backend, "cpu");
        let again = scene_text(&shown.to_file().unwrap(), "scene.toml").unwrap();
        assert_eq!(again, text);
    });
}

#[test]
fn scene_of_something_else_is_not_shown() {
    let dir = tempfile::tempdir().unwrap();
    let opened = opened(dir.path());
    let file = opened.to_file().unwrap();
    let failed = |file: &SceneFile| opened.shown_as(file).unwrap_err();
    let mut fewer = file.clone();
    fewer.layers.pop();
    let error = failed(&fewer);
    assert!(matches!(error, OpenError::OtherScene { n_layers: 2, n_meshes: 1 }), "{error}");
    let mut labelled = file.clone();
    labelled.layers[0].labels = Some(LabelsFile::new("nowhere.nii".into()));
    assert!(matches!(failed(&labelled), OpenError::NoLabels { layer_idx: 0 }));
    let mut image = file.clone();
    image.layers[1].transfer_image =
        Some(slabsplat_io::TransferImageFile::new("nowhere.png", [0.0, 1.0], [0.0, 1.0]));
    let error = failed(&image).to_string();
    assert!(error.contains("nowhere.png is not read"), "{error}");
}

/// What a file leaves open stays.
#[test]
fn scene_keeps_what_is_not_said() {
    let dir = tempfile::tempdir().unwrap();
    let mut opened = opened(dir.path());
    change(&mut Rng::with_seed(7), &mut opened.scene);
    let mut file = opened.to_file().unwrap();
    file.unsaid = slabsplat_io::Unsaid::ALL;
    file.camera = slabsplat_io::CameraDesc::default();
    file.layers.iter_mut().for_each(|layer| layer.transfer = None);
    let mut other = file.clone();
    other.lights = vec![Light::default(); 3];
    other.image.background = [0.5; 4];
    other.layers[0].shading = Shading::None;
    for file in [file, other] {
        assert_eq!(opened.shown_as(&file).unwrap().scene, opened.scene);
    }
}

/// A picture of a transfer function is known by its name, and not read again.
#[test]
fn scene_has_its_transfer_image() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("t.png");
    let image = slabsplat_core::Image::filled(2, 2, [0.5, 0.25, 0.0, 0.5]);
    slabsplat_io::write_png(&path, &image).unwrap();
    let text = "volume = { generate = \"cube\", size = 8 }\n\
                classify = { image = { file = \"t.png\", values = [0, 9], gradients = [0, 5] } }\n";
    let file = parse_scene(text, dir.path().join("scene.toml")).unwrap();
    let opened = OpenScene::open(&file).unwrap();
    fs::remove_file(path).unwrap();
    let text = scene_text(&opened.to_file().unwrap(), dir.path().join("scene.toml")).unwrap();
    let file = parse_scene_alone(&text, "elsewhere.toml").unwrap();
    assert_eq!(file.layers[0].transfer_2d, None);
    assert_eq!(opened.shown_as(&file).unwrap().scene, opened.scene);
}
