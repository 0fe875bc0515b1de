//! Scene files: every key, every default, every kind of mistake.

use super::*;
use slabsplat_core::glam::DVec3;
use slabsplat_core::{Compositing, Light, Lookup, Method, Normalization};

fn read(text: &str) -> Result<SceneFile, IoError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    read_scene(&path)
}

const EVERY_KEY: &str = r#"
[volume]
generate = "cube"
size = 14
spacing = [1.0, 2.0, 3.0]

[classify]
opacity = [[0.0, 0.0], [255.0, 0.9]]
color = [[0.0, 0.1, 0.2, 0.3]]

[shading]
model = "phong"
ambient = 0.2
diffuse = 0.5
specular = 0.3
shininess = 9.0
two_sided = false
light = [0.0, 2.0, 0.0]

[camera]
projection = "perspective"
eye = [0.0, 0.0, 400]
target = [1.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
fov_y = 45.0

[image]
width = 64
height = 48
background = [0.1, 0.2, 0.3, 1.0]

[render]
method = "axis-aligned"
kernel = "crawfis-max"
slab_width = 2.0
compositing = "separate"
normalization = "product"
base_slab_width = 0.25
sections = 64
radial_samples = 32
lookup = "nearest"
opacity_cutoff = 0.99
backend = "cpu"
"#;

#[test]
fn scene_reads_every_key() {
    let scene = read(EVERY_KEY).unwrap();
    assert_eq!(scene.volume, VolumeSource::Builtin { name: "cube".into(), size: Some(14) });
    assert_eq!(scene.load_volume().unwrap().volume.grid().spacing(), [1.0, 2.0, 3.0]);
    let transfer = scene.transfer.as_ref().unwrap();
    assert_eq!((transfer.opacity(255.0), transfer.color(7.0)), (0.9, [0.1, 0.2, 0.3]));
    let light = Light::Direction(DVec3::Y);
    let phong = Phong {
        ambient: 0.2,
        diffuse: 0.5,
        specular: 0.3,
        shininess: 9.0,
        two_sided: false,
        light,
    };
    assert_eq!(scene.shading, Shading::Phong(phong));
    let camera = CameraDesc {
        projection: Some(ProjectionKind::Perspective),
        eye: Some([0.0, 0.0, 400.0]),
        target: Some([1.0, 0.0, 0.0]),
        up: Some([0.0, 1.0, 0.0]),
        view_height: None,
        fov_y: Some(45.0),
    };
    assert_eq!(scene.camera, camera);
    let image = ImageDesc { width: 64, height: 48, background: [0.1, 0.2, 0.3, 1.0] };
    assert_eq!(scene.image, image);
    let settings = RenderSettings {
        method: Method::AxisAligned,
        kernel: slabsplat_core::KernelName("crawfis-max".into()),
        slab_width: 2.0,
        compositing: Compositing::Separate,
        normalization: Normalization::Product,
        base_slab_width: 0.25,
        sections: 64,
        radial_samples: 32,
        lookup: Lookup::Nearest,
        opacity_cutoff: 0.99,
    };
    assert_eq!(scene.settings, settings);
    assert_eq!(scene.backend, "cpu");
}

#[test]
fn scene_keys_have_defaults() {
    let scene = read("[volume]\ngenerate = \"sphere\"").unwrap();
    let source = VolumeSource::Builtin { name: "sphere".into(), size: None };
    assert_eq!(scene, SceneFile::new(source));
    let unlit = read("volume = { generate = \"sphere\" }\nshading = { model = \"none\" }").unwrap();
    assert_eq!(unlit.shading, Shading::None);
    let preset = "volume = { generate = \"cube\" }\nclassify = { preset = \"ct-bone\" }";
    assert!(read(preset).unwrap().transfer.is_some());
}

#[test]
fn scene_paths_are_relative_to_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.toml");
    std::fs::write(&path, "[volume]\npath = \"../data/a.nrrd\"").unwrap();
    let expected = VolumeSource::File(dir.path().join("../data/a.nrrd"));
    assert_eq!(read_scene(&path).unwrap().volume, expected);
}

#[test]
fn scene_mistakes_are_named() {
    let check = |text: &str, expected: &[&str]| {
        let err = read(text).unwrap_err().to_string();
        assert!(!err.contains('\n'), "{err:?} is one line");
        for part in expected {
            assert!(err.contains(part), "{err:?} names {part:?}");
        }
    };
    let volume = "[volume]\ngenerate = \"cube\"\n";
    let with = |rest: &str| format!("{volume}{rest}");
    check(&with("[render]\nslabwidth = 1.0"), &["scene.toml:4", "unknown key `slabwidth`"]);
    check(&with("[rendering]\n"), &["scene.toml:3", "unknown key `rendering`"]);
    check(&with("[render]\nmethod = \"fast\""), &["scene.toml:4", "\"fast\"", "image-aligned"]);
    check(&with("[render]\nslab_width = -1.0"), &["slab_width", "-1"]);
    check(&with("[render]\nslab_width = nan"), &["slab_width", "NaN"]);
    check(&with("[render]\nslab_width = \"wide\""), &["scene.toml:4", "expected a number"]);
    check(&with("[image]\nwidth = 0"), &["[image]", "0 x 512"]);
    check(&with("[image]\nwidth = 99999999999"), &["scene.toml:4"]);
    check(&with("[shading]\nlight = \"sun\""), &["headlight", "sun"]);
    check(&with("[shading]\nlight = [0, 0, 0]"), &["light"]);
    check(&with("[shading]\nambient = -1"), &["ambient"]);
    check(&with("[classify]\nopacity = [[0, 0]]"), &["both opacity and color"]);
    check(&with("[classify]\npreset = \"fog\""), &["fog", "ct-bone"]);
    check(&with("[classify]\nfile = \"no.json\""), &["no.json"]);
    check(&with("[classify]\nopacity = [[0, 2]]\ncolor = [[0, 1, 1, 1]]"), &["opacity", "0 to 1"]);
    check(&with("[camera]\nprojection = \"fisheye\""), &["fisheye", "perspective"]);
    check("[volume]\n", &["either path or generate"]);
    check("[volume]\npath = \"a\"\nsize = 3", &["size goes with generate"]);
    check("[image]\n", &["volume"]);
    check("[volume\n", &["scene.toml:1"]);
}
