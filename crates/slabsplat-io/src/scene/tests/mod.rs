//! Whole scene files.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use slabsplat_core::glam::DVec3;
use slabsplat_core::{
    Annotations, Field, KernelName, Light, Lookup, Method, Mode, Normalization, Phong, Plane,
    ProjectionKind, Setting, Settings, Shading,
};

use super::*;
use crate::{ColorUse, OpacitySource, Stretch, ValueScale, colormap, preset};

mod classify;
mod film;
mod layers;

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
background_below = [0.0, 0.5, 1.0, 1.0]
samples = 4

[annotations]
title = "a title"
axes = true
scale_bar = true
color_bar = true
orientation_marker = true

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
    assert_eq!(scene.image, ImageDesc::new(64, 32).background(background));
    assert_eq!(
        (scene.finish.samples, scene.finish.background_below),
        (4, Some([0.0, 0.5, 1.0, 1.0]))
    );
    let Annotations { title, axes, scale_bar, color_bar, orientation_marker, .. } =
        scene.finish.annotations;
    assert_eq!(title.as_deref(), Some("a title"));
    assert!(axes && scale_bar && color_bar && orientation_marker);
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
        "scene.toml:7: unknown key \"gamma\" in [image]; known are width, height, background, \
         background_below, samples",
    );
    check(
        &format!("{SMALL}\n[annotations]\nscalebar = true\n"),
        "scene.toml:6: unknown key \"scalebar\" in [annotations]; did you mean \"scale_bar\"?",
    );
    check(
        "size = 3\n[volume]\ngenerate = \"cube\"",
        "scene.toml:1: unknown key \"size\"; known are volume, mesh, classify, labels, shading, \
         region, layers, camera, lights, image, annotations, render, film",
    );
}

#[test]
fn scene_finish() {
    let text = "[image]\nsamples = 9\nbackground_below = [0, 0.5, 1, 1]\n\
                [annotations]\ntitle = \"A head\"\naxes = true\ncolor_bar = true\n";
    let annotations = Annotations::default().title("A head").axes().color_bar();
    let below = [0.0, 0.5, 1.0, 1.0];
    let expected = Finish::default().samples(9).background_below(below).annotations(annotations);
    assert_eq!(read(&format!("{SMALL}{text}")).unwrap().finish, expected);
    let check = |text: &str, expected: &str| {
        let error = read(&format!("{SMALL}{text}")).unwrap_err();
        assert!(error.contains(expected), "{error} should contain {expected}");
    };
    check("[image]\n\nsamples = 8\n", ":6: samples of a pixel are 1, 4, 9,");
    check("[image]\nsamples = 100\n", ":5: samples of a pixel are 1, 4, 9,");
    check("[image]\nwidth = 32768\nsamples = 4\n", ":6: 4 samples for each of 32768 x");
    check("[image]\nbackground_below = [2, 0, 0, 1]\n", ":5: the background must be");
    let gradient = "[image]\nbackground = \"white:navy\"\n";
    check(
        &format!("{gradient}background_below = \"red\"\n"),
        ":6: background is a gradient already",
    );
    check("[image]\nbackground_below = \"red:navy\"\n", ":5: background_below is one colour");
    check("[annotations]\ntitle = \"\"\n", ":5: a title says something");
    check("[annotations]\ntitle = \"a\\nb\"\n", ":5: a title is one line");
    check("[annotations]\naxes = 1\n", ":5: ");
}

/// A scene file says colours as the flag `--background` does.
#[test]
fn scene_background_by_name() {
    let check = |lines: &str, above: [f32; 4], below: Option<[f32; 4]>| {
        let scene = read(&format!("{SMALL}[image]\n{lines}")).unwrap();
        assert_eq!((scene.image.background, scene.finish.background_below), (above, below));
    };
    let blue = [0.0, 0.0, 1.0, 1.0];
    check("background = \"blue\"\n", blue, None);
    check("background = \"#0000ff80\"\n", [0.0, 0.0, 1.0, 128.0 / 255.0], None);
    check("background = [0, 0, 1]\n", blue, None);
    check("background = \"0,0,1:white\"\n", blue, Some([1.0; 4]));
    check("background = \"white\"\nbackground_below = \"#00f\"\n", [1.0; 4], Some(blue));
    check("background_below = [0, 0, 1]\n", [0.0; 4], Some(blue));
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
    check(
        "[image]\nbackground = [0, 0]",
        ":5: background: invalid length 2, expected 3 or 4 numbers",
    );
    check("[image]\nbackground = \"wite\"", ":5: \"wite\" is no colour: name one of CSS");
    check("[image]\nbackground = \"2,0,0\"", ":5: red, green, blue and opacity are from 0 to 1");
    check("[image]\nbackground = 1", ":5: background: invalid type: integer");
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
