//! Whole scene files.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Field, KernelName, Light, Lookup, Method, Mode, Normalization, Phong, Plane, ProjectionKind,
    Setting, Settings, Shading,
};

use super::*;
use crate::{ColorUse, OpacitySource, Stretch, ValueScale, colormap, preset};

/// Every key, and no value a default.
const FULL: &str = r#"
[volume]
path = "data/head.nrrd"
spacing = [1, 1.5, 2.0]

[classify]
opacity = [[0.0, 0.0], [80.0, 0.0], [255.0, 0.9]]
color = [
  [0, 0, 0, 0],
  [255.0, 1.0, 0.9, 0.8],
]
gradient_opacity = [[0.0, 0.0], [20.0, 1.0]]
isosurfaces = [{ value = 80 }, { value = 0.5, opacity = 0.25, color = [1, 0, 0.5] }]

[region]
box = [[-90, -120, -60.5], [0, 90, 100]]
index = true
planes = [[0.0, 0.0, 2.0, 12.0]]
invert = true
lit = true

[shading]
model = "phong"
ambient = 0.2
diffuse = 0.6
specular = 0.1
shininess = 10.0
two_sided = false

[[lights]]
from = [0.0, 0, 2.0]
color = [1.0, 0.5, 2.0]
[[lights]]
from = "headlight"

[camera]
projection = "perspective"
eye = [0.0, 0.0, 400.0]
target = [1.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
view_height = 256.0
fov_y = 34.0

[image]
width = 64
height = 32
background = [0.1, 0.2, 0.3, 1.0]

[render]
method = "every-sample"
kernel = "crawfis-max"
slab_width = 2.0
mode = "separate"
normalization = "product"
base_slab_width = 0.25
sections = 64
radial_samples = 32
lookup = "nearest"
opacity_cutoff = 0.99
tolerance = 0.004
backend = "auto"
"#;

const SMALL: &str = "[volume]\ngenerate = \"cube\"\nsize = 8\n";

fn read(text: &str) -> Result<SceneFile, String> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    let folder = format!("{}/", dir.path().display());
    read_scene(&path).map_err(|e| e.to_string().replace(&folder, ""))
}

/// The only layer of a scene.
fn read_layer(text: &str) -> LayerFile {
    let mut layers = read(text).unwrap().layers;
    assert_eq!(layers.len(), 1);
    layers.remove(0)
}

#[test]
fn scene_has_every_key() {
    let scene = read(FULL).unwrap();
    let [layer] = scene.layers.as_slice() else { panic!("{:?}", scene.layers) };
    let VolumeSource::File(path) = &layer.volume else { panic!("{:?}", layer.volume) };
    assert!(path.is_absolute() && path.ends_with("data/head.nrrd"), "{}", path.display());
    assert_eq!(layer.spacing, Some([1.0, 1.5, 2.0]));
    let transfer = layer.transfer.as_ref().unwrap();
    assert_eq!(transfer.opacity(255.0), 0.9);
    assert_eq!(layer.gradient_opacity.as_ref().unwrap().at(5.0), [0.25]);
    assert_eq!(transfer.color(255.0), [1.0, 0.9, 0.8]);
    let translucent = Isosurface::new(0.5, 0.25, Some([1.0, 0.0, 0.5])).unwrap();
    assert_eq!(layer.isosurfaces, [Isosurface::new(80.0, 1.0, None).unwrap(), translucent]);
    let ends = [[-90.0, -120.0, -60.5], [0.0, 90.0, 100.0]].map(DVec3::from_array);
    let planes = vec![Plane::new(DVec3::Z, 6.0).unwrap()];
    let region =
        RegionDesc { ends: Some(ends), is_index: true, planes, is_inverted: true, is_lit: true };
    assert_eq!(layer.region, region);
    let Shading::Phong(phong) = layer.shading else { panic!("{:?}", layer.shading) };
    assert_eq!([phong.ambient, phong.diffuse, phong.specular], [0.2, 0.6, 0.1]);
    assert_eq!((phong.shininess, phong.two_sided), (10.0, false));
    let orange = Light::towards(DVec3::Z).unwrap().color([1.0, 0.5, 2.0]);
    assert_eq!(scene.lights, [orange, Light::default()]);
    let camera = scene.camera;
    assert_eq!(camera.projection, Some(ProjectionKind::Perspective));
    assert_eq!([camera.view_height, camera.fov_y], [Some(256.0), Some(34.0)]);
    let vectors = [camera.eye, camera.target, camera.up];
    assert_eq!(vectors, [Some(DVec3::Z * 400.0), Some(DVec3::X), Some(DVec3::Y)]);
    let background = [0.1, 0.2, 0.3, 1.0];
    assert_eq!(scene.image, ImageDesc { width: 64, height: 32, background });
    let settings = &scene.settings;
    assert_eq!(settings.method, Method::EverySample);
    assert_eq!(settings.kernel.0, "crawfis-max");
    assert_eq!(settings.mode, Mode::Separate);
    assert_eq!(settings.normalization, Normalization::Product);
    assert_eq!(settings.lookup, Lookup::Nearest);
    assert_eq!([settings.slab_width, settings.base_slab_width], [2.0, 0.25]);
    assert_eq!([settings.sections, settings.radial_samples], [64, 32]);
    assert_eq!(settings.opacity_cutoff, 0.99);
    assert_eq!(settings.tolerance, 0.004);
    assert_eq!(scene.backend, "auto");
}

/// Each row alone, with another value than the default.
#[test]
fn scene_reads_every_setting() {
    for row in RenderSettings::ROWS {
        let settings = changed(row);
        let text = format!("{SMALL}[render]\n{} = {}", row.name, toml_of(row, &settings));
        assert_eq!(read(&text).unwrap().settings, settings, "{text}");
    }
    for row in Phong::ROWS {
        let phong = changed(row);
        let text = format!("{SMALL}[shading]\n{} = {}", row.name, toml_of(row, &phong));
        assert_eq!(read_layer(&text).shading, Shading::Phong(phong), "{text}");
    }
}

/// The defaults, but for one row.
fn changed<S: Settings>(row: &Setting<S>) -> S {
    let mut settings = S::default();
    let text = row.text(&settings);
    match &row.field {
        Field::Choice { names, set, .. } => {
            set(&mut settings, names.iter().find(|name| **name != text).unwrap()).unwrap();
        }
        Field::Kernel(access) => (access.set)(&mut settings, KernelName("crawfis-max".into())),
        Field::Number { access, .. } => {
            let half = 0.5 * (access.get)(&settings);
            (access.set)(&mut settings, half);
        }
        Field::Count { access, .. } => {
            let half = (access.get)(&settings) / 2;
            (access.set)(&mut settings, half);
        }
        Field::Switch(access) => {
            let other = !(access.get)(&settings);
            (access.set)(&mut settings, other);
        }
    }
    settings
}

fn toml_of<S>(row: &Setting<S>, settings: &S) -> String {
    let text = row.text(settings);
    match row.field {
        Field::Choice { .. } | Field::Kernel(_) => format!("{text:?}"),
        Field::Number { .. } | Field::Count { .. } | Field::Switch(_) => text,
    }
}

#[test]
fn scene_defaults() {
    let scene = read(SMALL).unwrap();
    let cube = VolumeSource::Builtin { name: "cube".to_owned(), size: Some(8) };
    assert_eq!(scene.layers, [LayerFile::of_volume(cube)]);
    assert_eq!(read_layer(&format!("{SMALL}[classify]")).transfer, None);
    assert_eq!(scene.camera, CameraDesc::default());
    assert_eq!(scene.lights, [Light::default()]);
    assert_eq!(read(&format!("lights = []\n{SMALL}")).unwrap().lights, []);
    assert_eq!(scene.image, ImageDesc::default());
    assert_eq!(scene.settings, RenderSettings::default());
    assert_eq!(scene.backend, "cpu");
    let unshaded = read_layer(&format!("{SMALL}[shading]\nmodel = \"none\""));
    assert_eq!(unshaded.shading, Shading::None);
}

#[test]
fn scene_classify_by_preset_or_file() {
    let bone = read_layer(&format!("{SMALL}[classify]\npreset = \"ct-bone\""));
    assert_eq!(bone.transfer, Some(preset("ct-bone").unwrap().source.transfer));
    assert_eq!((bone.fit.scale, bone.fit.preset.as_deref()), (ValueScale::Values, Some("ct-bone")));
    let white = read_layer(&format!("{SMALL}[classify]\nopacity = [[0, 0.5]]"));
    assert_eq!(white.transfer.unwrap().color(3.0), [1.0; 3]);

    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("map.json"), r#"[{"RGBPoints": [0, 1, 0, 0]}]"#).unwrap();
    let path = dir.path().join("scene.toml");
    fs::write(&path, format!("{SMALL}[classify]\nfile = \"map.json\"")).unwrap();
    let transfer = read_scene(&path).unwrap().layers.remove(0).transfer.unwrap();
    assert_eq!(transfer.color(0.0), [1.0, 0.0, 0.0]);
    fs::remove_file(dir.path().join("map.json")).unwrap();
    let err = read_scene(&path).unwrap_err().to_string();
    assert!(err.contains("map.json"), "{err}");
}

#[test]
fn scene_classify_fits_a_volume() {
    let fit = |keys: &str| read_layer(&format!("{SMALL}[classify]\n{keys}")).fit;
    let keys = "colormap = \"viridis\"\nwindow = [-5, 10]\nopacity_scale = 0.5\nunit_distance = 2";
    let full = fit(keys);
    assert_eq!(full.colormap, colormap("viridis").ok());
    assert_eq!(full.stretch, Some(Stretch::Window([-5.0, 10.0])));
    assert_eq!((full.opacity_scale, full.unit_distance), (0.5, Some(2.0)));
    let percentiles = fit("preset = \"mr-t1\"\npercentile = [1, 99.5]");
    assert_eq!(percentiles.stretch, Some(Stretch::Percentiles([1.0, 99.5])));
    assert_eq!(percentiles.scale, ValueScale::Object { percentile: 99.0 });
    // Light of a preset counts where the scene has none of its own.
    let shading =
        |rest: &str| read_layer(&format!("{SMALL}[classify]\npreset = \"xray\"\n{rest}")).shading;
    assert_eq!(shading(""), Shading::None);
    assert_eq!(shading("[shading]\nambient = 0.1"), Shading::Phong(Phong::default()));
}

/// Typical mistakes about transfer functions, and the lines that they are in.
#[test]
fn scene_classify_says_what_does_not_fit() {
    let check = |keys: &str, expected: &str| {
        let error = read(&format!("{SMALL}[classify]\n{keys}")).unwrap_err();
        assert!(error.contains(expected), "{error} should contain {expected}");
    };
    for (keys, expected) in [
        ("colormap = \"jet\"", ":5: there is no colour map \"jet\": choose one of viridis"),
        ("window = [5, 5]", ":5: a window goes from a value to a greater one, not from 5 to 5"),
        ("percentile = [90, 10]", ":5: percentiles go from 0 to 100 and rise, not from 90 to 10"),
        ("percentile = [0, 101]", ":5: percentiles go from 0 to 100"),
        ("window = [0, 1]\npercentile = [1, 2]", ":6: window and percentile both"),
        ("opacity = [[0, 1]]\nwindow = [0, 1]", ":6: a window or percentiles move presets"),
        (
            "opacity = [[0, 1]]\ncolor = [[0, 1, 1, 1]]\ncolormap = \"hot\"",
            ":7: color and colormap",
        ),
        ("opacity_scale = -1", ":5: opacity is scaled by a number of at least 0, not by -1"),
        ("unit_distance = 0", ":5: the unit distance of opacity is a positive length, not 0"),
        ("boxes = []\nopacity_scale = 2", ":6: opacity_scale is for functions of the value alone"),
        ("colourmap = \"hot\"", "did you mean \"colormap\"?"),
    ] {
        check(keys, expected);
    }
}

#[test]
fn scene_unknown_keys_are_named() {
    let check = |text: &str, expected: &str| assert_eq!(read(text).unwrap_err(), expected);
    check(
        &format!("{SMALL}\n[render]\nslabwidth = 1.0\n"),
        "scene.toml:6: unknown key \"slabwidth\" in [render]; did you mean \"slab_width\"?",
    );
    check(
        &format!("{SMALL}\n[shading]\n\nlamp = 1.0\n"),
        "scene.toml:7: unknown key \"lamp\" in [shading]; known are ambient, diffuse, \
         zero_gradient, specular, shininess, two_sided, model",
    );
    check(
        &format!("{SMALL}\n[rendr]\nslab_width = 1.0\n"),
        "scene.toml:5: unknown section [rendr]; did you mean \"render\"?",
    );
    check(
        &format!("{SMALL}\n[image]\nwidth = 3\ngamma = 2.2\n"),
        "scene.toml:7: unknown key \"gamma\" in [image]; known are width, height, background",
    );
    check(
        "size = 3\n[volume]\ngenerate = \"cube\"",
        "scene.toml:1: unknown key \"size\"; known are volume, mesh, classify, labels, shading, \
         region, layers, camera, lights, image, render",
    );
}

#[test]
fn scene_bad_values_name_their_line() {
    let check = |text: &str, expected: &str| {
        let err = read(&format!("{SMALL}{text}")).unwrap_err();
        assert!(err.contains(expected), "{err} should contain {expected}");
        assert!(!err.contains('\n'), "{err} should be one line");
    };
    check("[render]\nmethod = \"raycast\"", ":5: \"raycast\" is not a choice here: use one of ima");
    check("[render]\nslab_width = -1.0", ":5: slab_width must be above 0");
    check("[render]\nslab_width = nan", ":5: slab_width");
    check(
        "[render]\nsections = -3",
        ":5: sections: invalid value: integer `-3`, expected a whole number",
    );
    check("[render]\nsections = 1", ":5: sections must be between 16 and 1024");
    check("[render]\nopacity_cutoff = 2", ":5: opacity_cutoff");
    check("[render]\ntolerance = 1", ":5: tolerance");
    check(
        "[render]\nslab_width = \"wide\"",
        ":5: slab_width: invalid type: string \"wide\", expected a number",
    );
    check("[image]\nwidth = 0", ":5: an image of 0 x 512");
    check("[image]\nbackground = [0, 0, 0]", ":5: background: invalid length 3");
    check("[image]\nbackground = [0, 0, 0, 2]", ":5: the background");
    check("[shading]\nambient = -1", ":5: ambient");
    check("[shading]\nmodel = \"toon\"", ":5: \"toon\" is not a choice");
    check("[shading]\ntwo_sided = 1", ":5: two_sided: invalid type: integer");
    check("[render]\nbackend = 1", ":5: backend: invalid type: integer");
    check("[[render]]", ":4: invalid type: sequence, expected a section");
    check("[[lights]]\nfrom = \"sun\"", ":5: \"sun\" is no light");
    check("[[lights]]\nfrom = [0, 0, 0]", ":5: the light's direction");
    check("[[lights]]\nfrom = \"headlight\"\ncolor = [-1, 0, 0]", ":4: the colour of a light");
    check(&"[[lights]]\nfrom = \"headlight\"\n".repeat(17), ":36: 17 lights are too many");
    check("[[lights]]\ncolor = [1, 1, 1]", ":4: missing field `from`");
    check("[camera]\nfov_y = 180", ":5: fov_y");
    check("[camera]\nview_height = 0", ":5: view_height");
    check("[camera]\neye = [0, inf, 0]", ":5: eye");
    check("[camera]\nprojection = \"fisheye\"", ":5: \"fisheye\" is not a choice");
    check("[classify]\nopacity = [[1, 0], [0, 1]]", ":5: point 1 of opacity is out of order");
    check("[classify]\nopacity = []", ":5: opacity needs at least one point");
    check("[classify]\ncolor = [[0, 1, 1, 1]]", ":5: color needs opacity");
    check("[classify]\nopacity = [[0, 1]]\ncolor = [[0, 1, 1, 7]]", ":6: point 0 of color");
    check("[classify]\npreset = \"gray\"\nfile = \"a\"", ":4: [classify] takes one of");
    check("[classify]\npreset = \"grey\"", ":5: there is no preset \"grey\"");
    check("[classify]\ngradient_opacity = [[0, 1.5]]", ":5: point 0 of gradient_opacity");
    check("[classify]\nboxes = []\npreset = \"gray\"", ":4: [classify] takes one of");
    check("[classify]\nboxes = [{ gradients = [0, 1] }]", ":5: missing field `values`");
    check("[classify]\nboxes = [{ values = [1, 0] }]", ":5: values go from the least to the");
    check("[classify]\nboxes = [{ values = [0, 1], fade = [0.6, 0] }]", "not over 0.6 of 0 to 1");
    check(
        "[classify]\nboxes = [{ values = [0, 1], opacity = 2 }]",
        ":5: the opacity of a transfer",
    );
    check("[classify]\nimage = { file = \"a.png\" }", ":5: missing field `values`");
    check("[classify]\nisosurfaces = [{ value = nan }]", ":5: an isosurface needs a finite value");
    check("[[classify.isosurfaces]]\nvalue = 1\nopacity = 2", "between 0 and 1, not at 2");
    check("[classify]\nisosurfaces = [{ opacity = 1 }]", ":5: missing field `value`");
    check("[classify]\nisosurfaces = [{ value = 1, alpha = 1 }]", ":5: unknown key \"alpha\"");
    check("[region]\nplanes = [[0, 0, 0, 1]]", ":5: a plane needs a finite normal");
    check("[region]\nplanes = [[0, 1, 0]]", ":5: planes: invalid length 3");
    check("[region]\nbox = [[0, 0, 0], [1, -1, 1]]", ":5: a box goes from its least");
    check("[region]\nbox = [[0, 0, 0], [1, nan, 1]]", ":5: a box goes from its least");
    check(
        "[region]\ninverted = true",
        ":5: unknown key \"inverted\" in [region]; did you mean \"invert\"?",
    );
    check("[labels]\ncolors = \"auto\"", ":4: missing field `path`");
    let styles = "[labels]\npath = \"a.nrrd\"\n[[labels.styles]]\nof = [1]\n";
    check(
        &format!("{styles}opacity = 2\n[[labels.styles]]\nof = [3, 1]"),
        "two styles are of label 1",
    );
    check(&format!("{styles}classify = {{}}"), "classify of a style needs opacity");
    check(&format!("{styles}classify = {{ isosurfaces = [{{ value = 1 }}] }}"), "and no label's");
    check("[[layers]]", ":1: [volume] belongs below [[layers]], as [layers.volume]");
    check("[volume]", ":4: ");
    check("x = [", ":4: ");
}

#[test]
fn scene_has_two_dimensional_transfer_functions() {
    let boxes = "[classify]\nboxes = [{ values = [2, 4], gradients = [1, inf], opacity = 0.5 }, { values \
                 = [5, 9], color = [1, 0, 0], fade = [2, 0] }]";
    let layer = read_layer(&format!("{SMALL}{boxes}"));
    let transfer = layer.transfer_2d.unwrap();
    assert!(layer.transfer.is_none() && (transfer.opacity(3.0, 7.0) - 0.5).abs() < 1e-12);
    assert_eq!(transfer.opacity(3.0, 0.5), 0.0);
    assert_eq!(transfer.at(6.0, 0.0).1, [1.0, 0.0, 0.0]);
    assert!((transfer.opacity(6.0, 0.0) - 0.5).abs() < 1e-12);
    let image = "[classify]\nimage = { file = \"no.png\", values = [0, 1], gradients = [0, 1] }";
    let error = read(&format!("{SMALL}{image}")).unwrap_err();
    assert!(error.contains("cannot read no.png"), "{error}");
}

const TWO_LAYERS: &str = r#"
[[layers]]
name = "ball"
[layers.volume]
generate = "sphere"
size = 9
[layers.region]
planes = [[1, 0, 0, 3]]

[[layers]]
[layers.volume]
path = "other.nrrd"
[layers.classify]
preset = "ct-bone"
[layers.shading]
ambient = 0.5
"#;

#[test]
fn scene_of_two_layers() {
    let scene = read(&format!("{TWO_LAYERS}[image]\nwidth = 9")).unwrap();
    let [ball, other] = scene.layers.as_slice() else { panic!("{:?}", scene.layers) };
    let sphere = VolumeSource::Builtin { name: "sphere".to_owned(), size: Some(9) };
    let planes = vec![Plane::new(DVec3::X, 3.0).unwrap()];
    let expected = LayerFile {
        name: Some("ball".to_owned()),
        region: RegionDesc { planes, ..RegionDesc::default() },
        ..LayerFile::of_volume(sphere)
    };
    assert_eq!(*ball, expected);
    assert_eq!((&other.name, other.transfer.is_some()), (&None, true));
    assert_eq!(other.shading, Shading::Phong(Phong::default().ambient(0.5)));
    assert_eq!(scene.image.width, 9);
}

#[test]
fn scene_of_labels() {
    let of = |text: &str| {
        let labels = format!("{SMALL}[labels]\npath = \"seg.nrrd\"\n{text}");
        read_layer(&labels).labels.expect("the section is there")
    };
    let plain = of("");
    assert!(plain.path.ends_with("seg.nrrd") && plain.path.is_absolute());
    assert_eq!(plain, LabelsFile::new(plain.path.clone()));
    assert_eq!(of("colors = \"auto\"").colors, Some(LabelColors::Automatic));
    let colors = of("colors = \"table.txt\"").colors;
    assert!(matches!(&colors, Some(LabelColors::Table(path)) if path.is_absolute()), "{colors:?}");
    let labels = of("only = [-1, 2]\n[[labels.styles]]\nof = [2, 3]\ncolor = [1, 0, 0.5]\n\
                     [[labels.styles]]\nof = [4]\nopacity = 0.25\nclassify = { preset = \"ct-bone\" }");
    assert_eq!(labels.only, Some(vec![-1, 2]));
    use slabsplat_core::LabelStyle;
    let red = LabelStyle { color: Some([1.0, 0.0, 0.5]), ..LabelStyle::default() };
    let own = LabelStyle {
        transfer: preset("ct-bone").ok().map(|preset| preset.source.transfer),
        opacity: 0.25,
        ..LabelStyle::default()
    };
    assert_eq!(labels.styles, [(2, red.clone()), (3, red), (4, own)].into());
}

#[test]
fn scene_layers_say_what_is_wrong() {
    let check = |text: &str, expected: &str| {
        let err = read(text).unwrap_err();
        assert!(err.contains(expected), "{err} should contain {expected}");
    };
    let changed = |from: &str, to: &str| TWO_LAYERS.replacen(from, to, 1);
    check("layers = []", "layers is empty");
    let hidden = "[[layers]]\nvisible = false\n[layers.volume]\ngenerate = \"cube\"\n";
    check(hidden, "no layer of the scene is visible");
    let visible = read(&format!("{hidden}{TWO_LAYERS}")).unwrap();
    assert_eq!((visible.layers.len(), visible.layers[0].name.as_deref()), (2, Some("ball")));
    check(&hidden.replace("generate", "generates"), ":4: unknown key \"generates\"");
    check("[[layers]]\nname = \"a\"", ":1: the scene has no [volume]");
    check(&format!("{TWO_LAYERS}[shading]\nambient = 1"), ":17: [shading] belongs below");
    check(&changed("ambient = 0.5", "ambient = -1"), ":16: ambient");
    check(&changed("[[1, 0, 0, 3]]", "[[0, 0, 0, 3]]"), ":8: a plane needs");
    check(&changed("ct-bone", "ct-bones"), ":14: there is no preset");
    check(&changed("generate", "generates"), ":5: unknown key \"generates\" in [layers.volume]");
}

/// A haze about an implant.
const WITH_MESH: &str = r#"
[[layers]]
[layers.volume]
generate = "sphere"

[[layers]]
name = "implant"
[layers.mesh]
path = "implant.stl"
color = [0.8, 0.75, 0.5]
affine = [[-1, 0, 0, 1], [0, -1, 0, 2], [0, 0, 1, 3]]
[layers.shading]
ambient = 0.5
[layers.region]
planes = [[1, 0, 0, 3]]
"#;

#[test]
fn scene_of_a_volume_and_a_mesh() {
    let scene = read(WITH_MESH).unwrap();
    let ([_], [implant]) = (scene.layers.as_slice(), scene.meshes.as_slice()) else {
        panic!("{scene:?}")
    };
    let name = implant.path.file_name().and_then(|name| name.to_str());
    assert_eq!((implant.name.as_deref(), name), (Some("implant"), Some("implant.stl")));
    assert_eq!(implant.color, Some([0.8, 0.75, 0.5]));
    let moved = implant.world_from_mesh.transform_point3(DVec3::ONE);
    assert_eq!(moved, DVec3::new(0.0, 1.0, 4.0));
    assert_eq!(implant.shading, Shading::Phong(Phong::default().ambient(0.5)));
    assert_eq!(implant.region.planes.len(), 1);
    let alone = read("[mesh]\npath = \"a.ply\"").unwrap();
    assert_eq!((alone.layers.len(), alone.meshes.len()), (0, 1));
    let plain = MeshFile::new(alone.meshes[0].path.clone());
    assert_eq!(alone.meshes, [plain]);
}

#[test]
fn scene_meshes_say_what_is_wrong() {
    let check = |from: &str, to: &str, expected: &str| {
        let err = read(&WITH_MESH.replacen(from, to, 1)).unwrap_err();
        assert!(err.contains(expected), "{err} should contain {expected}");
    };
    check("path = \"implant.stl\"", "", ":8: [mesh] needs a path");
    check("0.75, 0.5]", "0.75, 5]", ":10: color must be");
    check("[0, 0, 1, 3]]", "[0, 0, 0, 3]]", ":11: a mesh cannot be placed");
    check("[layers.region]", "[layers.region]\nindex = true", ":15: a mesh has no voxels");
    let classify = "[layers.classify]\npreset = \"ct-bone\"\n[layers.shading]";
    check("[layers.shading]", classify, ":12: a layer with a mesh has no [classify]");
    let volume = "[layers.volume]\npath = \"a\"\n[layers.shading]";
    check("[layers.shading]", volume, ":12: a layer with a mesh has no [volume]");
    check("color", "colour", ":10: unknown key \"colour\"");
}

#[test]
fn scene_loads_its_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.obj");
    fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\n").unwrap();
    let scene = "[mesh]\npath = \"a.obj\"\naffine = [[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 5]]";
    fs::write(dir.path().join("a.toml"), scene).unwrap();
    let scene = read_scene(dir.path().join("a.toml")).unwrap();
    let (layer, warnings) = scene.meshes[0].load().unwrap();
    assert_eq!(layer.bounds(), Some([DVec3::Z * 5.0, DVec3::new(2.0, 2.0, 5.0)]));
    assert!(warnings[0].ends_with("1 of 2 triangles are left out: 1 have no area"), "{warnings:?}");
    assert!(MeshFile::new(dir.path().join("b.obj")).load().is_err());
}

#[test]
fn scene_volume_is_one_thing() {
    let check = |text: &str, expected: &str| {
        let err = read(text).unwrap_err();
        assert!(err.contains(expected), "{err} should contain {expected}");
    };
    check("", "the scene has no [volume]");
    check("[volume]", ":1: [volume] needs a path");
    check("[volume]\npath = \"a\"\ngenerate = \"b\"", ":3: [volume] has both");
    check("[volume]\npath = \"a\"\nsize = 9", ":3: size goes with generate");
    check("[volume]\ngenerate = \"cube\"\nspacing = [1, 0, 1]", ":3: spacing must be");
    check("[volume]\ngenerate = \"cube\"\nsize = -1", ":3: size: invalid value");
}

#[test]
fn scene_loads_its_volume() {
    let loaded = read_layer(&format!("{SMALL}spacing = [1, 2, 3]")).load_volume().unwrap();
    assert_eq!(loaded.volume.grid().dims(), [8; 3]);
    assert_eq!(loaded.volume.grid().spacing(), [1.0, 2.0, 3.0]);
    assert_eq!(loaded.format.name(), "built-in");
    let teapot = read_layer("[volume]\ngenerate = \"teapot\"").load_volume().unwrap_err();
    assert!(teapot.to_string().contains("no built-in volume \"teapot\""), "{teapot}");
    let gone = read_layer("[volume]\npath = \"gone.nrrd\"").load_volume().unwrap_err();
    assert!(gone.to_string().starts_with("cannot read "), "{gone}");
}

#[test]
fn scene_chooses_a_volume_of_several() {
    let layer =
        read_layer("[volume]\npath = \"a.nii\"\nseries = 1\nchannel = 2\ntime = 3\nlevel = 4\n");
    let expected = VolumeOptions::default().series(1).channel(2).time(3).level(4);
    assert_eq!(layer.options, expected);
    assert!(!layer.shares_volume(&read_layer("[volume]\npath = \"a.nii\"")));
    let keys = "path = \"a.nii\"\ncolors = \"none\"\nopacity_from = \"alpha\"\n";
    let colors = VolumeOptions::default().colors(ColorUse::None).opacity_from(OpacitySource::Alpha);
    assert_eq!(read_layer(&format!("[volume]\n{keys}")).options, colors);
    let error = read("[volume]\npath = \"a.nii\"\nopacity_from = \"red\"").unwrap_err();
    assert!(error.to_string().contains("\"red\" is none of: luminance, alpha"), "{error}");
    let error = read_layer(&format!("{SMALL}time = 1")).load_volume().unwrap_err().to_string();
    assert_eq!(error, "cube: there is no time 1: there is only 0");
    let error = read("[volume]\npath = \"a.nii\"\nallow_external = true").unwrap_err();
    assert!(error.to_string().contains("allow_external"), "a scene cannot permit itself more");
}

#[test]
fn scene_must_be_there() {
    let err = read_scene(Path::new("/nonexistent/scene.toml")).unwrap_err().to_string();
    assert!(err.starts_with("cannot read /nonexistent/scene.toml: "), "{err}");
}

/// A volume that layers share is loaded once, and warned of once.
#[test]
fn scene_loads_each_volume_once() {
    let cube = |size| LayerFile::of_volume(VolumeSource::Builtin { name: "cube".into(), size });
    let stretched = LayerFile { spacing: Some([1.0, 1.0, 2.0]), ..cube(Some(8)) };
    let layers = [cube(Some(8)), cube(Some(9)), stretched, cube(Some(8))];
    let mut n_loaded = 0;
    let volumes = LayerFile::load_volumes(&layers, |layer| {
        n_loaded += 1;
        let loaded = layer.load_volume()?;
        Ok::<_, IoError>(LoadedVolume { warnings: vec!["once".to_owned()], ..loaded })
    });
    let volumes = volumes.unwrap();
    assert_eq!((n_loaded, volumes.len()), (3, 4));
    assert!(Arc::ptr_eq(&volumes[0].volume, &volumes[3].volume));
    assert_eq!(volumes[2].volume.grid().spacing(), [1.0, 1.0, 2.0]);
    assert_eq!(volumes.iter().map(|loaded| loaded.warnings.len()).sum::<usize>(), 3);
}
