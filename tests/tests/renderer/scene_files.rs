//! A scene that is written as a scene file and read again is the same scene, and to the last bit the same
//! picture.

use fastrand::Rng;
use slabsplat::io::{self, LabelColors, LabelsFile, LayerFile, MeshFile, SceneFile, VolumeSource};
use slabsplat::{
    Grid, Labels, Layer, MeshLayer, Method, OpenScene, Samples, Scaling, Scene, Volume,
};
use slabsplat_seeds::for_each_numbered_seed;
use slabsplat_tests::random_scene::{
    SceneKind, add_gradient_opacity, add_labels, add_lights, add_transfer_2d, random_layers,
    random_meshes,
};
use slabsplat_tests::render::render;
use std::fmt::Write;
use std::path::Path;

#[test]
fn scene_files_give_the_same_picture() {
    for_each_numbered_seed(1, |seed, mut rng| {
        for kind in SceneKind::share(seed).step_by(6) {
            let mut scene = scene(&mut rng, &kind);
            let dir = tempfile::tempdir().expect("there is room for files");
            let sources = sources(&mut scene, dir.path());
            let file = sources.completed(&scene).expect("labels are from files");
            let path = dir.path().join("scene.toml");
            io::write_scene(&path, &file).expect("the scene is written");
            let read = io::read_scene(&path).expect("it is read again");
            assert_eq!(read, file, "{kind:?}");
            let opened = OpenScene::open(&read).expect("its files are there");
            let is_other = |warning: &&String| warning.contains("the scene was made of");
            assert_eq!(opened.warnings.iter().find(is_other), None, "{kind:?}");
            assert_same(&opened.scene, &scene);
            assert_eq!(opened.to_file().expect("labels are from files"), read, "{kind:?}");
            // Over what is open already it is the same, too.
            let plain = OpenScene::open(&sources).expect("its files are there");
            assert_same(&plain.shown_as(&read).expect("it is of this scene").scene, &scene);
            assert!(render("cpu", &opened.scene) == render("cpu", &scene), "{kind:?}");
        }
    });
}

/// With all that its method has.
fn scene(rng: &mut Rng, kind: &SceneKind) -> Scene {
    let has_regions = kind.method == Method::ImageAligned || kind.method == Method::PostClassified;
    let mut scene =
        if has_regions && rng.bool() { random_meshes(rng, kind) } else { random_layers(rng, kind) };
    if !has_regions {
        scene.layers.iter_mut().for_each(|layer| layer.region = slabsplat::Region::default());
    }
    if kind.method != Method::PostClassified {
        let add = [add_labels, add_gradient_opacity, add_transfer_2d];
        add.into_iter().filter(|_| rng.bool()).collect::<Vec<_>>().into_iter().for_each(|add| {
            add(rng, &mut scene);
        });
    }
    add_lights(rng, &mut scene);
    scene
}

/// Puts volumes, labels and meshes into files.
fn sources(scene: &mut Scene, folder: &Path) -> SceneFile {
    let mut file = SceneFile::of_mesh("none.ply");
    file.meshes.clear();
    for (idx, layer) in scene.layers.iter_mut().enumerate() {
        let path = folder.join(format!("{idx}.raw"));
        io::write_volume(&path, &layer.volume).expect("the volume is written");
        let mut of_file = LayerFile::of_volume(VolumeSource::File(path));
        if let Some(labels) = &layer.labels {
            let labels =
                labels_file(labels, layer.volume.grid(), &folder.join(format!("l{idx}.raw")));
            layer.labels = Some(labels.load(layer.volume.grid()).expect("they are labels").0);
            of_file.labels = Some(labels);
        }
        file.layers.push(of_file);
    }
    for (idx, mesh) in scene.meshes.iter_mut().enumerate() {
        let path = folder.join(format!("{idx}.ply"));
        std::fs::write(&path, ply(mesh)).expect("the mesh is written");
        let of_file = MeshFile::new(path);
        mesh.mesh = of_file.load().expect("it is a mesh").0.mesh;
        file.meshes.push(of_file);
    }
    file
}

fn labels_file(labels: &Labels, grid: &Grid, path: &Path) -> LabelsFile {
    let map = labels.map();
    let label = |idx: &u16| map.labels()[usize::from(*idx)] as i32;
    let samples = Samples::I32(map.indices().iter().map(label).collect());
    let volume = Volume::new(*grid, samples, Scaling::IDENTITY).expect("a label a voxel");
    io::write_volume(path, &volume).expect("labels are written");
    let mut file = LabelsFile::new(path.to_owned());
    file.colors = Some(LabelColors::None);
    file.styles = labels.styles().clone();
    file
}

/// Vertices and triangles, with colours if there are any.
fn ply(mesh: &MeshLayer) -> String {
    let mesh = &mesh.mesh;
    let has_colors = mesh.vertex_color(0).is_some();
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n",
        mesh.positions().len()
    );
    if has_colors {
        text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    }
    let n_triangles = mesh.triangles().len();
    text += &format!(
        "element face {n_triangles}\nproperty list uchar uint vertex_indices\nend_header\n"
    );
    for (vertex, position) in mesh.positions().iter().enumerate() {
        let color = mesh.vertex_color(vertex).unwrap_or_default().map(|c| (255.0 * c) as u8);
        let [r, g, b] = color;
        let color = if has_colors { format!(" {r} {g} {b}") } else { String::new() };
        writeln!(text, "{} {} {}{color}", position.x, position.y, position.z).expect("text grows");
    }
    for [a, b, c] in mesh.triangles() {
        writeln!(text, "3 {a} {b} {c}").expect("text grows");
    }
    text
}

/// But for where in memory things are.
fn assert_same(read: &Scene, scene: &Scene) {
    assert_eq!(read.camera, scene.camera);
    assert_eq!(read.lights, scene.lights);
    assert_eq!(read.image, scene.image);
    assert_eq!(read.settings, scene.settings);
    assert_eq!(read.layers.len(), scene.layers.len());
    for (read, layer) in read.layers.iter().zip(&scene.layers) {
        let labels = match (&read.labels, &layer.labels) {
            (Some(read), Some(labels)) => {
                assert!(read.map() == labels.map() && read.styles() == labels.styles());
                Some(labels.clone())
            }
            (None, None) => None,
            other => panic!("{other:?}"),
        };
        assert_eq!(read.volume.grid(), layer.volume.grid());
        assert_eq!(read.volume.samples().sample_type(), layer.volume.samples().sample_type());
        let read: Layer = read.clone().volume(layer.volume.clone()).labels(labels);
        assert_eq!(read, *layer);
    }
    assert_eq!(read.meshes.len(), scene.meshes.len());
    for (read, mesh) in read.meshes.iter().zip(&scene.meshes) {
        assert!(read.mesh == mesh.mesh, "another mesh");
        let mut read = read.clone();
        read.mesh = mesh.mesh.clone();
        assert_eq!(read, *mesh);
    }
}
