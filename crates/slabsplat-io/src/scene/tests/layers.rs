//! Scenes of several things: volumes, labels and meshes.

use super::*;

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
    let red = LabelStyle::default().color([1.0, 0.0, 0.5]);
    let own = preset("ct-bone").unwrap().source.transfer;
    let own = LabelStyle::default().transfer(own).opacity(0.25);
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
    for (key, bad) in [("line_width", "0"), ("line_width", "inf"), ("point_size", "-1")] {
        let with_key = format!("{key} = {bad}\n[layers.shading]");
        check("[layers.shading]", &with_key, &format!(":12: {key} must be above 0"));
    }
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
